"""The posture that resists best: holding the end-effector, along a family, or free."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmodal.cards import FamilyCard
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest, SingularResponse
from flexmodal.model import Posture
from flexmodal.model.robot import Pose
from flexmodal.optimisation.descent import Descent, descend
from flexmodal.optimisation.family import search_family
from flexmodal.optimisation.null_space import null_space_descent
from flexmodal.optimisation.objective import Limit
from flexmodal.optimisation.outcome import Optimum, Outcome, distinct
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.unreachable import unreachable

METHODS = ("newton", "null-space")
DEFAULT_STARTS = 64

Advance = Callable[[], None]
Improved = Callable[[float], None]


def optimise(
    problem: PostureProblem,
    *,
    family: FamilyCard | None = None,
    start: Pose | None = None,
    starts: int = DEFAULT_STARTS,
    seed: int = 0,
    method: str = "newton",
    advance: Advance = lambda: None,
    improved: Improved = lambda value: None,
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
        improved: called with the objective of the best so far, whenever it is better than before.

    Returns:
        All distinct optima found, best first. Interrupted by Ctrl-C, what was found until then.

    Raises:
        InvalidRequest: options that contradict one another or are out of range.
        InvalidPosture: a bad start.
        Unreachable: no start could be brought to the target.
        SingularResponse: at every start an undamped mode is driven at its natural frequency.
    """
    _check(problem, family, start, starts, method)
    posture = None if start is None else problem.robot.posture(start)
    before = None if posture is None else _value(problem, posture)
    given = None if posture is None else problem.vector(posture)
    if family is not None:
        found = [Descent(values, cost, True, 0) for cost, values in search_family(problem, family, advance)]
        return _outcome(problem, found, before, "family")
    if method == "null-space":
        assert given is not None
        return _outcome(problem, [null_space_descent(problem, given)], before, method)
    found, tried, interrupted = _search(problem, given, starts, seed, advance, improved)
    return _outcome(problem, found, before, method, tried=tried, interrupted=interrupted)


def _search(
    problem: PostureProblem,
    given: np.ndarray | None,
    starts: int,
    seed: int,
    advance: Advance,
    improved: Improved,
) -> tuple[list[Descent], int, bool]:
    """Descents from the given start and random ones; stops at Ctrl-C once there is something to keep."""
    generator = np.random.default_rng(seed)
    found: list[Descent] = []
    trouble: FlexmodalError | None = None
    best, count = np.inf, 0
    try:
        for count in range(starts):
            first = count == 0 and given is not None
            vector = given if first and given is not None else problem.random_vector(generator)
            try:
                result = descend(problem, vector)
                if result is None and first:
                    result = _from_beside(problem, vector)
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
        return found, count, True
    if not found:
        raise trouble or unreachable(problem, starts)
    return found, starts, False


def _from_beside(problem: PostureProblem, start: np.ndarray) -> Descent | None:
    """From a start that no step leads away from, as where a stretched arm is to reach inwards."""
    generator = np.random.default_rng(0)
    for size in (0.01, 0.03, 0.1, 0.3):
        result = descend(problem, start + generator.normal(scale=size, size=len(start)))
        if result is not None:
            return result
    return None


def _value(problem: PostureProblem, posture: Posture) -> float:
    """The objective at a start; infinite where it drives an undamped mode at its natural frequency."""
    try:
        return problem.objective.value(problem.robot.at(posture))
    except SingularResponse:
        return float("inf")


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


def _outcome(
    problem: PostureProblem,
    found: list[Descent],
    before: float | None,
    method: str,
    *,
    tried: int = 0,
    interrupted: bool = False,
) -> Outcome:
    bounded = [result for result in found if result.limit is not Limit.UNBOUNDED]
    unbounded = len(found) - len(bounded)
    # A descent that did not meet the tolerance still counts where it is the best there is.
    best = min(bounded or found, key=lambda result: result.cost)
    kept = [result for result in bounded if result.converged or result is best] or [best]
    optima = tuple(
        Optimum(problem.posture(values), problem.objective.value(problem.posed(values)), hits)
        for _, values, hits in distinct(problem, [(result.cost, result.values) for result in kept])
    )
    return Outcome(
        problem,
        optima,
        before,
        best.converged,
        len(found),
        unbounded,
        method,
        tried or len(found),
        interrupted,
    )
