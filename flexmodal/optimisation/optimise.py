"""The posture that resists best: holding the end-effector, along a family, or free."""

from __future__ import annotations

import numpy as np

from flexmodal.cards import FamilyCard
from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.model import Pose, Posture
from flexmodal.optimisation.outcome import Optimum, Outcome, Start
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search import (
    WAYS,
    Advance,
    Basins,
    Descent,
    Ends,
    Improved,
    is_compilable,
    merged,
    nearest_held,
    null_space_descent,
    search,
    search_family,
    tell_apart,
)

_HELD = 1e-6
"""Error of a hold below which a posture holds: printed angles have so many digits [m, rad]."""

METHODS = ("newton", "null-space")


def optimise(
    problem: PostureProblem,
    *,
    family: FamilyCard | None = None,
    start: Pose | None = None,
    starts: int | None = None,
    seed: int = 0,
    method: str = "newton",
    way: str = "auto",
    advance: Advance = lambda: None,
    improved: Improved = lambda value: None,
) -> Outcome:
    """Search for the best posture.

    Args:
        problem: robot, objective and hold.
        family: search only along this family; excludes a hold.
        start: a posture to compare with and to start from as well; brought onto the hold for both.
        starts: how many starts in all, the given one included; the rest are random. If none, 64; where the
            descents run compiled, 256 at a time until five ended in the best, 4096 at most.
        seed: of the random starts; the same seed gives the same answer, but for rounding where one search is
            compiled and the other is not.
        method: "newton" (feasible quasi-Newton, many starts) or "null-space" (the thesis's descent, from
            the given start only).
        way: "compiled" (a serial chain judged by receptance, stiffness or mobility, with numba installed),
            "plain" (one by one in Python) or "auto": compiled where that applies and the code is on disk, or
            where the searches of this process would have paid for its compilation. The descents are the same
            but for rounding.
        advance: called once a start, for a progress bar.
        improved: called with the objective of the best so far, whenever it is better than before.

    Returns:
        All distinct optima found, best first, those of equal value as one. Interrupted by Ctrl-C, what was
        found until then.

    Raises:
        InvalidRequest: options that contradict one another or are out of range.
        InvalidPosture: a bad start.
        Unreachable: no start could be brought to the target.
        SingularResponse: at every start an undamped mode is driven at its natural frequency.
        MissingExtra: compiled descents were asked for and numba is not installed.
    """
    _check(problem, family, start, starts, method, way)
    posture = None if start is None else problem.robot.posture(start)
    before = None if posture is None else _compared(problem, posture)
    given = None if posture is None else problem.vector(posture)
    if family is not None:
        found = [Descent(values, cost, True, 0) for cost, values in search_family(problem, family, advance)]
        return _outcome(problem, tell_apart(problem, Ends.of(found)), before, "family")
    if method == "null-space":
        assert given is not None
        alone = tell_apart(problem, Ends.of([null_space_descent(problem, given)]))
        return _outcome(problem, alone, before, method)
    basins = search(problem, given, starts, seed, way, advance=advance, improved=improved)
    return _outcome(problem, basins, before, method, seed)


def _compared(problem: PostureProblem, posture: Posture) -> Start:
    """The start as given and as it holds the target: only that is compared with what the search finds."""
    value = _value(problem, posture)
    if problem.hold is None:
        return Start(posture, value, 0.0, posture, value)
    error = problem.hold.error(problem.robot.at(posture))
    away = float(np.linalg.norm(error[: len(problem.hold.target)]))
    if float(np.max(np.abs(error))) <= _HELD:
        return Start(posture, value, away, posture, value)
    found = nearest_held(problem, problem.vector(posture))
    if found is None:
        return Start(posture, value, away, None, None)
    held = problem.posture(found)
    return Start(posture, value, away, held, _value(problem, held))


def _value(problem: PostureProblem, posture: Posture) -> float:
    """The objective at a start; infinite where it drives an undamped mode at its natural frequency."""
    try:
        return problem.objective.value(problem.robot.at(posture))
    except SingularResponse:
        return float("inf")


def _check(
    problem: PostureProblem,
    family: FamilyCard | None,
    start: Pose | None,
    starts: int | None,
    method: str,
    way: str,
) -> None:
    faults = []
    if starts is not None and starts < 1:
        faults.append(Fault("call", "starts", str(starts), "at least 1"))
    if method not in METHODS:
        faults.append(Fault("call", "method", repr(method), " or ".join(METHODS)))
    if way not in WAYS:
        faults.append(Fault("call", "way", repr(way), ", ".join(WAYS)))
    if way == "compiled" and not is_compilable(problem):
        allowed = "a serial chain judged by receptance, stiffness or mobility, and numba installed"
        faults.append(Fault("call", "way", "compiled, which does not apply here", allowed))
    if method == "null-space" and start is None:
        faults.append(Fault("call", "start", "none", "a posture: the null-space method needs one"))
    if family is not None and problem.hold is not None:
        faults.append(Fault("call", "family", "a family and a hold", "one of them"))
    if family is not None and method == "null-space":
        faults.append(Fault("call", "method", "null-space along a family", "newton"))
    if problem.clearance is not None and method == "null-space":
        faults.append(Fault("call", "clearance", "with the null-space method", "newton"))
    if faults:
        raise InvalidRequest(faults)


def _outcome(
    problem: PostureProblem, found: Basins, before: Start | None, method: str, seed: int | None = None
) -> Outcome:
    near = None if before is None else problem.vector(before.held or before.given)
    optima = tuple(
        Optimum(
            problem.posture(group.values[0]),
            problem.objective.value(problem.posed(group.values[0])),
            group.hits,
            tuple(problem.posture(values) for values in group.values[1:]),
        )
        for group in merged(problem, found, near)
    )
    ends = found.ends
    counts = (ends.reached, ends.unbounded, method, len(ends.cost))
    return Outcome(problem, optima, before, found.settled, *counts, ends.interrupted, seed)
