"""The posture that resists best: holding the end-effector, along a family, or free."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmodal.cards import FamilyCard
from flexmodal.errors import Fault, InvalidRequest, Unreachable
from flexmodal.model.robot import Pose
from flexmodal.optimisation.descent import Descent, descend
from flexmodal.optimisation.family import search_family
from flexmodal.optimisation.null_space import null_space_descent
from flexmodal.optimisation.objective import Limit
from flexmodal.optimisation.outcome import Optimum, Outcome, distinct
from flexmodal.optimisation.problem import PostureProblem

METHODS = ("newton", "null-space")
DEFAULT_STARTS = 64

Advance = Callable[[], None]


def optimise(
    problem: PostureProblem,
    *,
    family: FamilyCard | None = None,
    start: Pose | None = None,
    starts: int = DEFAULT_STARTS,
    seed: int = 0,
    method: str = "newton",
    advance: Advance = lambda: None,
) -> Outcome:
    """Search for the best posture.

    Args:
        problem: robot, objective and hold.
        family: search only along this family; excludes a hold.
        start: a posture to compare with and to start from as well.
        starts: how many starts in all, the given one included; the rest are random.
        seed: of the random starts; the same seed gives the same answer.
        method: "newton" (feasible quasi-Newton, many starts) or "null-space" (the thesis's descent, from
            the given start only).
        advance: called once a start, for a progress bar.

    Returns:
        All distinct optima found, best first.

    Raises:
        InvalidRequest: options that contradict one another or are out of range.
        InvalidPosture: a bad start.
        Unreachable: no start could be brought to the target.
    """
    _check(problem, family, start, starts, method)
    posture = None if start is None else problem.robot.posture(start)
    before = None if posture is None else problem.objective.value(problem.robot.at(posture))
    given = None if posture is None else problem.vector(posture)
    if family is not None:
        found = [Descent(values, cost, True, 0) for cost, values in search_family(problem, family, advance)]
        return _outcome(problem, found, before, "family")
    if method == "null-space":
        assert given is not None
        return _outcome(problem, [null_space_descent(problem, given)], before, method)
    generator = np.random.default_rng(seed)
    found = []
    for count in range(starts):
        vector = given if count == 0 and given is not None else problem.random_vector(generator)
        result = descend(problem, vector)
        if result is not None:
            found.append(result)
        advance()
    if not found:
        raise _unreachable(problem, starts)
    return _outcome(problem, found, before, method)


def _check(
    problem: PostureProblem, family: FamilyCard | None, start: Pose | None, starts: int, method: str
) -> None:
    faults = []
    if starts < 1:
        faults.append(Fault("call", "starts", str(starts), "at least 1"))
    if method not in METHODS:
        faults.append(Fault("call", "method", repr(method), " or ".join(METHODS)))
    if method == "null-space" and start is None:
        faults.append(Fault("call", "start", "none", "a posture: the null-space method needs one"))
    if family is not None and problem.hold is not None:
        faults.append(Fault("call", "family", "a family and a hold", "one of them"))
    if family is not None and method == "null-space":
        faults.append(Fault("call", "method", "null-space along a family", "newton"))
    if faults:
        raise InvalidRequest(faults)


def _outcome(problem: PostureProblem, found: list[Descent], before: float | None, method: str) -> Outcome:
    bounded = [result for result in found if result.limit is not Limit.UNBOUNDED]
    unbounded = len(found) - len(bounded)
    # A descent that did not meet the tolerance still counts where it is the best there is.
    best = min(bounded or found, key=lambda result: result.cost)
    kept = [result for result in bounded if result.converged or result is best] or [best]
    optima = tuple(
        Optimum(problem.posture(values), problem.objective.value(problem.posed(values)), hits)
        for _, values, hits in distinct(problem, [(result.cost, result.values) for result in kept])
    )
    return Outcome(problem, optima, before, best.converged, len(found), unbounded, method)


def _unreachable(problem: PostureProblem, starts: int) -> Unreachable:
    assert problem.hold is not None
    generator = np.random.default_rng(0)
    nearest = np.inf
    for _ in range(50):
        values = problem.random_vector(generator)
        for _ in range(50):
            error, jacobian = problem.held(values)
            nearest = min(nearest, float(np.linalg.norm(error)))
            step = -jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-3 * np.eye(len(error)), error)
            values = np.clip(values + step, problem.lower, problem.upper)
    place = ", ".join(f"{value:g}" for value in problem.hold.target)
    return Unreachable(
        f"no posture within the joint limits puts {problem.hold.point} at ({place}) m: none of {starts} "
        f"starts got there, the nearest was {nearest:.3g} m away"
    )
