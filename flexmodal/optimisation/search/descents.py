"""Descents from many starts, compiled or one by one in Python."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.frf.kernels.route import available_cores, has_numba, thread_faults
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.optimisation import compiled
from flexmodal.optimisation.descent import PERFECT, SETTLED, UNBOUNDED, UNREACHED, descend_all, work_for
from flexmodal.optimisation.objectives import Limit, ReceptanceObjective
from flexmodal.optimisation.problem import Evaluation, PostureProblem
from flexmodal.optimisation.search.clear import solve_clear
from flexmodal.optimisation.search.ends import LIMITS, Basins, Descent, Ends, tell_apart

WAYS = ("auto", "compiled", "plain")

_MANY = 16
"""Starts up to which descents in Python are as quick as loading the compiled ones."""

_AT_ONCE = 64
"""Compiled descents between two reports of progress."""

_SECONDS, _LINE = 0.04, 1e-3
"""Seconds that a descent takes in Python, and each frequency that is judged beside the first [s]."""

Progress = Callable[[int, float], None]
"""Told how many starts are done and the best cost so far."""

Watch = Callable[[np.ndarray, float], None]
"""Told the vector and the cost of every iterate."""


def search_postures(
    problem: PostureProblem,
    starts: Float[np.ndarray, "start commanded"],
    *,
    iterations: int = 200,
    threads: int | None = None,
    way: str = "auto",
    progress: Progress | None = None,
) -> Basins:
    """Descend from many starts and tell the optima apart.

    Args:
        problem: what to minimise.
        starts: vectors of the commanded joints [rad, m]; brought onto the hold first.
        iterations: each descent gives up after this many.
        threads: most threads to use for compiled descents; all cores of the process if none.
        way: "compiled", "plain" (one by one in Python, the same but for rounding) or "auto", as `choose_way`.
        progress: told of every batch of starts. An exception it raises ends the search; a keyboard
            interrupt ends it too, with what was found so far.

    Returns:
        Optima that are reached and not unbounded, best first; no row if there is none.

    Raises:
        InvalidRequest: bad arguments, or the compiled way for a problem that cannot be compiled.
        MissingExtra: the compiled way was asked for and numba is not installed.
    """
    ends = descend_from(problem, starts, iterations=iterations, threads=threads, way=way, progress=progress)
    return tell_apart(problem, ends)


def choose_way(problem: PostureProblem, starts: int) -> str:
    """Whether descents are made the "compiled" or the "plain" way, all searches of this process counted.

    A few descents are always made in Python and do not count.

    Args:
        problem: a serial chain judged by receptance, stiffness or mobility can be compiled.
        starts: descents that are about to be made.
    """
    if starts < _MANY or not is_compilable(problem):
        return "plain"
    lines = len(problem.objective.frequency) if isinstance(problem.objective, ReceptanceObjective) else 1
    seconds = starts * (_SECONDS + (lines - 1) * _LINE)
    worth = is_worth_it("descents", seconds, compiled.COMPILATION, compiled.descents().is_stored)
    return "compiled" if worth else "plain"


def is_compilable(problem: PostureProblem) -> bool:
    """Whether compiled descents apply: numba installed, a serial chain, an objective they know."""
    return has_numba() and compiled.arm_of(problem) is not None


def descend_from(
    problem: PostureProblem,
    starts: Float[np.ndarray, "start commanded"],
    *,
    iterations: int = 200,
    threads: int | None = None,
    way: str = "auto",
    progress: Progress | None = None,
) -> Ends:
    """Where descents from many starts end.

    Args:
        problem: as for `search_postures`, as all below.
        starts: start × commanded joint.
        iterations: most of each descent.
        threads: most of them.
        way: "auto", "compiled" or "plain".
        progress: told of every batch.

    Raises:
        InvalidRequest, MissingExtra: see `search_postures`.
    """
    starts = _checked(problem, starts, iterations, threads, way)
    way = choose_way(problem, len(starts)) if way == "auto" else way
    cores = min(threads or available_cores(), -(-len(starts) // _AT_ONCE)) if way == "compiled" else 1
    batch = _AT_ONCE * cores if way == "compiled" else 1
    at = Evaluation(problem)
    solve = _compiled(problem, cores) if way == "compiled" else _plain(at)
    values, count = starts.copy(), len(starts)
    cost, end = np.full(count, np.inf), np.full(count, UNREACHED)
    steps = np.zeros(count, dtype=np.int64)

    def part(core: int, first: int, last: int) -> None:
        here = slice(first, last)
        solve(core, iterations, values[here], cost[here], end[here], steps[here])

    done, interrupted = 0, False
    try:
        with ThreadPoolExecutor(cores) as pool:
            while done < count:
                last = min(count, done + batch) if progress or way == "plain" else count
                if cores == 1:
                    part(0, done, last)
                else:
                    edges = np.linspace(done, last, cores + 1).astype(int).tolist()
                    list(pool.map(lambda job: part(job[0], *job[1]), enumerate(pairwise(edges))))
                done = last
                if progress is not None:
                    bounded = cost[:done][end[:done] != UNBOUNDED]
                    progress(done, float(np.min(bounded, initial=np.inf)))
    except KeyboardInterrupt:
        interrupted = True
    return Ends(values[:done], cost[:done], end[:done], steps[:done], interrupted, at.trouble)


_Solve = Callable[[int, int, np.ndarray, np.ndarray, np.ndarray, np.ndarray], None]


def _compiled(problem: PostureProblem, cores: int) -> _Solve:
    """Each core has arrays of its own to work in."""
    arms = [compiled.arm_of(problem) for _ in range(cores)]
    works = [work_for(problem.held_components, len(problem.names)) for _ in range(cores)]
    function, box, trace = compiled.descents().compiled, compiled.box_of(problem), np.zeros((0, 0))

    def solve(core: int, iterations: int, *arrays: np.ndarray) -> None:
        function(arms[core], box, works[core], iterations, *arrays, trace)

    return solve


def _plain(at: Evaluation) -> _Solve:
    problem = at.problem
    if problem.clearance is not None:
        return lambda core, *given: solve_clear(at, *given)
    work, trace = work_for(problem.held_components, len(problem.names)), np.zeros((0, 0))

    def solve(
        core: int, iterations: int, values: np.ndarray, cost: np.ndarray, end: np.ndarray, steps: np.ndarray
    ) -> None:
        descend_all(at, problem.box, work, iterations, values, cost, end, steps, trace)

    return solve


def descend(
    problem: PostureProblem,
    start: np.ndarray,
    *,
    iterations: int = 200,
    watch: Watch | None = None,
) -> Descent | None:
    """Go down from a start, in Python; None if no posture on the hold can be reached from it.

    Args:
        problem: what to minimise.
        start: vector of the commanded joints; brought onto the hold first.
        iterations: give up after this many.
        watch: told every iterate, when all is done.

    Raises:
        FlexmodalError: there is no cost at the start, such as a SingularResponse.
    """
    width, at = len(start), Evaluation(problem)
    values, cost = np.array(start, dtype=float)[None], np.zeros(1)
    end, steps = np.zeros(1, dtype=int), np.zeros(1, dtype=int)
    trace = np.full((iterations + 1 if watch else 0, width + 1), np.nan)
    work = work_for(problem.held_components, width)
    descend_all(at, problem.box, work, iterations, values, cost, end, steps, trace)
    if end[0] == UNREACHED:
        if at.trouble is not None:
            raise at.trouble
        return None
    if watch:
        for row in trace[~np.isnan(trace[:, -1])]:
            watch(row[:-1], float(row[-1]))
    limit = LIMITS.get(int(end[0]), Limit.NONE)
    return Descent(values[0], float(cost[0]), bool(end[0] in (SETTLED, PERFECT)), int(steps[0]), limit)


def random_starts(
    problem: PostureProblem, count: int, generator: np.random.Generator
) -> Float[np.ndarray, "start commanded"]:
    """Random starts; the same numbers as so many calls of `PostureProblem.random_vector`.

    Args:
        problem: whose joints.
        count: how many.
        generator: advances by as many draws.
    """
    vectors = [problem.random_vector(generator) for _ in range(count)]
    return np.array(vectors).reshape(count, len(problem.names))


def _checked(
    problem: PostureProblem, starts: np.ndarray, iterations: int, threads: int | None, way: str
) -> np.ndarray:
    faults = []
    if way not in WAYS:
        faults.append(Fault("call", "way", repr(way), "auto, compiled or plain"))
    if isinstance(iterations, bool) or iterations < 1:
        faults.append(Fault("call", "iterations", repr(iterations), "a whole number of at least 1"))
    faults += thread_faults(threads)
    starts = np.ascontiguousarray(starts, dtype=float)
    if starts.ndim != 2 or starts.shape[1] != len(problem.names) or len(starts) == 0:
        allowed = "an array of at least one start, a column for each commanded joint"
        faults.append(Fault("call", "starts", f"shape {starts.shape}", allowed))
    elif not np.all(np.isfinite(starts)):
        faults.append(Fault("call", "starts", "values that are not finite", "finite joint values"))
    if way == "compiled" and compiled.arm_of(problem) is None:
        allowed = "a serial chain judged by receptance, stiffness or mobility"
        faults.append(Fault("call", "problem", "a robot that branches, or another objective", allowed))
    if faults:
        raise InvalidRequest(faults)
    if way == "compiled" and not has_numba():
        raise MissingExtra("the compiled search needs numba: pip install flexmodal[fast]")
    return starts
