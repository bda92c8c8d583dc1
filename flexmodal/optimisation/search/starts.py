"""From how many starts to descend, and what to make of where they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from flexmodal.errors import InCollision
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search.descents import choose_way, descend, descend_from, random_starts
from flexmodal.optimisation.search.ends import Basins, Ends, tell_apart
from flexmodal.optimisation.search.unreachable import nearest, unreachable

DEFAULT_STARTS, BLOCK = 64, 256
"""Starts if nobody says how many, one by one in Python; and those that are drawn and searched at a time."""

_SURE, _BLOCKS = 5, 16
"""Starts that have to end in the best before a compiled search stops by itself, and most blocks."""

EQUAL = 1e-6
"""Relative difference of two objectives that counts as none: descents end within some 1e-10 of a minimum."""

_FEW = 4
"""Starts tried one by one to say why none of many came to anything."""

Advance = Callable[[], None]
Improved = Callable[[float], None]


@dataclass
class _Report:
    """Hears of the descents, and tells the caller of each start and of each better value."""

    problem: PostureProblem
    advance: Advance
    improved: Improved
    before: int = 0
    """Starts of the blocks before this one."""
    done: int = 0
    best: float = np.inf

    def __call__(self, done: int, least: float) -> None:
        fresh, self.done = self.before + done - self.done, self.before + done
        if least < self.best:
            self.best = least
            self.improved(math.exp(-least if self.problem.objective.larger_is_better else least))
        for _ in range(fresh):
            self.advance()


def search(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    way: str,
    *,
    advance: Advance,
    improved: Improved,
) -> Basins:
    """Descend from the given start and random ones.

    If nobody says from how many, from 64 in Python; compiled 256 at a time until five ended in the best, 4096
    at most. A zero ends it.

    Args:
        problem: what to minimise.
        given: a start, before the random ones.
        starts: how many in all.
        seed: of the random ones.
        way: as for `flexmodal.optimisation.search.search_postures`.
        advance: called once a start.
        improved: called with every better value.

    Raises:
        Unreachable: no start came onto the hold.
        SingularResponse: at every start an undamped mode is driven at its natural frequency.
        KeyboardInterrupt: before there was anything to keep.
        InvalidRequest, MissingExtra: see `flexmodal.optimisation.search.search_postures`.
    """
    way = choose_way(problem, starts or DEFAULT_STARTS) if way == "auto" else way
    report = _Report(problem, advance, improved)
    blocks: list[Ends] = []
    interrupted = False
    try:
        for block in _blocks(problem, given, starts, seed, way, report):
            blocks.append(block)
            if block.interrupted or _is_perfect(problem, block):
                break
            if starts is None and _is_enough(problem, blocks):
                break
    except KeyboardInterrupt:
        interrupted = True
    if not blocks:
        raise KeyboardInterrupt
    ends = Ends.joined(blocks)
    ends = replace(ends, interrupted=interrupted or ends.interrupted)
    if ends.reached == 0 and ends.interrupted:
        raise KeyboardInterrupt
    return tell_apart(problem, ends) if ends.reached else _last_try(problem, ends, way)


def _blocks(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int | None,
    seed: int,
    way: str,
    report: _Report,
) -> Iterator[Ends]:
    """Ends of one block of starts after another."""
    generator = np.random.default_rng(seed)
    most = starts or (_BLOCKS * BLOCK if way == "compiled" else DEFAULT_STARTS)
    while report.before < most:
        count = min(BLOCK, most - report.before)
        first = [] if given is None or report.before > 0 else [beside(problem, given)]
        vectors = random_starts(problem, count - len(first), generator)
        yield descend_from(problem, np.array([*first, *vectors]), way=way, progress=report)
        report.before += count


def _is_enough(problem: PostureProblem, blocks: list[Ends]) -> bool:
    """Whether some starts ended in the best already, or none comes to anything."""
    found = tell_apart(problem, Ends.joined(blocks))
    best = found.cost - np.min(found.cost, initial=np.inf) <= EQUAL
    return blocks[-1].reached == 0 or int(np.sum(found.hits[best])) >= _SURE


def _is_perfect(problem: PostureProblem, ends: Ends) -> bool:
    """Whether nothing is left to gain. Such postures form families, so that no two starts end in the same."""
    least = float(np.min(ends.cost, initial=np.inf))
    return problem.objective.limit(least, problem.robot) is Limit.PERFECT


def _last_try(problem: PostureProblem, ends: Ends, way: str) -> Basins:
    """Where no start came to anything: why, or a descent from where damped steps come onto the hold.

    That one takes the place of the last start.
    """
    if problem.clearance is not None:
        free = replace(problem, clearance=None)
        if any(free.retract(values) is not None for values in ends.values):
            kept = f"{1e3 * problem.clearance.distance:g} mm"
            raise InCollision(
                f"none of {len(ends.cost)} starts came to a posture that holds the target {kept} clear of "
                f"everything: {ends.trouble or 'no way out was found'}"
            )
    tried = ends if way == "plain" else descend_from(problem, ends.values[:_FEW], way="plain")
    if tried.trouble is not None:
        raise tried.trouble
    values = problem.retract(nearest(problem)[1])
    found = None if values is None else descend(problem, values)
    if found is None:
        raise unreachable(problem, len(ends.cost))
    before = Ends(ends.values[:-1], ends.cost[:-1], ends.end[:-1], ends.iterations[:-1])
    return tell_apart(problem, Ends.joined([before, Ends.of([found])]))


def beside(problem: PostureProblem, start: np.ndarray) -> np.ndarray:
    """A start that the hold can be reached from: itself, or beside it where no first step leads off.

    As where a stretched arm is to reach inwards.

    Args:
        problem: with the hold.
        start: of the commanded joints [rad, m].
    """
    if problem.retract(start) is not None:
        return start
    generator = np.random.default_rng(0)
    for size in (0.01, 0.03, 0.1, 0.3):
        kicked = start + generator.normal(scale=size, size=len(start))
        if problem.retract(kicked) is not None:
            return kicked
    return start
