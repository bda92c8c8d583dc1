"""Parameters from FRFs: Gauss and Newton's method on the complex logarithm of model over measurement.

    r = ln(α_model / α_measured),   phase wrapped to (−π, π],   ∂r = ∂α / α,

each line weighted by 1/(σ² + ε²): σ² its relative variance of measurement, ε a floor for what the model
leaves out. The floor is lowered in steps, which leads past local minima at resonances and antiresonances.
Large residuals count linearly (Huber, Ann. Math. Statist. 35, 1964). Priors enter as in any maximum a
posteriori estimate; steps are damped after Levenberg and Marquardt.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.identification.descent import Normal, descend, prior_cost, robust, robust_weight
from flexmodal.identification.layout import summed
from flexmodal.identification.model import Model, ReceptanceModel, Seen, predictions
from flexmodal.identification.observations import Observations

FLOORS = (0.2, 0.05, 0.01)
"""Relative model error ε, in the order in which it is lowered."""
STEPS = 30
"""At most, at each floor."""
SETTLED = 1e-3
"""A step that changes the cost relatively by less ends a round; the last one goes on to `FINE`."""
FINE = 1e-6


@dataclass(frozen=True, eq=False)
class Weighting:
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


def square(r: np.ndarray) -> np.ndarray:
    """|r|²."""
    return np.asarray(r.real**2 + r.imag**2)


@dataclass(frozen=True, eq=False)
class FrfMisfit:
    """Robust sum of squares of a model on FRFs, and its normal equations; see `evidence.Misfit`.

    What the model predicted where it was asked last is kept: a fit asks for the normal equations where a step
    has just been tried.
    """

    model: Model
    observations: Observations
    weighing: Weighting

    def cost(self, x: Float[np.ndarray, " parameter"]) -> float:
        """The cost alone; infinite where there is no model."""
        total = 0.0
        try:
            for seen in self._predictions(x, slopes=False):
                total += float(np.sum(robust(self._weight[seen.observations] * square(self._residual(seen)))))
        except (np.linalg.LinAlgError, SingularResponse):
            return float("inf")
        return total + prior_cost(self.model.space, x)

    def equations(self, x: Float[np.ndarray, " parameter"], *, apart: bool = False) -> Normal:
        """Cost, gradient and curvature at x; `apart`: with what each observation adds to the curvature."""
        size = len(self.model.space)
        if apart:
            return self._apart(x)
        curvature, gradient = np.zeros((size, size)), self.model.space.precision * x
        data_cost = 0.0
        for seen in self._predictions(x, slopes=True):
            r, w, scaled = self._weighed(seen)
            data_cost += float(np.sum(robust(scaled)))
            # observations of one receptance have their derivatives in common
            value = np.where(seen.value == 0, np.inf, seen.value)
            together = summed(w, seen.entry, len(value))
            root = np.sqrt(together)
            pull = summed(w * r, seen.entry, len(value)) / np.where(root > 0, root, np.inf)
            flat = seen.slopes(root / value).reshape(size, -1)
            curvature += flat @ flat.T
            gradient = gradient + flat @ np.stack([pull.real, pull.imag], axis=1).ravel()
        cost = data_cost + prior_cost(self.model.space, x)
        return Normal(cost, data_cost, gradient, curvature, np.zeros((0, size)), np.zeros(0), None)

    def same_pairs(self, other: object) -> bool:
        """There are none."""
        return True

    def _apart(self, x: Float[np.ndarray, " parameter"]) -> Normal:
        size, count = len(self.model.space), len(self.observations)
        blocks, scores, squared = np.zeros((count, size, size)), np.zeros((count, size)), np.zeros(count)
        data_cost = 0.0
        for seen in self._predictions(x, slopes=True):
            r, w, scaled = self._weighed(seen)
            data_cost += float(np.sum(robust(scaled)))
            rows = seen.observations
            squared[rows] = scaled.sum(axis=1)
            relative, root = seen.slopes(1 / np.where(seen.value == 0, np.inf, seen.value)), np.sqrt(w)
            for row, entry, half, own in zip(rows.tolist(), seen.entry.tolist(), root, r, strict=True):
                each = (relative[:, entry] * half).reshape(size, -1)
                scores[row] = each @ np.concatenate([own.real * half, own.imag * half])
                blocks[row] = each @ each.T
        space = self.model.space
        gradient = space.precision * x + scores.sum(axis=0)
        cost = data_cost + prior_cost(space, x)
        return Normal(cost, data_cost, gradient, blocks.sum(axis=0), scores, squared, blocks)

    def _weighed(self, seen: Seen) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals, their weights, and their squares in units of variances."""
        weight, r = self._weight[seen.observations], self._residual(seen)
        scaled = weight * square(r)
        return r, weight * robust_weight(scaled), scaled

    def _residual(self, seen: Seen) -> np.ndarray:
        return residual(seen.value[seen.entry], self._measured[seen.observations])

    def _predictions(self, x: np.ndarray, *, slopes: bool) -> Iterable[Seen]:
        if not self._is_kept:
            return predictions(self.model, x, self.observations, self.weighing.lines, slopes=slopes)
        key = x.tobytes()
        if key not in self._kept:
            made = list(predictions(self.model, x, self.observations, self.weighing.lines, slopes=False))
            self._kept.clear()
            self._kept[key] = made
        return self._kept[key]

    @cached_property
    def _is_kept(self) -> bool:
        """Whether derivatives are found from what was predicted, once they are asked for."""
        return not isinstance(self.model, ReceptanceModel)

    @cached_property
    def _kept(self) -> dict[bytes, list[Seen]]:
        return {}

    @cached_property
    def _weight(self) -> Float[np.ndarray, "observation line"]:
        return self.weighing.weight(self.observations)

    @cached_property
    def _measured(self) -> Complex[np.ndarray, "observation line"]:
        return np.ascontiguousarray(self.observations.value[:, self.weighing.lines])


def cost_of(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, weighing: Weighting
) -> float:
    """Cost alone: the robust sum of squares plus the prior's; infinite where there is no model."""
    return FrfMisfit(model, observations, weighing).cost(x)


def normal_equations(
    model: Model,
    x: Float[np.ndarray, " parameter"],
    observations: Observations,
    weighing: Weighting,
    *,
    apart: bool = False,
) -> Normal:
    """Cost, gradient and curvature at x; `apart`: with what each observation adds to the curvature."""
    return FrfMisfit(model, observations, weighing).equations(x, apart=apart)


@dataclass(frozen=True, eq=False)
class FrfFit:
    """Where a fit ended."""

    x: Float[np.ndarray, " parameter"]
    cost: float
    misfit: FrfMisfit
    converged: bool
    steps: int
    apart: bool = True
    """Whether the normal equations are with what each observation adds to the curvature."""
    known: Normal | None = None
    """Normal equations, where the parameters are in another order than the model's."""

    @property
    def weighing(self) -> Weighting:
        """How residuals counted at the end."""
        return self.misfit.weighing

    @cached_property
    def normal(self) -> Normal:
        """Normal equations there."""
        return self.known or self.misfit.equations(self.x, apart=self.apart)


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
    near: float = 0.0,
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
        near: if above 0, the last round goes on until Newton's step is shorter, in standard errors.
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
        misfit = FrfMisfit(model, observations, Weighting(floor, lines, share))
        found = descend(
            model.space,
            misfit.equations,
            misfit.cost,
            x,
            most=steps,
            settled=settled if number == len(floors) - 1 else SETTLED,
            near=near if number == len(floors) - 1 else 0.0,
            hold=hold,
            advance=lambda step, cost, before=total: advance(before + step, cost),  # type: ignore[misc]
        )
        x, total = found.x, total + found.steps
    return FrfFit(x, found.cost, misfit, found.converged, total, apart)
