"""How measured modes scatter about a model's: the likelihood, with its scales inferred along.

A measured mode k that is the model's mode m has

    ln f_k ~ N(ln f_m, e_k² + s_f²),    ln ζ_k ~ N(ln ζ_m, e_ζk² + s_ζ²),
    p(a_k | u_m) = exp(κ MAC(a_k, u_m)) / ₁F₁(1; n; κ)    [complex Watson, density over the uniform one],

with e the standard errors that the spread over places gives, s what the model itself misses by, and κ how
well the shapes of one mode are measured, for each mode by itself. A measured mode that is none of the
model's comes from anywhere in the band, with any damping and any shape; a mode of the model in the band
that nobody measured was overlooked (peaks in clutter: Reid, IEEE Trans. Automatic Control 24, 1979; the
Watson density: Mardia and Dryden, Biometrika 86, 1999).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flexmodal.identification.evidence.likelihood.forecast import DAMPING_SPREAD, USUAL_DAMPING

FREQUENCY, DAMPING, SHAPE, RESIDUE = "frequency", "damping", "shape", "residue"
LEAST, MOST = -12.0, 12.0
"""Bounds of the logarithm of a scale."""


@dataclass(frozen=True)
class Beliefs:
    """What is believed of scatter and of peaks before anything is fitted."""

    seen: float = 0.9
    """Probability that a mode of the robot in the band is found in a posture."""
    spurious: float = 0.5
    """Peaks in a posture, on average, that are no modes of the robot."""
    damped: float = 0.3
    """Damping ratio from which a mode of the model makes no peak that anybody has to have found."""
    scales: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: {
            FREQUENCY: (float(np.log(0.01)), 0.8),
            DAMPING: (float(np.log(0.3)), 0.8),
            SHAPE: (float(np.log(10.0)), 1.5),
        }
    )  # fmt: skip
    """Mean and standard deviation of ln s_f, ln s_ζ and ln κ."""
    shapes: bool = True
    """Whether shapes count."""


def log_normal(away: float, variance: float) -> float:
    """Logarithm of a normal density.

    Args:
        away: distance from the mean.
        variance: of the density.
    """
    return -0.5 * (away**2 / variance + float(np.log(2 * np.pi * variance)))


def log_watson_constant(n: int, kappa: float) -> float:
    """Ln ₁F₁(1; n; κ) = κ + ln Γ(n) − (n − 1) ln κ + ln P(n − 1, κ), P the regularised incomplete gamma.

    Args:
        n: complex dimensions of a shape.
        kappa: concentration κ.
    """
    from scipy.special import gammainc, gammaln

    if n < 2:
        return kappa  # one place has one shape: no density at all
    part = float(gammainc(n - 1, kappa))
    if part < 1e-280:
        return 0.0
    return kappa + float(gammaln(n)) - (n - 1) * float(np.log(kappa)) + float(np.log(part))


def log_anywhere(band: tuple[float, float], beliefs: Beliefs, log_damping: float) -> float:
    """Logarithm of the density of a peak that is none of the model's modes.

    Args:
        band: in which a peak may lie [Hz].
        beliefs: priors of the scatter.
        log_damping: ln ζ of the peak.
    """
    density = float(np.log(beliefs.spurious / np.log(band[1] / band[0])))
    if np.isfinite(log_damping):
        density += log_normal(log_damping - float(np.log(USUAL_DAMPING)), DAMPING_SPREAD**2)
    return density
