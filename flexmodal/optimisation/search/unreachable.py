"""Why no posture is on the hold, in a sentence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.errors import Unreachable
from flexmodal.optimisation.problem import PostureProblem

_TRIES = 50


def unreachable(problem: PostureProblem, starts: int) -> Unreachable:
    """The error for a hold that no start came to: how near it gets, and whether the limits are in the way.

    Args:
        problem: with the hold.
        starts: how many were tried.
    """
    assert problem.hold is not None
    held = len(problem.hold.target)
    error, _ = nearest(problem)
    place = ", ".join(f"{value:g}" for value in problem.hold.target)
    turned = "" if problem.hold.orientation is None else " turned as asked"
    gap = f"{np.linalg.norm(error[:held]):.3g} m away"
    if turned:
        gap += f" and {np.degrees(np.linalg.norm(error[held:])):.3g}° off"
    sentence = (
        f"no posture within the joint limits puts {problem.hold.point} at ({place}) m{turned}: none of "
        f"{starts} starts got there, the nearest was {gap}"
    )
    return Unreachable(sentence + _limits_in_the_way(problem))


def nearest(problem: PostureProblem) -> tuple[np.ndarray, np.ndarray]:
    """Smallest error that damped steps from many places come to, and the posture there.

    Damped steps do not overshoot where a hold leaves little or nothing free, as a Newton step may.
    """
    generator = np.random.default_rng(0)
    best, there = np.full(1, np.inf), problem.lower
    for _ in range(_TRIES):
        values = problem.random_vector(generator)
        for _ in range(50):
            error, jacobian = problem.held(values)
            if np.linalg.norm(error) < np.linalg.norm(best):
                best, there = error, values
            step = -jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-3 * np.eye(len(error)), error)
            values = np.clip(values + step, problem.lower, problem.upper)
    return best, there


def _limits_in_the_way(problem: PostureProblem) -> str:
    """Which joints would have to go beyond their limits, if that would help; of several ways the shortest."""
    wide = np.full(len(problem.names), np.inf)
    free = replace(problem, limits=(-wide, wide))
    generator = np.random.default_rng(1)
    best: list[tuple[float, str]] = []
    for _ in range(_TRIES):
        values = free.retract(problem.random_vector(generator))
        if values is None:
            continue
        turns = np.round((values - np.clip(values, problem.lower, problem.upper)) / (2 * np.pi))
        values = values - np.where(problem.turning, turns * 2 * np.pi, 0.0)
        beyond = np.abs(values - np.clip(values, problem.lower, problem.upper))
        names = [name for name, by in zip(problem.names, beyond, strict=True) if by > 1e-6]
        if names:
            best.append((float(beyond.max()), ", ".join(names)))
    if not best:
        return ""
    return f"; it could be reached if {min(best)[1]} went beyond the limits"
