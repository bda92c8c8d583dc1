"""From many hypotheses to a few fitted well: coarse looks at all, closer looks at those that do best.

Every hypothesis starts at the card, not at the re-tuned robot: re-tuning without the effect runs away from
the truth. Rounds of more steps with fewer candidates follow one another (successive halving).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.hypothesis import Hypothesis, Placed
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import FrfFit, Weighing, cost_of, fit

COARSE = 64
"""Lines of the coarse looks."""
CLOSE = 240
"""Lines of the closer ones."""
STARTS = 2
"""Starts that are kept for each effect and place."""
ROUNDS = ((0.2, 3, 24), (0.1, 5, 12), (0.03, 8, 6))
"""Model error, steps, and how many candidates go on."""


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


def stride_for(observations: Observations, lines: int) -> int:
    """Every how many lines to look at to look at about so many."""
    return max(1, len(observations.axis) // lines)


def unlimited(observations: Observations) -> Observations:
    """As if every record lasted until all is still: what is cut off is a matter for the close look."""
    return replace(observations, lengths=tuple(0.0 for _ in observations.lengths))


def candidates(
    root: Hypothesis, starts_from: Float[np.ndarray, " before"], effects: Sequence[Effect],
    observations: Observations,
) -> list[Candidate]:  # fmt: skip
    """Every effect in every place beside what the root holds already, at its best starts."""
    observations = unlimited(observations)
    stride = stride_for(observations, COARSE)
    weighing = Weighing(ROUNDS[0][0], np.arange(stride // 2, len(observations.axis), stride))
    found = []
    for effect in effects:
        if effect.untestable(root.scene):
            continue
        for where in effect.places(root.scene):
            if (effect.name, where) in root.keys:
                continue
            placed = Placed(effect, where)
            hypothesis = root.and_also(placed)
            tried = [
                hypothesis.start(placed, start, starts_from) for start in effect.starts(root.scene, where)
            ]
            costs = [cost_of(hypothesis, x, observations, weighing) for x in tried]
            order = np.argsort(costs, kind="stable")[:STARTS]
            found += [Candidate(hypothesis, tried[k], costs[k]) for k in order]
    return found


def narrowed(
    found: Sequence[Candidate],
    observations: Observations,
    advance: Callable[[float], None] = lambda part: None,
) -> list[Candidate]:
    """The candidates that do best, one for each effect and place, the best first."""
    observations = unlimited(observations)
    stride = stride_for(observations, COARSE)
    todo = list(found)
    for floor, steps, keep in ROUNDS:
        done = []
        for number, one in enumerate(todo):
            made = fit(
                one.hypothesis, observations, one.x, floors=(floor,), steps=steps, stride=stride, apart=False
            )
            done.append(Candidate(one.hypothesis, made.x, made.normal.cost))
            advance((number + 1) / len(todo) / len(ROUNDS))
        todo = distinct(done)[:keep]
    return todo


def distinct(found: Sequence[Candidate]) -> list[Candidate]:
    """The best of each effect and place, the best first."""
    best: dict[tuple[str, str], Candidate] = {}
    for one in sorted(found, key=lambda one: one.cost):
        best.setdefault(one.key, one)
    return list(best.values())


def polished(
    one: Candidate, observations: Observations, *, floors: Sequence[float] = (0.05, 0.01), steps: int = 20
) -> FrfFit:
    """A candidate fitted closely."""
    return fit(
        one.hypothesis,
        observations,
        one.x,
        floors=floors,
        steps=steps,
        stride=stride_for(observations, CLOSE),
    )
