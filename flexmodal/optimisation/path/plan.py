"""Planning a path: its shape by dynamic programming, then the whole bettered; and what to compare it with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Unreachable
from flexmodal.model import Posture
from flexmodal.optimisation.optimise import optimise
from flexmodal.optimisation.path.dynamic import best_sequence
from flexmodal.optimisation.path.local import improve, path_cost
from flexmodal.optimisation.path.nodes import nodes_of
from flexmodal.optimisation.path.problem import PathProblem
from flexmodal.optimisation.search import descend

DEFAULT_NODES = 60

Advance = Callable[[], None]
Improved = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class PathOutcome:
    """A posture for each point."""

    problem: PathProblem
    postures: Float[np.ndarray, "point commanded"]
    """In the order of `robot.commanded` [rad, m]."""
    values: Float[np.ndarray, " point"]
    """The objective at each point."""
    interrupted: bool = False
    """Whether Ctrl-C ended the search; the sequence is the best until then."""

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
    def deviation(self) -> float:
        """How far the tool leaves the path between points where the joints go straight [m]."""
        return self.problem.deviation(self.postures)

    def posture(self, point: int) -> Posture:
        """The posture of a point, counted from 0."""
        return self.problem.at[point].posture(self.postures[point])

    @property
    def nearest(self) -> tuple[float, tuple[str, str]] | None:
        """What comes nearest along the sequence, and how near [m]; None where nothing was checked."""
        return self.problem.nearest(self.postures)

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
    improved: Improved = lambda value: None,
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
        improved: called with the sum, or the worst, of the best so far, whenever it is better than before.

    Returns:
        The best sequence found. Interrupted by Ctrl-C, the best until then, if there is one already.

    Raises:
        Unreachable: a point that no posture reaches, or joints too slow.
    """
    best = _Best(problem, improved)
    trouble: Unreachable | None = None
    starts: list[np.ndarray] = []
    shapes: tuple[Callable[[], np.ndarray], ...] = (
        lambda: greedy_path(problem, seed=seed).postures,
        lambda: best_sequence(problem, nodes_of(problem, nodes, seed, advance)),
    )
    interrupted = False
    try:
        for shape in shapes:
            try:
                starts.append(shape())
                best(starts[-1])
            except Unreachable as error:
                trouble = error
        for start in reversed(starts):
            improve(problem, start, iterations=iterations, advance=advance, accepted=best)
    except KeyboardInterrupt:
        interrupted = True
    if best.postures is None:
        raise KeyboardInterrupt if interrupted or trouble is None else trouble
    return PathOutcome(problem, best.postures, problem.values(best.postures), interrupted)


@dataclass
class _Best:
    """Keeps the best sequence so far, and tells of it."""

    problem: PathProblem
    improved: Improved
    postures: np.ndarray | None = None
    cost: float = np.inf

    def __call__(self, postures: np.ndarray) -> None:
        cost = path_cost(self.problem, postures)
        if cost < self.cost:
            self.postures, self.cost = postures, cost
            found = PathOutcome(self.problem, postures, self.problem.values(postures))
            self.improved(found.total if self.problem.way == "sum" else found.worst)


def greedy_path(problem: PathProblem, *, seed: int = 0, starts: int = 16) -> PathOutcome:
    """The best posture at the first point, then point by point the best beside the last within reach.

    Args:
        problem: the path.
        seed: of the search at the first point.
        starts: of that search.

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
