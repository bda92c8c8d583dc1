"""Scales of the scatter at their best, one by one: what a model misses by, how well shapes are measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.identification.evidence.likelihood.residuals import Residuals
from flexmodal.identification.evidence.likelihood.scatter import (
    LEAST,
    MOST,
    SHAPE,
    Beliefs,
    log_normal,
    log_watson_constant,
)


def rescaled(found: Residuals, scales: Mapping[str, float], beliefs: Beliefs) -> dict[str, float]:
    """Scales with the highest posterior, given the residuals.

    Args:
        found: residuals of the pairs.
        scales: logarithms of the scales, of which only the names count.
        beliefs: priors of the scales.
    """
    from scipy.optimize import minimize_scalar

    return {
        name: float(
            minimize_scalar(
                lambda value, name=name: -scale_term(found, beliefs, name, value),
                bounds=(LEAST, MOST), method="bounded", options={"xatol": 1e-5},
            ).x
        )
        for name in scales
    }  # fmt: skip


def scale_term(found: Residuals, beliefs: Beliefs, name: str, value: float) -> float:
    """What one scale adds to the log-posterior where its logarithm is `value`.

    Args:
        found: residuals of the pairs.
        beliefs: priors of the scales.
        name: of the scale.
        value: its logarithm.
    """
    mean, deviation = beliefs.scales[name.partition(".")[0]]
    total = log_normal(value - mean, deviation**2)
    if name.startswith(SHAPE):
        kappa = float(np.exp(value))
        return total + sum(
            kappa * alike - log_watson_constant(n, kappa)
            for which, n, alike in found.dimension
            if which == name
        )
    own = [k for k, kind in enumerate(found.kind) if kind == name]
    variance = found.variance[own] + np.exp(2 * value)
    return total - 0.5 * float(np.sum(found.away[own] ** 2 / variance + np.log(2 * np.pi * variance)))
