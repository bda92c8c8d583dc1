"""FRFs as evidence on parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from flexmodal.errors import Fault
from flexmodal.identification.evidence.evidence import Evidence, Fitted, Key, few
from flexmodal.identification.frf_fit import FLOORS, FrfMisfit, Weighting, normal_equations
from flexmodal.identification.gap import Gap, gap, over_noise
from flexmodal.identification.model import FrfModel, predict
from flexmodal.identification.observations import Observations
from flexmodal.identification.shared import shared_misfit
from flexmodal.identification.uncertainty import Uncertainty, clusters, uncertainty
from flexmodal.structure.parameter import ParameterSpace

QUICK_LINES = 120
"""Lines of each FRF that a first look takes."""
SHARE_ABOVE_NOISE = 0.05
"""Of all lines, that must be above the noise for a fit to make sense."""


@dataclass(frozen=True, eq=False)
class FrfEvidence(Evidence):
    """FRFs, line by line."""

    model: FrfModel
    observations: Observations
    share: Float[np.ndarray, " observation"] | None = None
    """Multiple of each observation's weight in the fit; 1 if None."""

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        return self.model.space

    @property
    def what(self) -> str:
        """The data in words."""
        return "the FRFs"

    @property
    def count(self) -> int:
        """Two for each usable line."""
        return 2 * int(self.observations.used.sum())

    def faults(self) -> list[Fault]:
        """Nothing but noise, or too little of anything else."""
        source = str(self.observations.campaign.path or "campaign")
        return self.noise_faults() or few(source, self.count, len(self.space), "usable values in FRFs")

    def noise_faults(self) -> list[Fault]:
        """Nothing but noise."""
        used = float(self.observations.used.mean()) if self.observations.used.size else 0.0
        if used >= SHARE_ABOVE_NOISE:
            return []
        found = f"{100 * used:.1f} % of the lines above the noise"
        allowed = f"{100 * SHARE_ABOVE_NOISE:g} % or more: harder blows, more averages, another band"
        return [Fault(str(self.observations.campaign.path or "campaign"), "frfs", found, allowed)]

    def floors(self, *, quick: bool = False, warm: bool = False) -> Sequence[float]:
        """Of the complex logarithm."""
        return FLOORS[:2] if quick else FLOORS[-1:] if warm else FLOORS

    def misfit(
        self, x: Float[np.ndarray, " parameter"], floor: float, *, near: bool = True, quick: bool = False
    ) -> FrfMisfit:
        """On every line, or every so many at a first look; nothing is paired.

        Until the last model error steps need not be exact: what records cut off is not differentiated.
        """
        seen = self.observations if floor == FLOORS[-1] else replace(self.observations, cut_slopes=False)
        stride = max(1, len(self.observations.axis) // QUICK_LINES) if quick else 1
        lines = np.arange(stride // 2, len(self.observations.axis), stride)
        return FrfMisfit(self.model, seen, Weighting(floor, lines, self.share))

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """JᵀWJ at the card, with the noise of the lines."""
        card = np.zeros(len(self.space))
        ideal = replace(self.observations, value=predict(self.model, card, self.observations))
        weighing = Weighting(0.01, np.arange(len(ideal.axis)))
        return normal_equations(self.model, card, ideal, weighing).curvature

    def clusters(self) -> Int[np.ndarray, " observation"]:
        """Those of one posture, sensor place and hammer position."""
        return clusters(self.observations)

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """By clusters."""
        return uncertainty(self.space, fitted.normal, self.observations)

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation *entry"]:
        """Receptances [m/N]."""
        return predict(self.model, x, self.observations)

    def gap(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> Gap:
        """Of the file formats."""
        return gap(self.observations, predicted)

    def over_noise(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> float:
        """On the lines that are fitted."""
        return over_noise(self.observations, predicted)

    def shared_misfit(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> float | None:
        """Of the lines that are fitted; None where no FRF has enough of them."""
        found = shared_misfit(self.observations, predicted)
        return found if np.isfinite(found) else None

    def folds(self) -> Mapping[Key, Bool[np.ndarray, " observation"]]:
        """Postures, and points that carried the sensor."""
        seen = self.observations
        found: dict[Key, np.ndarray] = {
            ("posture", posture.name): seen.posture == number for number, posture in enumerate(seen.postures)
        }
        for point in seen.campaign.points:
            rows = seen.response[:, 0] == point.id
            if rows.any():
                found["point", point.name] = rows
        return found

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> FrfEvidence:
        """See `Evidence`."""
        share = None if self.share is None else self.share[keep]
        return replace(self, observations=self.observations.keeping(keep), share=share)
