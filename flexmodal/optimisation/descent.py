"""One descent from one start, every iterate on the hold and within the limits.

A quasi-Newton method in the tangent space of the hold: the step minimises a quadratic model between the
limits, a Newton retraction puts the trial point back on the target while joints at a limit stay there, and
a backtracking line search on the true cost accepts it. The model matrix is a damped BFGS estimate of the
Hessian of the Lagrangian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmodal.errors import FlexmodalError
from flexmodal.optimisation.objective import Limit
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.quadratic import quadratic_step

GRADIENT = 1e-7
"""Projected gradient of the logarithmic cost that counts as zero [1/rad]."""

_ROUNDING = 1e-4
"""Projected gradient below which a line search that finds nothing better has met rounding."""

_SWAMPING = 1e6
"""Gradient beside which limits of a few radians are lost in rounding [1/rad]."""

_LONGEST = 0.5
"""Longest step of one joint [rad, m]."""


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended."""

    values: np.ndarray
    cost: float
    converged: bool
    iterations: int
    limit: Limit = Limit.NONE


Watch = Callable[[np.ndarray, float], None]
"""Told the vector and the cost of every iterate."""


def descend(
    problem: PostureProblem,
    start: np.ndarray,
    *,
    iterations: int = 200,
    watch: Watch = lambda values, cost: None,
) -> Descent | None:
    """Go down from a start; None if no posture on the hold can be reached from it.

    Args:
        problem: what to minimise.
        start: vector of the commanded joints; brought onto the hold first.
        iterations: give up after this many.
        watch: told every iterate.
    """
    values = problem.retract(start)
    if values is None:
        return None
    cost, gradient = problem.cost_and_gradient(values)
    model, fresh = _first_model(gradient), True
    for count in range(iterations):
        watch(values, cost)
        _, constraint = problem.held(values)
        room = (problem.lower - values, problem.upper - values)
        steepness = _steepness(gradient, constraint, *room)
        limit = problem.objective.limit(cost, problem.robot)
        if limit is not Limit.NONE or steepness <= GRADIENT:
            return Descent(values, cost, limit is not Limit.UNBOUNDED, count, limit)
        found = _line_search(problem, values, cost, gradient, _step(model, gradient, constraint, *room))
        if found is None:
            if fresh:
                return Descent(values, cost, steepness <= _ROUNDING, count)
            model, fresh = _first_model(gradient), True
            continue
        next_values, next_cost, next_gradient = found
        _, next_constraint = problem.held(next_values)
        free = (next_values > problem.lower) & (next_values < problem.upper)
        change = _lagrangian_change(gradient, constraint, next_gradient, next_constraint, free)
        model = _update(model, next_values - values, change, first=fresh)
        values, cost, gradient, fresh = next_values, next_cost, next_gradient, False
    return Descent(values, cost, False, iterations)


def _steepness(gradient: np.ndarray, constraint: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """Length of the steepest-descent step that hold and limits leave; beside a zero it is scaled down."""
    scale = max(1.0, float(np.linalg.norm(gradient)) / _SWAMPING)
    step = quadratic_step(np.eye(len(gradient)), gradient / scale, constraint, lower, upper)
    return float(np.linalg.norm(step))


def _first_model(gradient: np.ndarray) -> np.ndarray:
    """A multiple of the identity whose step is no longer than 0.2."""
    return np.eye(len(gradient)) * max(1.0, float(np.max(np.abs(gradient), initial=0.0)) / 0.2)


def _step(
    model: np.ndarray, gradient: np.ndarray, constraint: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """The step, shortened; steepest descent where the model has lost its definiteness to rounding."""
    try:
        step = quadratic_step(model, gradient, constraint, lower, upper)
    except np.linalg.LinAlgError:
        step = quadratic_step(_first_model(gradient), gradient, constraint, lower, upper)
    longest = float(np.max(np.abs(step), initial=0.0))
    return step * min(1.0, _LONGEST / longest) if longest > 0 else step


def _line_search(
    problem: PostureProblem, values: np.ndarray, cost: float, gradient: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray] | None:
    """Backtrack along the retracted step until the cost falls enough."""
    slope = float(gradient @ step)
    if slope >= 0:
        return None
    length = 1.0
    for _ in range(40):
        trial = problem.retract(values + length * step, steps=15)
        if trial is not None and np.max(np.abs(trial - values)) <= 2 * length * np.max(np.abs(step)) + 1e-9:
            try:
                found = problem.if_below(trial, cost + 1e-4 * length * slope)
            except FlexmodalError:
                found = None
            if found is not None and np.isfinite(found[0]) and found[0] < cost:
                return trial, *found
        length *= 0.5 if length > 0.1 else 0.2
    return None


def _lagrangian_change(
    gradient: np.ndarray,
    constraint: np.ndarray,
    next_gradient: np.ndarray,
    next_constraint: np.ndarray,
    free: np.ndarray,
) -> np.ndarray:
    """Change of the Lagrangian's gradient at the newer multipliers, those of the joints off their limits."""
    if len(constraint) == 0:
        return next_gradient - gradient
    multipliers = np.linalg.lstsq(next_constraint[:, free].T, next_gradient[free], rcond=None)[0]
    return (next_gradient - next_constraint.T @ multipliers) - (gradient - constraint.T @ multipliers)


def _update(model: np.ndarray, moved: np.ndarray, change: np.ndarray, *, first: bool) -> np.ndarray:
    """Powell's damped BFGS, which keeps the model positive definite; the first step sets its size."""
    curvature = float(moved @ change)
    if first and curvature > 0:
        model = np.eye(len(moved)) * float(change @ change) / curvature
    expected = model @ moved
    bend = float(moved @ expected)
    if bend <= 0 or not np.isfinite(bend):
        return np.eye(len(moved))
    if curvature < 0.2 * bend:
        weight = 0.8 * bend / (bend - curvature)
        change = weight * change + (1 - weight) * expected
        curvature = float(moved @ change)
    return model - np.outer(expected, expected) / bend + np.outer(change, change) / curvature
