"""Weigh explanations of measured modes, under several beliefs: a margin that a prior turns is a tie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modes.evidence import ModalFit
from flexmodal.diagnosis.modes.forecast import Explanation
from flexmodal.diagnosis.modes.held_out import HeldOut
from flexmodal.diagnosis.modes.measured import MeasuredModes
from flexmodal.diagnosis.modes.scatter import Beliefs
from flexmodal.diagnosis.modes.search import followed

TIED = 5.0
"""Margin of evidence under which two explanations are tied [nat]."""


@dataclass(frozen=True)
class Variant:
    """One set of beliefs."""

    name: str
    trust: float = 1.0
    """Factor on the priors of the robot's parameters."""
    stretch: float = 1.0
    """The same for those of what is added."""
    beliefs: Beliefs = field(default_factory=Beliefs)

    def of(self, explanation: Explanation) -> Explanation:
        """An explanation with these priors."""
        old = explanation.hypothesis
        base = old.base.trusting({p.name: p.deviation * self.trust for p in old.base})
        return Explanation(Hypothesis(old.context, base, old.placed), explanation.free, self.stretch)


VARIANTS = (
    Variant("as believed"),
    Variant("card trusted twice as far", trust=0.5),
    Variant("card trusted half as far", trust=2.0),
    Variant("wider priors of what is added", stretch=2.0),
    Variant("frequencies and damping alone", beliefs=Beliefs(shapes=False)),
    Variant("more peaks that are no modes", beliefs=Beliefs(spurious=1.5)),
)


@dataclass(frozen=True, eq=False)
class Candidate:
    """One explanation, fitted and looked at from all sides."""

    fit: ModalFit
    """Under the first variant."""
    evidence: tuple[float, ...]
    """ln of the evidence under each variant [nat]."""
    held: HeldOut | None = None

    @property
    def key(self) -> tuple[str, str]:
        """What it adds last, and where."""
        return self.fit.explanation.key


def under_variants(fits: Sequence[ModalFit], measured: MeasuredModes) -> Candidate:
    """Fit again under every variant, from where several fits under the first ended."""
    best = fits[0]
    found = [best.evidence]
    for variant in VARIANTS[1:]:
        near = [replace(one, beliefs=variant.beliefs) for one in fits[:2]]
        again = followed(variant.of(best.explanation), measured, near, variant.beliefs)
        found.append(again[0].evidence if again else -np.inf)
    return Candidate(best, tuple(found))


@dataclass(frozen=True, eq=False)
class Scales:
    """What weighing several candidates says; the first is the robot without anything new."""

    candidates: tuple[Candidate, ...]

    @property
    def table(self) -> np.ndarray:
        """Evidence [candidate variant] over that of the best of each variant."""
        table = np.array([one.evidence for one in self.candidates])
        return table - table.max(axis=0)

    @property
    def probability(self) -> np.ndarray:
        """Of each candidate: mean over the variants."""
        weight = np.exp(self.table)
        return (weight / weight.sum(axis=0)).mean(axis=1)

    @property
    def order(self) -> list[int]:
        """Candidates, the most probable first."""
        return [int(k) for k in np.lexsort((-self.table[:, 0], -self.probability.round(6)))]

    def gain(self, number: int) -> float:
        """What a candidate gains over the robot without anything new, in the worst variant [nat]."""
        return float(np.min(self.table[number] - self.table[0]))

    def first_gain(self, number: int) -> float:
        """The same under the first beliefs."""
        return float(self.table[number, 0] - self.table[0, 0])

    @property
    def tied(self) -> list[int]:
        """Candidates that come within `TIED` of the best under some variant."""
        close = np.any(self.table >= -TIED, axis=1)
        return [k for k in self.order if close[k]]
