"""Many descents at once, and the distinct optima they find."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.frf.kernels.route import available_cores, has_numba, thread_faults
from flexmodal.optimisation.compiled.arrays import room_for, scratch_for
from flexmodal.optimisation.compiled.descent import PERFECT, SETTLED, UNBOUNDED, UNREACHED
from flexmodal.optimisation.compiled.functions import descents, merging
from flexmodal.optimisation.compiled.plan import Plan, plan_of
from flexmodal.optimisation.problem import PostureProblem

_AT_ONCE = 64
"""Descents between two reports of progress."""

Progress = Callable[[int, float], None]
"""Told how many starts are done and the best cost so far."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where descents from many starts ended."""

    values: Float[np.ndarray, "start commanded"]
    cost: Float[np.ndarray, " start"]
    """∞ of a start that did not reach the hold."""
    end: Int[np.ndarray, " start"]
    """UNREACHED, UNSETTLED, SETTLED, PERFECT or UNBOUNDED of `flexmodal.optimisation.compiled.descent`."""
    iterations: Int[np.ndarray, " start"]
    interrupted: bool = False
    """Whether Ctrl-C ended it; the starts that were not done count as unreached."""

    @classmethod
    def joined(cls, blocks: Sequence[Ends]) -> Ends:
        """Ends of several blocks of starts as one."""
        parts = [(one.values, one.cost, one.end, one.iterations) for one in blocks]
        values, cost, end, iterations = (np.concatenate(part) for part in zip(*parts, strict=True))
        return cls(values, cost, end, iterations, any(one.interrupted for one in blocks))

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


def search_postures(
    problem: PostureProblem | Plan,
    starts: Float[np.ndarray, "start commanded"],
    *,
    iterations: int = 200,
    threads: int | None = None,
    way: str = "auto",
    progress: Progress | None = None,
) -> Basins:
    """Descend from many starts and tell the optima apart.

    Args:
        problem: what to minimise; or its arrays.
        starts: vectors of the commanded joints [rad, m]; brought onto the hold first.
        iterations: each descent gives up after this many.
        threads: most threads to use; all cores of the process if none.
        way: "compiled", "plain" (the same functions as ordinary Python, the same numbers but for rounding)
            or "auto", which is the former where numba is installed.
        progress: told of every batch of starts. An exception it raises ends the search; a keyboard
            interrupt ends it too, with what was found so far.

    Returns:
        Optima that are reached and not unbounded, best first; no row if there is none.

    Raises:
        InvalidRequest: the problem is none this search knows, or bad arguments.
        MissingExtra: the compiled way was asked for and numba is not installed.
    """
    plan = problem if isinstance(problem, Plan) else plan_of(problem)
    ends = descend_from(plan, starts, iterations=iterations, threads=threads, way=way, progress=progress)
    assert plan is not None
    return tell_apart(plan, ends, way)


def descend_from(
    plan: Plan | None,
    starts: Float[np.ndarray, "start commanded"],
    *,
    iterations: int = 200,
    threads: int | None = None,
    way: str = "auto",
    progress: Progress | None = None,
) -> Ends:
    """Where descents from many starts end; arguments as for `search_postures`."""
    plan, starts, compiled = _checked(plan, starts, iterations, threads, way)
    values = starts.copy()
    count = len(values)
    cost, end = np.full(count, np.inf), np.full(count, UNREACHED)
    steps = np.zeros(count, dtype=np.int64)
    function = descents(compiled)
    cores = min(threads or available_cores(), -(-count // _AT_ONCE)) if compiled else 1
    joints, held, width = len(plan.chain.mass), len(plan.hold.rows), values.shape[1]
    rooms = [(*room_for(joints, held, width), scratch_for(joints, plan.judge)) for _ in range(cores)]

    def solve(core: int, first: int, last: int) -> None:
        part = slice(first, last)
        function(
            plan.chain.arrays, plan.hold, plan.box, plan.judge, *rooms[core], iterations, values[part],
            cost[part], end[part], steps[part],
        )  # fmt: skip

    done, interrupted = 0, False
    try:
        with ThreadPoolExecutor(cores) as pool:
            while done < count:
                last = min(count, done + _AT_ONCE * cores) if progress or not compiled else count
                edges = np.linspace(done, last, cores + 1).astype(int).tolist()
                if cores == 1:
                    solve(0, done, last)
                else:
                    list(pool.map(lambda job: solve(job[0], *job[1]), enumerate(pairwise(edges))))
                done = last
                if progress is not None:
                    progress(done, float(np.min(cost[:done])))
    except KeyboardInterrupt:
        interrupted = True
        end[done:] = UNREACHED
        cost[done:] = np.inf
    return Ends(values, cost, end, steps, interrupted)


def tell_apart(plan: Plan, ends: Ends, way: str = "auto") -> Basins:
    """The distinct optima among ends, best first; starts that ran off or did not settle are left out.

    A descent that did not meet the tolerance still counts where it is the best there is.
    """
    bounded = (ends.end != UNREACHED) & (ends.end != UNBOUNDED)
    order = np.argsort(ends.cost, kind="stable")
    order = order[bounded[order]]
    good = (ends.end == SETTLED) | (ends.end == PERFECT)
    settled = bool(len(order)) and bool(good[order[0]])
    order = np.concatenate([order[:1], order[1:][good[order[1:]]]])
    group, hits = np.empty(len(order), dtype=np.int64), np.empty(len(order), dtype=np.int64)
    compiled = way == "compiled" or (way == "auto" and has_numba())
    count = int(merging(compiled)(ends.values, plan.turning, order, group, hits))
    _, first = np.unique(group, return_index=True)
    chosen = order[first]
    return Basins(ends.values[chosen], ends.cost[chosen], hits[:count].copy(), settled, ends)


def random_starts(
    problem: PostureProblem, count: int, generator: np.random.Generator
) -> Float[np.ndarray, "start commanded"]:
    """Random starts; the same numbers as so many calls of `PostureProblem.random_vector`."""
    return np.array([problem.random_vector(generator) for _ in range(count)]).reshape(
        count, len(problem.names)
    )


def _checked(
    plan: Plan | None, starts: np.ndarray, iterations: int, threads: int | None, way: str
) -> tuple[Plan, np.ndarray, bool]:
    faults = []
    if plan is None:
        allowed = "a serial chain judged by receptance, stiffness or mobility"
        faults.append(Fault("call", "problem", "a robot that branches, or another objective", allowed))
    if way not in ("auto", "compiled", "plain"):
        faults.append(Fault("call", "way", repr(way), "auto, compiled or plain"))
    if isinstance(iterations, bool) or iterations < 1:
        faults.append(Fault("call", "iterations", repr(iterations), "a whole number of at least 1"))
    faults += thread_faults(threads)
    width = None if plan is None else len(plan.box.columns)
    starts = np.ascontiguousarray(starts, dtype=float)
    if starts.ndim != 2 or (width is not None and starts.shape[1] != width) or len(starts) == 0:
        allowed = "an array of at least one start, a column for each commanded joint"
        faults.append(Fault("call", "starts", f"shape {starts.shape}", allowed))
    elif not np.all(np.isfinite(starts)):
        faults.append(Fault("call", "starts", "values that are not finite", "finite joint values"))
    if faults:
        raise InvalidRequest(faults)
    assert plan is not None
    if way == "compiled" and not has_numba():
        raise MissingExtra("the compiled search needs numba: pip install flexmodal[fast]")
    return plan, starts, way == "compiled" or (way == "auto" and has_numba())
