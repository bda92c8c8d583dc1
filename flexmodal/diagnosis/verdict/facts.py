"""What a verdict goes by, whatever the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.lawfree.result import Findings as LawFree
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.verdict.unlike import Unlike


@dataclass(frozen=True, eq=False)
class Facts:
    """A forward selection that has ended."""

    steps: tuple[Step, ...]
    says: Mapping[str, str]
    """What each effect is, in words."""
    gaps: Gaps
    over_noise: float | None
    """Distance of the final model from the measurement over that of the noise; None where the scatter is
    inferred along, so that nothing says where noise begins."""
    reached: Answer
    """Whether that is noise."""
    lacking: Mapping[int, float]
    """Measured modes that the final model has none for: number, frequency [Hz]."""
    open_: bool
    """Whether something gains enough though nothing was added."""
    place: str
    """Where to look if it has no name."""
    untestable: tuple[str, ...] = ()
    """Effects that these data cannot tell of."""
    refused: tuple[str, ...] = ()
    """Sentences on effects that were asked for by their place and not added."""
    undecided: tuple[str, ...] = ()
    """Sentences on figures too near to their threshold for a yes or a no."""
    cut_off: tuple[str, ...] = ()
    """A sentence, where looking for effects was cut off."""
    standing: tuple[tuple[str, str], ...] = ()
    """Effects that are sure although their laws leave more than noise."""
    told: bool = False
    """Whether some of these were told by their functions without a law."""
    lacking_at: tuple[str, ...] = ()
    """Places of what is missing besides."""
    contradicted: bool = False
    """Whether several effects stand for what one place explains at which none of them sits."""
    unlike: tuple[Unlike, ...] = ()
    """Effects that do what nothing of their name does, or may."""
    comes_close: bool = False
    """Whether one of the effects has a law that leaves next to nothing where it is right."""
    kind: str = ""
    """Of the region that disagrees most at the end."""
    share: float | None = None
    """Part of the disagreement above the noise that all effects take; None where that has no figure."""
    look: LawFree | None = None
    """What was found without a law."""
    modal: Findings | None = None
    """What measured modes say, where they decide."""

    @property
    def tied(self) -> bool:
        """Whether a tie keeps the question open.

        One between sets of beliefs does; one between draws of a bootstrap has a probability that is told.
        """
        return self.modal is not None and bool(self.modal.tied)
