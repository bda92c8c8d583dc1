"""Coarse looks at hypotheses: few lines and hinges, and levels of force as one where a model knows none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.disagreement.compare import but_for_the_blow
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.search.lines import COARSE, some_lines
from flexmodal.diagnosis.time_domain.model import TimeDomainModel, has_law
from flexmodal.diagnosis.time_domain.secant import fitted_by_secants
from flexmodal.identification import Observations, unlimited
from flexmodal.identification.descent import robust
from flexmodal.identification.frf_fit import FrfMisfit, Weighting, fit, residual

ROUGH = 5.0
"""Steps of time in a period of the highest line, of the coarse looks."""
FROM_STAND_INS = 0.2
"""Model error from which derivatives along parameters of no law are those of the stand-ins. With them at 0.1
too, and in close fits, a friction of fifteen noise floors ended a seventh farther from the data."""
FEW = 3
"""Postures of these."""
ROUGHLY = 1e-2
"""A step that changes the cost of integrated torques relatively by less is the last."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A hypothesis on its way."""

    hypothesis: Hypothesis
    x: Float[np.ndarray, " parameter"]
    cost: float
    """On coarse lines at the last round's model error."""

    @property
    def key(self) -> tuple[str, str]:
        """Name and place of the effect it adds last."""
        return self.hypothesis.keys[-1]


@dataclass(frozen=True, eq=False)
class Look:
    """Observations as the coarse looks see them: levels of force apart, and as one.

    A model without force levels is as far from the mean over them as from each, but for a constant.
    """

    apart: Observations
    merged: Observations
    share: Float[np.ndarray, " observation"]
    """How many levels each merged observation stands for."""
    owner: Int[np.ndarray, " apart"]
    """The merged observation of each."""
    lines: Int[np.ndarray, " line"]
    straight: bool = False
    """Whether torques count as their stand-ins at one amplitude, and nothing is integrated."""

    def integrates(self, hypothesis: Hypothesis) -> bool:
        """Whether torques of a hypothesis are integrated in time.

        Args:
            hypothesis: of any effects.
        """
        return not self.straight and has_law(hypothesis)

    @cached_property
    def some(self) -> Observations:
        """Those of a few postures, for torques that are integrated."""
        number = np.unique(self.apart.posture)
        few = number[np.linspace(0, len(number) - 1, min(FEW, len(number))).round().astype(int)]
        return self.apart.keeping(np.isin(self.apart.posture, few))

    def integrated(self, hypothesis: Hypothesis, floor: float) -> FrfMisfit:
        """Misfit of a hypothesis with torques that are integrated, in long steps and some postures.

        Args:
            hypothesis: with such torques.
            floor: model error ε of a residual.
        """
        share = np.full(len(self.some), len(self.apart) / len(self.some))
        model = TimeDomainModel(with_few_hinges(hypothesis), ROUGH, rough=floor >= FROM_STAND_INS)
        return FrfMisfit(model, self.some, Weighting(floor, self.lines, share))

    def constant(self, floor: float) -> float:
        """What the mean hides of the sum of squares."""
        weight = Weighting(floor, self.lines).weight(self.apart)
        between = residual(self.merged.value[self.owner][:, self.lines], self.apart.value[:, self.lines])
        return float(np.sum(robust(weight * np.abs(between) ** 2)))

    def started(
        self,
        hypothesis: Hypothesis,
        starts: Sequence[Float[np.ndarray, " parameter"]],
        floor: float,
        most: int,
    ) -> list[Candidate]:
        """The best of some starts, not fitted yet; none at which there is no model.

        Args:
            hypothesis: with one effect more.
            starts: coordinates to look at.
            floor: model error ε of a residual.
            most: how many are kept.
        """
        seen = self.apart if hypothesis.by_force else self.merged
        misfit = FrfMisfit(with_few_hinges(hypothesis), seen, Weighting(floor, self.lines))
        if self.integrates(hypothesis):
            misfit = self.integrated(hypothesis, floor)
        costs = [misfit.cost(one) for one in starts]
        best = [k for k in np.argsort(costs, kind="stable")[:most] if np.isfinite(costs[k])]
        return [Candidate(hypothesis, starts[k], costs[k]) for k in best]

    def fitted(self, one: Candidate, floor: float, steps: int) -> Candidate:
        """A candidate some steps further.

        Args:
            one: the candidate.
            floor: model error ε of a residual.
            steps: of the fit, at most.
        """
        if self.integrates(one.hypothesis):
            near = fitted_by_secants(
                self.integrated(one.hypothesis, floor), one.x, steps=steps, settled=ROUGHLY
            )
            return Candidate(one.hypothesis, near.x, near.cost)
        with_force = one.hypothesis.by_force
        seen, share = (self.apart, None) if with_force else (self.merged, self.share)
        made = fit(
            with_few_hinges(one.hypothesis), seen, one.x, floors=(floor,), steps=steps, lines=self.lines,
            share=share, apart=False,
        )  # fmt: skip
        more = 0.0 if with_force else self.constant(floor)
        return Candidate(one.hypothesis, made.x, made.cost + more)


def with_few_hinges(hypothesis: Hypothesis) -> Hypothesis:
    """The model with as few hinges in its links as may be; its parameters are the same.

    Args:
        hypothesis: of any effects.
    """
    return replace(hypothesis, context=hypothesis.context.rough)


def look_at(observations: Observations, more: Sequence[int] | Int[np.ndarray, " more"] = ()) -> Look:
    """Prepare the coarse looks.

    Args:
        observations: what is looked at.
        more: lines besides those that are spread over the band.
    """
    observations = unlimited(observations)
    owner = but_for_the_blow(observations)
    first = np.unique(owner, return_index=True)[1]
    share = np.bincount(owner).astype(float)
    value, variance = np.zeros((2, len(share), observations.value.shape[1]), dtype=complex)
    used = np.ones(value.shape, dtype=bool)
    np.add.at(value, owner, observations.value)
    np.add.at(variance, owner, observations.variance)
    np.logical_and.at(used, owner, observations.used)
    keep = np.zeros(len(observations), dtype=bool)
    keep[first] = True
    kept = observations.keeping(keep)
    order = np.argsort(np.argsort(first))
    back = np.argsort(order)
    merged = replace(
        kept,
        value=(value / share[:, None])[back],
        variance=(variance.real / share[:, None])[back],
        used=used[back],
    )
    lines = np.union1d(some_lines(observations, COARSE), np.array(more, dtype=int))
    return Look(observations, merged, share[back], order[owner], lines)
