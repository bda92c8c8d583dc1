"""Descents from many starts: all at once in compiled code where it applies, else one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmodal.errors import FlexmodalError
from flexmodal.frf.kernels.route import has_numba
from flexmodal.optimisation.descent import Descent, descend
from flexmodal.optimisation.objective import Limit
from flexmodal.optimisation.outcome import distinct
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.unreachable import nearest, unreachable

if TYPE_CHECKING:
    from flexmodal.optimisation.compiled.plan import Plan
    from flexmodal.optimisation.compiled.search import Ends

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


@dataclass
class _Report:
    """Hears of the compiled search, and tells the caller of each start and of each better value."""

    problem: PostureProblem
    advance: Advance
    improved: Improved
    before: int = 0
    """Starts of the blocks before this one."""
    done: int = 0
    best: float = np.inf

    def __call__(self, done: int, least: float) -> None:
        fresh, self.done = self.before + done - self.done, self.before + done
        for _ in range(fresh):
            self.advance()
        if least < self.best:
            self.best = least
            self.improved(math.exp(-least if self.problem.objective.larger_is_better else least))


def all_at_once(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    advance: Advance,
    improved: Improved,
) -> Found:
    """Descend from the given start and random ones in compiled code, drawn and searched 256 at a time.

    If nobody says from how many, until five ended in the best, 4096 at most. Whoever says, a zero ends it.

    Raises:
        Unreachable, SingularResponse: no start came to anything.
        KeyboardInterrupt: before there was anything to keep.
    """
    from flexmodal.optimisation.compiled.plan import plan_of
    from flexmodal.optimisation.compiled.search import Ends, tell_apart

    plan = plan_of(problem)
    assert plan is not None
    report = _Report(problem, advance, improved)
    blocks: list[Ends] = []
    interrupted = False
    try:
        for block in _blocks(problem, plan, given, starts, seed, report):
            blocks.append(block)
            interrupted = block.interrupted
            if interrupted or _perfect(problem, block) or (starts is None and _enough(plan, blocks)):
                break
    except KeyboardInterrupt:
        interrupted = True
    if not blocks:
        raise KeyboardInterrupt
    ends = Ends.joined(blocks)
    basins = tell_apart(plan, ends)
    if len(basins.cost) == 0 and interrupted:
        raise KeyboardInterrupt
    if ends.reached == 0 and problem.hold is not None:
        return gathered(problem, [_last_try(problem, report.done)], report.done)
    if len(basins.cost) == 0:  # nothing, or nothing bounded: say why
        return one_by_one(problem, given, min(starts or _FEW, _FEW), seed, lambda: None, lambda value: None)
    rows = zip(basins.cost.tolist(), basins.values, basins.hits.tolist(), strict=True)
    return Found(list(rows), basins.settled, ends.reached, ends.unbounded, report.done, interrupted)


def _blocks(
    problem: PostureProblem,
    plan: Plan,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    report: _Report,
) -> Iterator[Ends]:
    """Ends of one block of starts after another."""
    from flexmodal.optimisation.compiled import random_starts
    from flexmodal.optimisation.compiled.search import descend_from

    generator, most = np.random.default_rng(seed), starts or _BATCHES * MANY_STARTS
    while report.before < most:
        count = min(MANY_STARTS, most - report.before)
        first = [] if given is None or report.before > 0 else [leaning(problem, given)]
        vectors = random_starts(problem, count - len(first), generator)
        yield descend_from(plan, np.array([*first, *vectors]), progress=report)
        report.before += count


def _enough(plan: Plan, blocks: list[Ends]) -> bool:
    """Whether some starts ended in the best already, or none comes to anything."""
    from flexmodal.optimisation.compiled.search import Ends, tell_apart

    hits = tell_apart(plan, Ends.joined(blocks)).hits
    return blocks[-1].reached == 0 or (len(hits) > 0 and int(hits[0]) >= _SURE)


def _perfect(problem: PostureProblem, ends: Ends) -> bool:
    """Whether nothing is left to gain. Such postures form families, so that no two starts end in the same."""
    least = float(np.min(ends.cost))
    return problem.objective.limit(least, problem.robot) is Limit.PERFECT


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
                result = descend(problem, leaning(problem, vector) if first else vector)
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
        if trouble is not None:
            raise trouble
        found.append(_last_try(problem, starts))
    return gathered(problem, found, count if interrupted else starts, interrupted=interrupted)


def _last_try(problem: PostureProblem, tried: int) -> Descent:
    """A descent from where damped steps come onto a hold that no start reached; else why none can."""
    values = problem.retract(nearest(problem)[1])
    result = None if values is None else descend(problem, values)
    if result is None:
        raise unreachable(problem, tried)
    return result


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


def leaning(problem: PostureProblem, start: np.ndarray) -> np.ndarray:
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
