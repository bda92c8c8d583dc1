"""Where descents ended, and the distinct optima among their ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from flexmodal.errors import FlexmodalError
from flexmodal.optimisation.descent import PERFECT, SETTLED, UNBOUNDED, UNREACHED, UNSETTLED
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.problem import PostureProblem

SAME = 1e-3
"""Two optima whose joints all agree within this are one [rad, m]."""

LIMITS = {PERFECT: Limit.PERFECT, UNBOUNDED: Limit.UNBOUNDED}
"""What an end says of the objective; nothing where it is neither."""


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended."""

    values: np.ndarray
    cost: float
    converged: bool
    iterations: int
    limit: Limit = Limit.NONE


@dataclass(frozen=True, eq=False)
class Ends:
    """Where descents from many starts ended."""

    values: Float[np.ndarray, "start commanded"]
    cost: Float[np.ndarray, " start"]
    """∞ of a start that did not reach the hold, or has no cost there."""
    end: Int[np.ndarray, " start"]
    """UNREACHED, UNSETTLED, SETTLED, PERFECT or UNBOUNDED of `flexmodal.optimisation.descent`."""
    iterations: Int[np.ndarray, " start"]
    interrupted: bool = False
    """Whether Ctrl-C ended it; the starts that were not done are left out."""
    trouble: FlexmodalError | None = None
    """Why a start that reached the hold has no cost there, where that was met in Python."""

    @classmethod
    def joined(cls, blocks: Sequence[Ends]) -> Ends:
        """Ends of several blocks of starts as one."""
        parts = [(one.values, one.cost, one.end, one.iterations) for one in blocks]
        values, cost, end, iterations = (np.concatenate(part) for part in zip(*parts, strict=True))
        trouble = next((one.trouble for one in reversed(blocks) if one.trouble is not None), None)
        return cls(values, cost, end, iterations, any(one.interrupted for one in blocks), trouble)

    @classmethod
    def of(cls, descents: Sequence[Descent]) -> Ends:
        """Ends of descents done otherwise, all of which came onto the hold."""
        codes = {limit: code for code, limit in LIMITS.items()}
        ends = [codes.get(one.limit, SETTLED if one.converged else UNSETTLED) for one in descents]
        return cls(
            np.array([one.values for one in descents]),
            np.array([one.cost for one in descents], dtype=float),
            np.array(ends),
            np.array([one.iterations for one in descents]),
        )

    @property
    def reached(self) -> int:
        """Starts that reached the hold."""
        return int(np.sum(self.end != UNREACHED))

    @property
    def unbounded(self) -> int:
        """Starts that ran into a posture where the measure grows without bound."""
        return int(np.sum(self.end == UNBOUNDED))


@dataclass(frozen=True, eq=False)
class Basins:
    """Distinct local optima, best first."""

    values: Float[np.ndarray, "optimum commanded"]
    cost: Float[np.ndarray, " optimum"]
    hits: Int[np.ndarray, " optimum"]
    """How many starts ended in each."""
    settled: bool
    """Whether the best met the tolerance."""
    ends: Ends


def tell_apart(problem: PostureProblem, ends: Ends) -> Basins:
    """The distinct optima among ends, best first; starts that ran off or did not settle are left out.

    Whole turns apart are the same. A descent that did not meet the tolerance still counts where it is the
    best there is; and so does the best of those that ran off where there are no others.

    Args:
        problem: whose joints.
        ends: of its descents.
    """
    bounded = (ends.end != UNREACHED) & (ends.end != UNBOUNDED)
    order = np.argsort(ends.cost, kind="stable")
    order = order[bounded[order]]
    good = (ends.end == SETTLED) | (ends.end == PERFECT)
    if len(order) == 0 and ends.unbounded:
        order = np.array([np.argmin(ends.cost)])
    settled = bool(len(order)) and bool(good[order[0]])
    order = np.concatenate([order[:1], order[1:][good[order[1:]]]])
    turn = np.where(problem.turning, 2 * np.pi, np.inf)
    chosen: list[int] = []
    hits: list[int] = []
    centres = np.empty((len(order), ends.values.shape[1]))
    for place in order.tolist():
        gap = ends.values[place] - centres[: len(chosen)]
        gap -= np.where(problem.turning, turn, 0.0) * np.round(gap / turn)
        same = np.flatnonzero(np.all(np.abs(gap) <= SAME, axis=1))
        if len(same):
            hits[same[0]] += 1
        else:
            centres[len(chosen)] = ends.values[place]
            chosen.append(place)
            hits.append(1)
    return Basins(ends.values[chosen], ends.cost[chosen], np.array(hits, dtype=int), settled, ends)
