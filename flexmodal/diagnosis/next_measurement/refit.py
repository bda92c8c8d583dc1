"""What is left of the difference of two explanations once one has moved its parameters to meet the other.

The information of `information` is linear in the parameters. Near a resonance that is sharp a small change
of a parameter moves the whole peak, and a difference that looks like much is none: the next fit makes up
for it. So for the measurements that look best the other explanation is fitted to what the one predicts,
held by what is known of its parameters,

    I = min over x of ½ Σ ρ(|ln α₂(x) − ln α₁|²/σ²) + ½ (x − x₂)ᵀ C₂⁻¹ (x − x₂)  [nat],

ρ Huber's function, as in every fit. Where all is linear and C₁ = 0 that is the other formula.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.identification.descent import HUBER, robust
from flexmodal.identification.frf_fit import residual

STEPS = 8
"""Of Levenberg and Marquardt's method."""

At = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""From coordinates to ln-slopes: a receptance [line] and its derivatives of ln α [parameter line]."""


def not_made_up_for(
    wanted: Complex[np.ndarray, " line"],
    other: At,
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
    noise: float,
) -> float:
    """Information that is left [nat].

    Args:
        wanted: what the one explanation predicts.
        other: the other explanation in the same measurement.
        x: its coordinates.
        covariance: of these.
        noise: relative, of a line.
    """
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    root = vectors * np.sqrt(np.maximum(values, 0.0))  # x = x₂ + root z, z standard normal
    scale = noise / np.sqrt(2.0)  # of the real and the imaginary part

    def cost(z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        found, slopes = other(x + root @ z)
        away = residual(found, wanted)
        squared = np.abs(away) ** 2 / scale**2
        weight = np.sqrt(np.minimum(1.0, HUBER / np.sqrt(np.maximum(squared, 1e-300)))) / scale
        pull, design = away * weight, (root.T @ slopes) * weight
        return float(np.sum(robust(squared)) + z @ z), pull, design

    z, damping = np.zeros(len(x)), 1.0
    now, pull, design = cost(z)
    for _ in range(STEPS):
        flat = np.concatenate([design.real, design.imag], axis=1)
        gradient = flat @ np.concatenate([pull.real, pull.imag]) + z
        step = -np.linalg.solve(flat @ flat.T + (1.0 + damping) * np.eye(len(z)), gradient)
        try:
            tried = cost(z + step)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            tried = (np.inf, pull, design)
        if tried[0] < now:
            z, damping = z + step, damping / 5
            settled = now - tried[0] < 1e-2 * now
            now, pull, design = tried
            if settled:
                break
        else:
            damping = 10 * damping + 1.0
    return now / 2
