"""Spectra of signals that are straight lines between samples, from 0 on, cut off after the last.

    X(s) = h Σ_j x_j e^{−s j h} (sinh(z/2)/(z/2))² + half a hat for the last,    z = s h,

exact for such signals (the transform of a hat of width 2h), so that force and torques enter the
response without any further approximation.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.structure.structure import Axis

WHOLE = 1e-3
"""How far from a multiple of 1/T a line may be, in such multiples, to be read off a fast transform."""
_SHORT = 256
_TOGETHER = 1 << 20


def spectrum(
    samples: Float[np.ndarray, "*many time"], axis: Axis, step: float, whole: int | None = None
) -> Complex[np.ndarray, "*many line"]:
    """Spectrum on some lines.

    Args:
        samples: the first, which is 0, at time 0.
        axis: lines, and the window that the signal is under.
        step: between samples [s].
        whole: steps whose length the lines are multiples of the inverse of; those of the signal by default.
    """
    z = axis.s * step
    hat = step * (np.sinh(z / 2) / (z / 2)) ** 2
    count = samples.shape[-1] - 1
    long = whole or count
    periods = axis.frequency * long * step
    number = np.round(periods).astype(int)
    if count > _SHORT and np.all(np.abs(periods - number) < WHOLE) and number[-1] <= long // 2:
        faded = (
            samples[..., :-1] * np.exp(-axis.decay * step * np.arange(count))
            if axis.decay
            else samples[..., :-1]
        )
        inner = np.fft.rfft(faded, long, axis=-1)[..., number]
    else:
        inner = _direct(samples[..., :-1], z)
    half = step * (np.exp(z) - 1 - z) / z**2 * np.exp(-count * z)
    return inner * hat + samples[..., -1:] * half


def _direct(
    samples: Float[np.ndarray, "*many time"], z: Complex[np.ndarray, " line"]
) -> Complex[np.ndarray, "*many line"]:
    """Σ x_j e^{−z j}, some times at once."""
    total = np.zeros((*samples.shape[:-1], len(z)), dtype=complex)
    width = max(1, _TOGETHER // len(z))
    for start in range(0, samples.shape[-1], width):
        part = samples[..., start : start + width]
        total += part @ np.exp(-np.outer(np.arange(start, start + part.shape[-1]), z))
    return total
