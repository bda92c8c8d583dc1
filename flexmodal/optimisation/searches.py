"""Descents from many starts: all at once in compiled code where it applies, else one by one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmodal.errors import FlexmodalError
from flexmodal.frf.kernels.route import has_numba
from flexmodal.optimisation.descent import Descent, descend
from flexmodal.optimisation.objective import Limit
from flexmodal.optimisation.outcome import distinct
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.unreachable import unreachable

if TYPE_CHECKING:
    from flexmodal.optimisation.compiled import Ends

DEFAULT_STARTS, MANY_STARTS = 64, 256
"""Starts if nobody says how many: in Python, and at a time in the compiled search."""

_SURE, _BATCHES = 5, 16
"""Starts that have to end in the best before the compiled search stops by itself, and most batches."""

_FEW = 4
"""Starts tried one by one to say why none of many came to anything."""

Advance = Callable[[], None]
Improved = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Found:
    """What descents came to."""

    optima: list[tuple[float, np.ndarray, int]]
    """Cost, vector and hits of distinct optima, best first."""
    converged: bool
    """Whether the best met the tolerance."""
    reached: int
    """Starts that came onto the hold."""
    unbounded: int
    tried: int
    interrupted: bool = False


def is_compiled(problem: PostureProblem) -> bool:
    """Whether the compiled search applies: numba installed, a serial chain, an objective it knows."""
    if not has_numba():
        return False
    from flexmodal.optimisation.compiled.plan import plan_of

    return plan_of(problem) is not None


def all_at_once(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    advance: Advance,
    improved: Improved,
) -> Found:
    """Descend from the given start and random ones in compiled code.

    If nobody says from how many, 256 at a time until five ended in the best, 4096 at most.

    Raises:
        Unreachable, SingularResponse: no start came to anything.
    """
    from flexmodal.optimisation.compiled import random_starts
    from flexmodal.optimisation.compiled.plan import plan_of
    from flexmodal.optimisation.compiled.search import descend_from, tell_apart

    told, best = 0, np.inf

    def progress(done: int, least: float) -> None:
        nonlocal told, best
        before = 0 if ends is None else len(ends.cost)
        fresh, told = before + done - told, before + done
        for _ in range(fresh):
            advance()
        if least < best:
            best = least
            improved(math.exp(-least if problem.objective.larger_is_better else least))

    plan = plan_of(problem)
    assert plan is not None
    generator = np.random.default_rng(seed)
    ends, interrupted = None, False
    for _ in range(1 if starts is not None else _BATCHES):
        vectors = random_starts(problem, starts or MANY_STARTS, generator)
        if given is not None and ends is None:
            vectors = np.concatenate([_leaning(problem, given)[None], vectors[:-1]])
        more = descend_from(plan, vectors, progress=progress)
        interrupted = told < len(vectors) + (0 if ends is None else len(ends.cost))
        ends = more if ends is None else _joined(ends, more)
        basins = tell_apart(plan, ends)
        sure = len(basins.cost) > 0 and int(basins.hits[0]) >= _SURE
        if interrupted or sure or ends.reached == 0:
            break
    assert ends is not None
    if len(basins.cost) == 0 and interrupted:
        raise KeyboardInterrupt
    if ends.reached == 0 and problem.hold is not None:
        raise unreachable(problem, told)
    if len(basins.cost) == 0:  # nothing, or nothing bounded: say why
        return one_by_one(problem, given, min(starts or _FEW, _FEW), seed, lambda: None, lambda value: None)
    rows = zip(basins.cost.tolist(), basins.values, basins.hits.tolist(), strict=True)
    return Found(list(rows), basins.settled, ends.reached, ends.unbounded, told, interrupted)


def _joined(one: Ends, other: Ends) -> Ends:
    """Ends of two batches as one."""
    from flexmodal.optimisation.compiled import Ends

    names = ("values", "cost", "end", "iterations")
    return Ends(*(np.concatenate([getattr(one, name), getattr(other, name)]) for name in names))


def one_by_one(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    advance: Advance,
    improved: Improved,
) -> Found:
    """The same in Python, for every objective; Ctrl-C ends it once there is something to keep.

    Raises:
        Unreachable: no start came onto the hold.
        SingularResponse: at every start an undamped mode is driven at its natural frequency.
    """
    generator, starts = np.random.default_rng(seed), starts or DEFAULT_STARTS
    found: list[Descent] = []
    trouble: FlexmodalError | None = None
    best, count, interrupted = np.inf, 0, False
    try:
        for count in range(starts):
            first = count == 0 and given is not None
            vector = given if first and given is not None else problem.random_vector(generator)
            try:
                result = descend(problem, _leaning(problem, vector) if first else vector)
            except FlexmodalError as error:
                trouble, result = error, None
            if result is not None:
                found.append(result)
                if result.cost < best and result.limit is not Limit.UNBOUNDED:
                    best = result.cost
                    improved(problem.objective.value(problem.posed(result.values)))
            advance()
    except KeyboardInterrupt:
        if not found:
            raise
        interrupted = True
    if not found:
        raise trouble or unreachable(problem, starts)
    return gathered(problem, found, count if interrupted else starts, interrupted=interrupted)


def gathered(
    problem: PostureProblem, found: list[Descent], tried: int, *, interrupted: bool = False
) -> Found:
    """Descents told apart; those that ran off are counted and left out, unless there are no others."""
    bounded = [result for result in found if result.limit is not Limit.UNBOUNDED]
    # A descent that did not meet the tolerance still counts where it is the best there is.
    best = min(bounded or found, key=lambda result: result.cost)
    kept = [result for result in bounded if result.converged or result is best] or [best]
    optima = distinct(problem, [(result.cost, result.values) for result in kept])
    unbounded = len(found) - len(bounded)
    return Found(optima, best.converged, len(found), unbounded, tried, interrupted)


def _leaning(problem: PostureProblem, start: np.ndarray) -> np.ndarray:
    """A start that the hold can be reached from: itself, or beside it where no first step leads off.

    As where a stretched arm is to reach inwards.
    """
    if problem.retract(start) is not None:
        return start
    generator = np.random.default_rng(0)
    for size in (0.01, 0.03, 0.1, 0.3):
        beside = start + generator.normal(scale=size, size=len(start))
        if problem.retract(beside) is not None:
            return beside
    return start
