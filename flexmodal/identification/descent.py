"""Levenberg and Marquardt's descent on robust least squares with priors, inside bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from flexmodal.structure.parameter import ParameterSpace

HUBER = 3.0
"""Residuals beyond this many standard deviations count linearly (Huber, Ann. Math. Statist. 35, 1964)."""
LONGEST = 1.0
"""Longest step along a coordinate: a factor e, or one unit."""
HALVINGS, LEAST = 12, 1e-12
"""Of the search for what shortens a step: how often its range is halved, and its lower end over the upper."""
FIRST, LAST = 1e-3, 1e8
"""Damping of the first step, and where a search gives up."""
AGAIN, HARDER = 3e-3, 8.0
"""Damping from which it grows where a step leads up, and how many times: with less a step hardly changes."""
VAIN = 0.1
"""Part of what ends a descent that a shorter step has to promise, for one to be tried."""


@dataclass(frozen=True, eq=False)
class Normal:
    """Cost and normal equations at one point, and each observation's share in them if it was asked for."""

    cost: float
    data_cost: float
    gradient: Float[np.ndarray, " parameter"]
    curvature: Float[np.ndarray, "parameter parameter"]
    """Gauss–Newton Hessian of half the cost, without the prior."""
    scores: Float[np.ndarray, "observation parameter"]
    squared: Float[np.ndarray, " observation"]
    """Σ w |r|² of each observation."""
    blocks: Float[np.ndarray, "observation parameter parameter"] | None
    """What each observation adds to the curvature; None where nobody asked."""

    def ordered(self, order: Int[np.ndarray, " parameter"]) -> Normal:
        """The same with the parameters in another order.

        Args:
            order: number of each parameter among those here.
        """
        square = np.ix_(order, order)
        return replace(
            self,
            gradient=self.gradient[order],
            curvature=self.curvature[square],
            scores=self.scores[:, order],
            blocks=None if self.blocks is None else self.blocks[:, order][:, :, order],
        )


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended."""

    x: Float[np.ndarray, " parameter"]
    cost: float
    steps: int
    converged: bool


def descend(
    space: ParameterSpace,
    equations: Callable[[Float[np.ndarray, " parameter"]], Normal],
    cost: Callable[[Float[np.ndarray, " parameter"]], float],
    x: Float[np.ndarray, " parameter"],
    *,
    most: int,
    settled: float,
    near: float = 0.0,
    hold: Mapping[str, float] | None = None,
    advance: Callable[[int, float], None] = lambda step, cost: None,
) -> Descent:
    """Go down from x; coordinates that push against a bound are held.

    A cost of ten thousands of lines hardly changes along what the prior alone holds; there only `near` tells
    that a descent is at its end.

    Args:
        space: with bounds and priors.
        equations: cost, gradient and curvature.
        cost: the cost alone, infinite where the model does not exist.
        x: where to begin.
        most: steps.
        settled: a step that changes the cost relatively by less is the last.
        near: if above 0, it ends where Newton's step is shorter instead, in standard errors.
        hold: coordinates that stay where they are put, by name.
        advance: called after each step with its number and the cost.
    """
    x, low, high = _begun(space, x, hold or {})
    prior = np.diag(space.precision)
    normal, damping = equations(x), FIRST
    for taken in range(1, most + 1):
        free = ~(((x <= low) & (normal.gradient > 0)) | ((x >= high) & (normal.gradient < 0)))
        hessian = normal.curvature + prior
        if not free.any() or (near and _is_near(hessian, normal.gradient, free, near)):
            return Descent(x, normal.cost, taken - 1, True)
        found, first = None, damping
        while found is None and damping < LAST:
            step = np.zeros(len(x))
            damped = hessian + np.diag(damping * np.diag(hessian) + 1e-300)
            step[free] = short_step(damped[np.ix_(free, free)], normal.gradient[free])
            trial = np.clip(x + step, low, high)
            value = cost(trial)
            if np.isfinite(value) and value < normal.cost:
                found = trial
            elif _promised(step, normal.gradient, hessian) < VAIN * (near**2 or settled * normal.cost):
                break
            else:
                damping = max(damping, AGAIN) * HARDER
        if found is None:
            return Descent(x, normal.cost, taken, True)
        gained = (normal.cost - value) / max(normal.cost, 1e-300)
        x, damping = found, damping / 5 if damping == first else damping
        advance(taken, value)
        ended = gained < settled and not near
        if ended or taken == most:
            return Descent(x, value, taken, ended)
        normal = equations(x)
    return Descent(x, normal.cost, most, False)


def _begun(
    space: ParameterSpace, x: Float[np.ndarray, " parameter"], hold: Mapping[str, float]
) -> tuple[Float[np.ndarray, " parameter"], ...]:
    """Where to begin, and lower and upper bounds, which hold what stays."""
    low, high = (bound.copy() for bound in space.bounds)
    x = np.array(x, dtype=float)
    for name, value in hold.items():
        k = space.index[name]
        x[k] = low[k] = high[k] = value
    return x, low, high


def _is_near(
    hessian: Float[np.ndarray, "parameter parameter"],
    gradient: Float[np.ndarray, " parameter"],
    free: Bool[np.ndarray, " parameter"],
    near: float,
) -> bool:
    """Whether Newton's step is short where the inverse of the curvature is the covariance.

    Then no coordinate is farther from the minimum in its standard errors (Boyd and Vandenberghe, Convex
    Optimization, 2004, 9.5).
    """
    pull = gradient[free]
    return float(pull @ np.linalg.lstsq(hessian[np.ix_(free, free)], pull, rcond=None)[0]) < near**2


def _promised(
    step: Float[np.ndarray, " parameter"],
    gradient: Float[np.ndarray, " parameter"],
    hessian: Float[np.ndarray, "parameter parameter"],
) -> float:
    """By how much the cost would fall if it were quadratic."""
    return float(-(2 * gradient @ step + step @ hessian @ step))


def short_step(
    curvature: Float[np.ndarray, "parameter parameter"], gradient: Float[np.ndarray, " parameter"]
) -> Float[np.ndarray, " parameter"]:
    """A Newton step with no component above `LONGEST`; what hardly matters is held back first.

    Where it is longer, a multiple of the unit matrix is added to the curvature (Levenberg, Quart. Appl. Math.
    2, 1944). A step that were shortened as a whole would go nowhere once one parameter does not matter.

    Args:
        curvature: positive definite.
        gradient: of half the cost.
    """
    step = -np.linalg.solve(curvature, gradient)
    if np.max(np.abs(step)) <= LONGEST:
        return np.asarray(step)
    values, vectors = np.linalg.eigh(curvature)
    along = vectors.T @ gradient
    high = float(np.linalg.norm(gradient)) / LONGEST  # that is always enough
    low = high * LEAST
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        step = -vectors @ (along / (values + middle))
        low, high = (low, middle) if np.max(np.abs(step)) <= LONGEST else (middle, high)
    return np.asarray(-vectors @ (along / (values + high)))


def robust(scaled: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Huber's function of a squared standardised residual."""
    return np.where(scaled <= HUBER**2, scaled, 2 * HUBER * np.sqrt(scaled) - HUBER**2)


def robust_weight(scaled: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Its weight: 1 inside, falling as one over the residual outside."""
    return np.minimum(1.0, HUBER / np.sqrt(np.maximum(scaled, 1e-300)))


def prior_cost(space: ParameterSpace, x: Float[np.ndarray, " parameter"]) -> float:
    """What the prior adds to the cost."""
    return float(np.sum(space.precision * x**2))
