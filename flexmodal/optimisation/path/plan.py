"""Planning a path: its shape by dynamic programming, then the whole bettered; and what to compare it with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError, Unreachable
from flexmodal.model import Posture
from flexmodal.optimisation.descent import descend
from flexmodal.optimisation.optimise import optimise
from flexmodal.optimisation.path.dynamic import best_sequence
from flexmodal.optimisation.path.local import improve, path_cost
from flexmodal.optimisation.path.nodes import nodes_of
from flexmodal.optimisation.path.problem import PathProblem

DEFAULT_NODES = 60

Advance = Callable[[], None]


@dataclass(frozen=True, eq=False)
class PathOutcome:
    """A posture for each point."""

    problem: PathProblem
    postures: Float[np.ndarray, "point commanded"]
    """In the order of `robot.commanded` [rad, m]."""
    values: Float[np.ndarray, " point"]
    """The objective at each point."""

    @property
    def total(self) -> float:
        """Sum of the values."""
        return float(self.values.sum())

    @property
    def worst(self) -> float:
        """The largest value, or the smallest where large is better."""
        better = self.problem.points[0].objective.larger_is_better
        return float(self.values.min() if better else self.values.max())

    @property
    def cost(self) -> float:
        """What was minimised."""
        return path_cost(self.problem, self.postures)

    @property
    def fastest(self) -> float:
        """Largest share of its speed that a joint needs."""
        times = np.diff([point.time for point in self.problem.points])
        speeds = np.abs(np.diff(self.postures, axis=0)) / times[:, None]
        return float((speeds / self.problem.speeds).max())

    @property
    def astray(self) -> float:
        """How far the tool leaves the path between points where the joints go straight [m]."""
        return self.problem.astray(self.postures)

    def posture(self, point: int) -> Posture:
        """The posture of a point, counted from 0."""
        return self.problem.at[point].posture(self.postures[point])

    def judged_by(self, problem: PathProblem) -> PathOutcome:
        """The same postures under another problem's objectives."""
        return PathOutcome(problem, self.postures, problem.values(self.postures))


def plan_path(
    problem: PathProblem,
    *,
    nodes: int = DEFAULT_NODES,
    seed: int = 0,
    iterations: int = 60,
    advance: Advance = lambda: None,
) -> PathOutcome:
    """Find a sequence of postures of least vibration.

    Dynamic programming over postures that cover the self-motion of every point gives the shape, and a local
    solver betters all postures together. Where the greedy sequence exists and can be bettered to less, that
    one is taken.

    Args:
        problem: the path.
        nodes: random postures for each point, beside those from valleys.
        seed: of the random postures; the same seed gives the same answer.
        iterations: of the local solver.
        advance: called once for each point and once for each iteration.

    Raises:
        Unreachable: a point that no posture reaches, or joints too slow.
    """
    starts = []
    trouble: FlexmodalError | None = None
    try:
        starts.append(best_sequence(problem, nodes_of(problem, nodes, seed, advance)))
    except Unreachable as error:
        trouble = error
    try:
        starts.append(greedy_path(problem, seed=seed).postures)
    except Unreachable as error:
        trouble = trouble or error
    if not starts:
        assert trouble is not None
        raise trouble
    ends = [improve(problem, start, iterations=iterations, advance=advance) for start in starts]
    best = min(ends, key=lambda postures: path_cost(problem, postures))
    return PathOutcome(problem, best, problem.values(best))


def greedy_path(problem: PathProblem, *, seed: int = 0, starts: int = 16) -> PathOutcome:
    """The best posture at the first point, then point by point the best beside the last within reach.

    Raises:
        Unreachable: it runs into a limit or a speed and cannot go on.
    """
    first = optimise(problem.at[0], starts=starts, seed=seed).best.posture
    path = [problem.at[0].vector(first)]
    for place in range(1, len(problem.points)):
        at, reach, last = problem.at[place], problem.reach[place - 1], path[-1]
        near = (np.maximum(at.lower, last - reach), np.minimum(at.upper, last + reach))
        end = descend(replace(at, limits=near), last, iterations=60)
        if end is None:
            raise Unreachable(f"the greedy sequence ends at point {place}: the next one is out of its reach")
        path.append(end.values)
    postures = np.array(path)
    return PathOutcome(problem, postures, problem.values(postures))
