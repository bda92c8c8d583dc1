"""Parameters from FRFs: Gauss and Newton's method on the complex logarithm of model over measurement.

    r = ln(α_model / α_measured),   phase wrapped to (−π, π],   ∂r = ∂α / α,

each line weighted by 1/(σ² + ε²): σ² its relative variance of measurement, ε a floor for what the model
leaves out. The floor is lowered in steps, which leads past local minima at resonances and antiresonances.
Large residuals count linearly (Huber, Ann. Math. Statist. 35, 1964). Priors enter as in any maximum a
posteriori estimate; steps are damped after Levenberg and Marquardt.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.identification.descent import Normal, descend, prior_cost, robust, robust_weight
from flexmodal.identification.layout import summed
from flexmodal.identification.model import Model, predictions
from flexmodal.identification.observations import Observations

FLOORS = (0.2, 0.05, 0.01)
"""Relative model error ε, in the order in which it is lowered."""
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
    share: Float[np.ndarray, " observation"] | None = None
    """Multiple of each observation's weight; 1 if None."""

    def weight(self, observations: Observations) -> Float[np.ndarray, "observation line"]:
        """1/(σ² + ε²) where a line is used, else 0."""
        kept = observations.used[:, self.lines]
        variance = np.where(kept, observations.variance[:, self.lines], 1.0)
        weight = kept / (variance + self.floor**2)
        return weight if self.share is None else weight * self.share[:, None]


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
    some = bool(zero.any())
    if some:
        predicted, measured = np.where(zero, 1.0, predicted), np.where(zero, 1.0, measured)
    ratio = predicted / measured
    found = np.empty_like(ratio)
    # np.log of complex numbers takes one after the other, and several times as long as these two
    found.real, found.imag = np.log(np.abs(ratio)), np.arctan2(ratio.imag, ratio.real)
    if some:
        found[zero] = 10.0
    return found


def _square(r: np.ndarray) -> np.ndarray:
    return np.asarray(r.real**2 + r.imag**2)


def cost_of(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, weighing: Weighing
) -> float:
    """Cost alone: the robust sum of squares plus the prior's; infinite where there is no model."""
    weight = weighing.weight(observations)
    total = 0.0
    try:
        for seen in predictions(model, x, observations, weighing.lines, slopes=False):
            rows = seen.observations
            r = residual(seen.value[seen.entry], observations.value[rows][:, weighing.lines])
            total += float(np.sum(robust(weight[rows] * _square(r))))
    except (np.linalg.LinAlgError, SingularResponse):
        return float("inf")
    return total + prior_cost(model.space, x)


def normal_equations(
    model: Model,
    x: Float[np.ndarray, " parameter"],
    observations: Observations,
    weighing: Weighing,
    *,
    apart: bool = False,
) -> Normal:
    """Cost, gradient and curvature at x; `apart`: with what each observation adds to the curvature."""
    weight = weighing.weight(observations)
    size, count = len(model.space), len(observations) if apart else 0
    curvature, gradient = np.zeros((size, size)), model.space.precision * x
    blocks = np.zeros((count, size, size)) if apart else None
    scores, squared = np.zeros((count, size)), np.zeros(count)
    data_cost = 0.0
    for seen in predictions(model, x, observations, weighing.lines, slopes=True):
        rows, value = seen.observations, np.where(seen.value == 0, np.inf, seen.value)
        r = residual(seen.value[seen.entry], observations.value[rows][:, weighing.lines])
        scaled = weight[rows] * _square(r)
        data_cost += float(np.sum(robust(scaled)))
        w = weight[rows] * robust_weight(scaled)
        if blocks is None:  # observations of one receptance have their derivatives in common
            together = summed(w, seen.entry, len(value))
            root = np.sqrt(together)
            pull = summed(w * r, seen.entry, len(value)) / np.where(root > 0, root, np.inf)
            flat = seen.slopes(root / value).reshape(size, -1)
            curvature += flat @ flat.T
            gradient = gradient + flat @ np.stack([pull.real, pull.imag], axis=1).ravel()
            continue
        squared[rows] = scaled.sum(axis=1)
        relative, root = seen.slopes(1 / value), np.sqrt(w)
        for row, entry, half, own in zip(rows.tolist(), seen.entry.tolist(), root, r, strict=True):
            each = (relative[:, entry] * half).reshape(size, -1)
            scores[row] = each @ np.concatenate([own.real * half, own.imag * half])
            blocks[row] = each @ each.T
    if blocks is not None:
        curvature, gradient = blocks.sum(axis=0), gradient + scores.sum(axis=0)
    return Normal(
        data_cost + prior_cost(model.space, x), data_cost, gradient, curvature, scores, squared, blocks
    )


def fit(
    model: Model,
    observations: Observations,
    start: Float[np.ndarray, " parameter"] | None = None,
    *,
    floors: Sequence[float] = FLOORS,
    stride: int = 1,
    lines: Int[np.ndarray, " line"] | None = None,
    share: Float[np.ndarray, " observation"] | None = None,
    steps: int = STEPS,
    apart: bool = True,
    settled: float = FINE,
    hold: Mapping[str, float] | None = None,
    advance: Callable[[int, float], None] = lambda step, cost: None,
) -> FrfFit:
    """Fit a model to observations.

    Args:
        model: with its parameter space.
        observations: measured receptances.
        start: coordinates; the card by default.
        floors: relative model errors, lowered one after the other.
        stride: look at every so many lines.
        lines: numbers of the lines to look at, instead.
        share: multiple of each observation's weight, 0 or more.
        steps: most at each floor.
        apart: end with what each observation adds to the curvature, as `uncertainty` needs it.
        settled: a step that changes the cost relatively by less ends the last round.
        hold: coordinates that stay where they are put, by name.
        advance: called after each step with its number and the cost.
    """
    x = np.zeros(len(model.space)) if start is None else np.array(start, dtype=float)
    if lines is None:
        lines = np.arange(stride // 2, len(observations.axis), stride)
    if not floors:
        raise InvalidRequest(Fault("call", "floors", "none", "at least one"))
    total = 0
    for number, floor in enumerate(floors):
        weighing = Weighing(floor, lines, share)
        found = descend(
            model.space,
            lambda x, w=weighing: normal_equations(model, x, observations, w),  # type: ignore[misc]
            lambda x, w=weighing: cost_of(model, x, observations, w),  # type: ignore[misc]
            x,
            most=steps,
            settled=settled if number == len(floors) - 1 else SETTLED,
            hold=hold,
            advance=lambda step, cost, before=total: advance(before + step, cost),  # type: ignore[misc]
        )
        x, total = found.x, total + found.steps
    normal = found.normal
    if apart:
        normal = normal_equations(model, x, observations, weighing, apart=True)
    return FrfFit(x, normal, weighing, found.converged, total)
