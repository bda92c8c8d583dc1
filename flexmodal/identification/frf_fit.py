"""Parameters from FRFs: Gauss and Newton's method on the complex logarithm of model over measurement.

    r = ln(α_model / α_measured),   phase wrapped to (−π, π],   ∂r = ∂α / α,

each line weighted by 1/(σ² + ε²): σ² its relative variance of measurement, ε a floor for what the model
leaves out. The floor is lowered in steps, which leads past local minima at resonances and antiresonances.
Large residuals count linearly (Huber, Ann. Math. Statist. 35, 1964). Priors enter as in any maximum a
posteriori estimate; steps are damped after Levenberg and Marquardt.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.model import Model, evaluated
from flexmodal.identification.observations import Observations

FLOORS = (0.2, 0.05, 0.01)
"""Relative model error ε, in the order in which it is lowered."""
HUBER = 3.0
"""Residuals beyond this many standard deviations count linearly."""
STEPS = 30
"""At most, at each floor."""
SETTLED = 1e-3
"""A step that changes the cost relatively by less ends a round; the last one goes on to `FINE`."""
FINE = 1e-6


@dataclass(frozen=True, eq=False)
class Weighing:
    """How residuals count."""

    floor: float
    lines: np.ndarray
    """Numbers of the lines that are looked at."""

    def weight(self, observations: Observations) -> Float[np.ndarray, "observation line"]:
        """1/(σ² + ε²) where a line is used, else 0."""
        kept = observations.used[:, self.lines]
        variance = np.where(kept, observations.variance[:, self.lines], 1.0)
        return kept / (variance + self.floor**2)


@dataclass(frozen=True, eq=False)
class Normal:
    """Cost and normal equations at one point, and each observation's share of the gradient."""

    cost: float
    data_cost: float
    gradient: Float[np.ndarray, " parameter"]
    curvature: Float[np.ndarray, "parameter parameter"]
    """Gauss–Newton Hessian of half the cost, without the prior."""
    scores: Float[np.ndarray, "observation parameter"]
    squared: Float[np.ndarray, " observation"]
    """Σ w |r|² of each observation."""


@dataclass(frozen=True, eq=False)
class FrfFit:
    """Where a fit ended."""

    x: Float[np.ndarray, " parameter"]
    normal: Normal
    weighing: Weighing
    converged: bool
    steps: int


def residual(
    predicted: Complex[np.ndarray, "*shape"], measured: Complex[np.ndarray, "*shape"]
) -> Complex[np.ndarray, "*shape"]:
    """ln(predicted / measured), phase wrapped; 10 where one of them is exactly zero."""
    zero = (predicted == 0) | (measured == 0)
    ratio = np.where(zero, 1.0, predicted) / np.where(zero, 1.0, measured)
    return np.where(zero, 10.0, np.log(ratio))


def cost_of(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, weighing: Weighing
) -> float:
    """Cost alone: the robust sum of squares plus the prior's."""
    weight = weighing.weight(observations)
    total = 0.0
    try:
        for rows, value, _ in evaluated(model, x, observations, weighing.lines, slopes=False):
            r = residual(value, observations.value[rows][:, weighing.lines])
            total += float(np.sum(_robust(weight[rows] * np.abs(r) ** 2)))
    except np.linalg.LinAlgError:
        return float("inf")
    return total + _prior(model, x)


def normal_equations(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, weighing: Weighing
) -> Normal:
    """Cost, gradient and curvature at x."""
    weight = weighing.weight(observations)
    names = model.space.names
    size = len(names)
    curvature = np.zeros((size, size))
    scores, squared = np.zeros((len(observations), size)), np.zeros(len(observations))
    data_cost = 0.0
    for rows, value, slopes in evaluated(model, x, observations, weighing.lines, slopes=True):
        r = residual(value, observations.value[rows][:, weighing.lines])
        scaled = weight[rows] * np.abs(r) ** 2
        data_cost += float(np.sum(_robust(scaled)))
        squared[rows] = scaled.sum(axis=1)
        root = np.sqrt(weight[rows] * np.minimum(1.0, HUBER / np.sqrt(np.maximum(scaled, 1e-300))))
        relative = slopes * (root / np.where(value == 0, np.inf, value))
        real = relative.view(float)  # real and imaginary parts in turn
        scores[rows] = np.matmul(real.transpose(1, 0, 2), (r * root).view(float)[:, :, None])[:, :, 0]
        flat = real.reshape(size, -1)
        curvature += flat @ flat.T
    precision = model.space.precision
    gradient = scores.sum(axis=0) + precision * x
    return Normal(data_cost + _prior(model, x), data_cost, gradient, curvature, scores, squared)


def fit(
    model: Model,
    observations: Observations,
    start: Float[np.ndarray, " parameter"] | None = None,
    *,
    floors: Sequence[float] = FLOORS,
    stride: int = 1,
    steps: int = STEPS,
    settled: float = FINE,
    advance: Callable[[int, float], None] = lambda step, cost: None,
) -> FrfFit:
    """Fit a model to observations.

    Args:
        model: with its parameter space.
        observations: measured receptances.
        start: coordinates; the card by default.
        floors: relative model errors, lowered one after the other.
        stride: look at every so many lines.
        steps: most at each floor.
        settled: a step that changes the cost relatively by less ends the last round.
        advance: called after each step with its number and the cost.
    """
    x = np.zeros(len(model.space)) if start is None else np.array(start, dtype=float)
    lines = np.arange(stride // 2, len(observations.axis), stride)
    total, converged = 0, False
    if not floors:
        raise InvalidRequest(Fault("call", "floors", "none", "at least one"))
    for number, floor in enumerate(floors):
        weighing = Weighing(floor, lines)
        last = number == len(floors) - 1
        x, normal, taken, converged = _descend(
            model, x, observations, weighing, steps, settled if last else SETTLED, advance, total
        )
        total += taken
    return FrfFit(x, normal, weighing, converged, total)


def _descend(
    model: Model, x: np.ndarray, observations: Observations, weighing: Weighing, most: int, settled: float,
    advance: Callable[[int, float], None], before: int,
) -> tuple[np.ndarray, Normal, int, bool]:  # fmt: skip
    """Levenberg and Marquardt within the bounds: coordinates that push against one are held."""
    low, high = model.space.bounds
    precision = model.space.precision
    normal = normal_equations(model, x, observations, weighing)
    damping, taken = 1e-3, 0
    for taken in range(1, most + 1):
        free = ~(((x <= low) & (normal.gradient > 0)) | ((x >= high) & (normal.gradient < 0)))
        if not free.any():
            return x, normal, taken, True
        hessian = normal.curvature + np.diag(precision)
        scale = np.diag(hessian)
        better = False
        while damping < 1e8:
            step = np.zeros(len(x))
            damped = hessian + np.diag(damping * scale + 1e-300)
            step[free] = -np.linalg.solve(damped[np.ix_(free, free)], normal.gradient[free])
            step *= min(1.0, 1.0 / max(np.max(np.abs(step)), 1e-300))  # at most a factor e, or one unit
            trial = np.clip(x + step, low, high)
            cost = cost_of(model, trial, observations, weighing)
            if np.isfinite(cost) and cost < normal.cost:
                better = True
                break
            damping = max(damping, 1e-6) * 8
        if not better:
            return x, normal, taken, True
        gained = (normal.cost - cost) / max(normal.cost, 1e-300)
        x, damping = trial, damping / 5
        normal = normal_equations(model, x, observations, weighing)
        advance(before + taken, normal.cost)
        if gained < settled:
            return x, normal, taken, True
    return x, normal, taken, False


def _robust(scaled: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Huber's function of a squared standardised residual."""
    return np.where(scaled <= HUBER**2, scaled, 2 * HUBER * np.sqrt(scaled) - HUBER**2)


def _prior(model: Model, x: np.ndarray) -> float:
    return float(np.sum(model.space.precision * x**2))
