"""How much each line counts in a least squares fit."""

from __future__ import annotations

from typing import Literal

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.methods.noise import scatter

Weighting = Literal["variance", "uniform", "logarithmic"]
"""By 1/variance; every line alike; or by relative deviation, which is ln(model/measured) to first order."""


def weights_of(
    weighting: Weighting,
    value: Complex[np.ndarray, "group line frf"],
    variance: Float[np.ndarray, "group line frf"] | None,
) -> Float[np.ndarray, "group line frf_or_1"]:
    """Weights of every line, in one column for all FRFs where they weigh alike.

    Args:
        weighting: by variance, uniform or logarithmic.
        value: of the lines.
        variance: E|noise|² of them, where it is known.
    """
    if weighting == "variance" and variance is not None:
        if np.all(variance == variance[..., :1]):
            return 1 / variance[..., :1]
        return 1 / variance
    if weighting == "logarithmic":
        # Lines near the noise would weigh by their noise; ten times its power bounds the weight.
        floor = np.stack([scatter(part) for part in value]) if variance is None else variance
        return 1 / np.maximum(np.abs(value) ** 2, np.maximum(10 * floor, 1e-8))
    return np.ones((*value.shape[:2], 1))


def by_deviation(deviation: Complex[np.ndarray, "group line frf"]) -> Float[np.ndarray, "group line frf"]:
    """1/s² of each FRF, none counted as more than 10⁵ times better than the worst."""
    power = np.mean(np.abs(deviation) ** 2, axis=1, keepdims=True)
    worst = np.max(power, axis=2, keepdims=True)
    weight = 1 / np.maximum(power, np.where(worst > 0, 1e-10 * worst, 1.0))
    return np.broadcast_to(weight, deviation.shape).copy()
