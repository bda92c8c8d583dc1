"""What a diagnosis knows of measured modes, for the report."""

from __future__ import annotations

from dataclasses import dataclass

from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.variants import FittedModes
from flexmodal.identification.evidence.likelihood.errors import Errors
from flexmodal.identification.evidence.likelihood.held_out import HeldOut
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.shapes import ModeShapes
from flexmodal.identification.evidence.measured_modes import ModeObservations


@dataclass(frozen=True, eq=False)
class ModesSeen:
    """Measured modes and what models have in their place, whatever these were fitted to."""

    measured: ModeObservations
    before: ModalFit
    """The robot re-tuned, nothing added."""
    after: ModalFit
    """The final model; from modes alone without a step the best of what was compared."""
    held_before: HeldOut | None
    held_after: HeldOut | None
    mean: Errors
    """Errors of the mean of the other postures."""
    free: ModalFit | None = None
    """With one more mode that has no structure."""
    held_free: HeldOut | None = None


@dataclass(frozen=True, eq=False)
class Findings:
    """What a diagnosis from modes alone knows besides: comparisons of its first round."""

    modes: ModesSeen
    comparison: Comparison[FittedModes]
    """Of the first round."""
    tied: tuple[tuple[str, str], ...]
    """Explanations that these data cannot tell apart; empty where they can."""
    missing: tuple[tuple[int, float], ...]
    """Measured modes that the robot re-tuned lacks in at least half the postures: number, frequency [Hz]."""
    left: tuple[tuple[int, float], ...]
    """The same for the final model, or the best that was compared."""
    shapes: tuple[ModeShapes, ...]
    """The best two explanations with structure compared, shape by shape."""
    compared: tuple[tuple[str, str], tuple[str, str]] | None
    """These two."""
    told: bool
    """Whether the effects to look for were named."""
