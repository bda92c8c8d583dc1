"""Which way to take to a receptance, why, and taking it on the cores it was given."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from typing import TypeVar

import numpy as np
from jaxtyping import Complex

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.frf.kernels.factor import LANES, Shape
from flexmodal.frf.kernels.reordered import solve_from_base
from flexmodal.frf.kernels.task import Task
from flexmodal.frf.kernels.worth import is_worth_it

Result = TypeVar("Result")

WAYS = ("auto", "LAPACK", "numpy", "compiled", "compiled any n", "recursion")

FEW = 40
"""Points, times n², up to which one call of LAPACK is quicker than the calls of the numpy form."""

LONG = {"planar": 12, "spatial": 12, "": 0}
"""Joints from which the recursion along a chain beats elimination."""

WORTH_A_CALL = 200
"""Points from which a compiled kernel that is loaded already is quicker than anything else; calls with
fewer do not count towards loading one."""

_LOADED: set[Shape] = set()
"""Shapes whose kernels this process has used."""

_POINTS = 1 << 15
"""Points of one block: its inputs stay small beside the result, and threads have something to share."""


@dataclass(frozen=True)
class Route:
    """The way taken and the reason."""

    way: str
    threads: int
    reason: str

    def __str__(self) -> str:
        """One line for a log."""
        cores = "1 thread" if self.threads == 1 else f"{self.threads} threads"
        return f"{self.way} on {cores}: {self.reason}"


def choose(task: Task, threads: int | None, way: str = "auto") -> Route:
    """Choose a route; every route gives the same numbers but for rounding.

    Elimination in numpy costs some calls for each pair of coordinates, however few the points, and about a
    microsecond a point for six joints, which grows with the cube. All points asked for so far count: once
    they have cost what loading a compiled kernel would have, or compiling it where it is not on disk, it is
    loaded.

    Args:
        task: what is to be solved.
        threads: most threads; all cores of the process if none.
        way: "auto" or one of the others of `WAYS`.

    Raises:
        InvalidRequest: a number of threads below 1, or no such way.
        MissingExtra: a compiled route was asked for and numba is not installed.
    """
    faults = thread_faults(threads)
    if way not in WAYS:
        faults.append(Fault("call", "way", repr(way), ", ".join(WAYS)))
    if faults:
        raise InvalidRequest(faults)
    if way in ("LAPACK", "numpy"):
        return Route(way, 1, "asked for")
    if way == "recursion" and task.recursion is None:
        allowed = "another: this wants a serial chain with diagonal K and B and no addition"
        raise InvalidRequest(Fault("call", "way", repr(way), allowed))
    if way == "auto":
        interpreted = _interpreted(task)
        if interpreted is not None:
            return interpreted
    elif not has_numba():
        raise MissingExtra("the compiled routes need numba: pip install flexmodal[fast]")
    cores = 1 if threads == 1 else min(threads or available_cores(), sum(1 for _ in blocks_of(task)))
    if way == "recursion" or (way == "auto" and _goes_along(task)):
        return Route("recursion", cores, f"a {task.chain} chain of {task.dof} joints")
    why = f"{task.points} points, n = {task.dof}, {len(task.pairs)} pairs"
    why += ", K and B diagonal" if task.shape.diagonal else ", K and B symmetric"
    return Route("compiled" if task.fits_fixed and way != "compiled any n" else "compiled any n", cores, why)


def _interpreted(task: Task) -> Route | None:
    """The way without a compiled kernel, unless one is loaded or has become worth loading."""
    reason = "numba is not installed"
    if has_numba():
        reason = f"{task.points} points are done before a compiled kernel would be loaded"
        if task.points >= WORTH_A_CALL and (is_ready(task) or _is_worth_it(task)):
            return None
    if task.points < FEW * task.dof**2:
        return Route("LAPACK", 1, f"few points ({task.points})")
    return Route("numpy", 1, reason)


def _is_worth_it(task: Task) -> bool:
    from flexmodal.frf.kernels import compiled

    kernel = compiled.sweep_of(task.shape) if task.fits_fixed else compiled.sweep_of_any_size()
    seconds = task.points * (0.3e-6 + 3e-9 * task.dof**3 + 0.05e-6 * len(task.pairs))
    return is_worth_it(task.shape, seconds, kernel.seconds, kernel.is_stored)


def _goes_along(task: Task) -> bool:
    return task.recursion is not None and task.dof >= LONG[task.chain]


def is_ready(task: Task) -> bool:
    """Whether this process has used the task's compiled kernel already."""
    return task.shape in _LOADED


@cache
def has_numba() -> bool:
    """Whether numba is installed, and not kept out by None in `sys.modules`."""
    if "numba" in sys.modules:
        return sys.modules["numba"] is not None
    return find_spec("numba") is not None


def thread_faults(threads: int | None) -> list[Fault]:
    """What is wrong with a number of threads: a fault, or none."""
    if threads is None or (isinstance(threads, int) and not isinstance(threads, bool) and threads >= 1):
        return []
    return [Fault("call", "threads", repr(threads), "a whole number of at least 1, or none")]


def in_parts(count: int, cores: int, solve: Callable[[slice], Result]) -> list[Result]:
    """Work on a range cut into as many parts as there are cores, each in a thread of its own.

    Args:
        count: length of the range.
        cores: how many parts.
        solve: called with each part.
    """
    edges = np.linspace(0, count, cores + 1).astype(int).tolist()
    parts = [slice(first, last) for first, last in pairwise(edges)]
    if cores == 1:
        return [solve(parts[0])]
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(solve, parts))


def available_cores() -> int:
    """Cores this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run(task: Task, route: Route) -> Complex[np.ndarray, "system line pair"]:
    """Take a route.

    Args:
        task: what is to be solved.
        route: from `choose`.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    out = np.empty((task.count, len(task.omega), len(task.pairs)), dtype=complex)
    if route.way in ("LAPACK", "numpy"):
        for systems, lines in blocks_of(task):
            solve_block = task.solve_numpy if route.way == "numpy" else task.solve_lapack
            solve_block(systems, lines, out[systems, lines])
        return out
    recursion = task.recursion
    from flexmodal.frf.kernels import compiled

    if route.way == "recursion" and recursion is not None:
        other = compiled.sweep_of_any_size().compiled

        def solve(place: tuple[slice, slice]) -> None:
            if recursion(*place, out[place]):
                posed = task.block(place[0])
                if solve_from_base(task, posed, place[1], other, out[place]):
                    task.solve_pivoting(*place, out[place], posed)
    else:
        kernel = compiled.sweep_of(task.shape) if route.way == "compiled" else compiled.sweep_of_any_size()
        sweep, repair = kernel.compiled, compiled.repair().compiled
        _LOADED.add(task.shape)

        def solve(place: tuple[slice, slice]) -> None:
            task.solve_compiled(*place, sweep, repair, out[place])

    if route.threads == 1:
        for place in blocks_of(task):
            solve(place)
        return out
    with ThreadPoolExecutor(route.threads) as pool:
        list(pool.map(solve, blocks_of(task)))
    return out


def blocks_of(task: Task) -> Iterator[tuple[slice, slice]]:
    """Cut a task into blocks of systems and lines."""
    lines = min(len(task.omega), _POINTS)
    systems = max(1, _POINTS // lines)
    if systems > LANES:
        systems -= systems % LANES
    for first in range(0, task.count, systems):
        for start in range(0, len(task.omega), lines):
            yield (
                slice(first, min(first + systems, task.count)),
                slice(start, min(start + lines, len(task.omega))),
            )
