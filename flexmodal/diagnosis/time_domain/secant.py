"""Fits of models whose derivatives are dear: found anew once in a while, and corrected by each step between.

An integration in time gives no derivatives; forward differences take one more for each parameter. After a
step the change that was seen corrects those there were, along the step alone (Broyden, Math. Comp. 19, 1965;
within Levenberg and Marquardt's method: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares
Problems, Technical University of Denmark 2004, section 3.5). What changes is the logarithm of a receptance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.identification import FrfFit, Observations, ReceptanceModel, fit
from flexmodal.identification.frf_fit import FrfMisfit, residual
from flexmodal.structure import ParameterSpace

CORRECTED = 5
"""Steps after which derivatives are found anew."""


class Secants:
    """A model during one fit to the same lines of the same observations: remembers what it gave last."""

    def __init__(self, model: ReceptanceModel) -> None:
        """Nothing is known yet.

        Args:
            model: whose derivatives are dear.
        """
        self._model = model
        self._tried: _Seen | None = None
        self._known: _Seen | None = None
        self._relative = np.zeros((0, 0, 0), dtype=complex)
        self._corrections = CORRECTED

    @property
    def space(self) -> ParameterSpace:
        """Of the model."""
        return self._model.space

    def receptances(
        self,
        x: Float[np.ndarray, " parameter"],
        observations: Observations,
        lines: slice | Int[np.ndarray, " line"],
        *,
        slopes: bool,
    ) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "slope observation line"]]:
        """What the model gives; derivatives are corrected ones up to `CORRECTED` times.

        Args:
            x: see `identification.ReceptanceModel`.
            observations: see there; the same in every call.
            lines: see there, likewise.
            slopes: see there.
        """
        if not slopes:
            value, none = self._model.receptances(x, observations, lines, slopes=False)
            self._tried = _Seen(x.copy(), value)
            return value, none
        here = self._tried
        if here is None or self._known is None or self._corrections >= CORRECTED or np.any(here.x != x):
            value, found = self._model.receptances(x, observations, lines, slopes=True)
            self._relative, self._corrections = found / np.where(value == 0, np.inf, value), 0
            self._known = _Seen(x.copy(), value)
            return value, found
        step = here.x - self._known.x
        size = float(step @ step)
        if size > 0:
            missed = residual(here.value, self._known.value) - np.tensordot(step, self._relative, 1)
            self._relative = self._relative + np.multiply.outer(step / size, missed)
            self._known, self._corrections = here, self._corrections + 1
        return here.value, self._relative * here.value


@dataclass(frozen=True, eq=False)
class _Seen:
    """What a model gave at a point."""

    x: Float[np.ndarray, " parameter"]
    value: Complex[np.ndarray, "observation line"]


def fitted_by_secants(
    misfit: FrfMisfit,
    start: Float[np.ndarray, " parameter"],
    *,
    steps: int,
    settled: float,
) -> FrfFit:
    """Fit a model whose derivatives are dear; where corrected ones lead no further, they are found anew.

    Args:
        misfit: of the model.
        start: coordinates.
        steps: most.
        settled: derivatives found anew that bring the cost down relatively by less are the last.
    """
    assert isinstance(misfit.model, ReceptanceModel)
    x, taken, before, weighing = start, 0, np.inf, misfit.weighing
    while True:
        made = fit(
            Secants(misfit.model), misfit.observations, x, floors=(weighing.floor,), lines=weighing.lines,
            share=weighing.share, steps=steps - taken, settled=settled, apart=False,
        )  # fmt: skip
        x, taken = made.x, taken + made.steps
        done = before - made.cost <= settled * before
        if done or taken >= steps:
            return FrfFit(x, made.cost, misfit, done, taken)
        before = made.cost
