"""Force and exponential windows, and the damping that the exponential one adds taken out again.

Where r = h * f, r(t)·exp(−at) is the response to f(t)·exp(−at) of the same system, its poles moved by −a.
So the window goes on force and response alike, and the move is exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.trial import Trial, Window

FADED = 0.01
"""Part of the peak below which the pulse of a force counts as over."""


def windowed(blow: Blow, window: Window | str) -> tuple[np.ndarray, np.ndarray]:
    """Force and responses [channel sample] of a blow under the window of its trial.

    Args:
        blow: as it was recorded.
        window: what to multiply it by.
    """
    if not isinstance(window, Window):
        return blow.force, blow.response
    if window.kind == "force":
        return blow.force * force_window(blow, window.decay), blow.response
    fade = np.exp(-window.decay * (blow.time - blow.time[0]))
    return blow.force * fade, blow.response * fade


def force_window(blow: Blow, decay: float) -> Float[np.ndarray, " sample"]:
    """One until the pulse is over, exp(−decay·t) from there on.

    Args:
        blow: as it was recorded.
        decay: of the force after its pulse [1/s].
    """
    size = np.abs(blow.force)
    peak = int(np.argmax(size))
    after = np.flatnonzero(size[peak:] < FADED * size[peak])
    end = peak + int(after[0]) if after.size else len(size) - 1
    return np.exp(-decay * np.maximum(blow.time - blow.time[end], 0.0))


def added_decay(trial: Trial) -> float:
    """How far the window of a trial moved every pole of its FRFs to the left [1/s]."""
    window = trial.window
    return window.decay if isinstance(window, Window) and window.kind == "exponential" else 0.0


def without_window(
    natural_frequency: Float[np.ndarray, "*mode"] | float,
    damping_ratio: Float[np.ndarray, "*mode"] | float,
    decay: float,
) -> tuple[Any, Any]:
    """Modal parameters as they are without the exponential window.

    The window moves λ = −ζω + iω√(1 − ζ²) by −a; the move is taken back. Natural frequency and damping ratio
    both change, the damped frequency does not.

    Args:
        natural_frequency: as fitted [Hz].
        damping_ratio: as fitted, below 1.
        decay: of the window [1/s].

    Returns:
        Natural frequency [Hz] and damping ratio, shaped as they came; the ratio is negative where the window
        added more than was found.
    """
    omega = 2 * np.pi * np.asarray(natural_frequency, dtype=float)
    ratio = np.asarray(damping_ratio, dtype=float)
    real = ratio * omega - decay
    imaginary = omega * np.sqrt(1 - ratio**2)
    size = np.hypot(real, imaginary)
    return size / (2 * np.pi), real / size
