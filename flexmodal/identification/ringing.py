"""Whether what was measured still rings when its records end, by the measurement alone.

The lines of an FRF give the impulse response h(t), as far as the blow's spectrum reaches. Near a frequency f
its end is

    h_f(T) = Σ_k W((f_k − f) D) exp(2πi (f_k − f) t) H(f_k),   W(x) = sinc(x) / (1 − x²),

t in the middle of the last part of the record, of a duration D that is seen through a Hann window, whose
transform W is (Harris, Proceedings of the IEEE 66, 1978, 51). What is noise has E|h_f|² = Σ_k W² σ_k². A mode
of the structure rings in all FRFs of a posture, so that the mean of |h_f|² over that of the noise tells it.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.identification.observations import Observations

PART = (0.75, 0.93)
"""Of the record, that is looked at; at its very end the blow itself comes round again."""
FLOOR = 1e-3
"""Part of an FRF that counts as noise at least: records without noise are never quite still."""
RINGS = 10.0
"""Mean over a posture's FRFs of |h_f|² over that of the noise, from which something rings. In five campaigns
that were looked at: at most 2.3 where nothing does, 56 000 where a mode of 0.1 % damping does."""
EVEN = 1e-3
"""Difference of the lines' distances up to which they are even, over the distance."""
ASIDE = 4.0
"""How far from the ends of the band frequencies are, in 1/D: within it the ends themselves show."""


def rings_on(observations: Observations) -> bool:
    """Whether some posture's FRFs show a mode at the end of their records; no where lines cannot tell.

    Args:
        observations: of a campaign, with the length of their records.
    """
    frequency = observations.axis.frequency
    apart = np.diff(frequency)
    if len(frequency) < 3 or np.ptp(apart) > EVEN * apart[0]:
        return False
    weight = (2 * np.pi * frequency) ** observations.power  # as recorded, where noise is much alike
    value = observations.value * weight
    noise = (observations.variance + FLOOR**2) * np.abs(value) ** 2
    known = np.isfinite(noise)
    value, noise = np.where(known, value, 0.0), np.where(known, noise, 0.0)
    for level, length in enumerate(observations.lengths):
        if not 0 < length <= (1 + EVEN) / apart[0]:  # between lines farther apart its end cannot be seen
            continue
        over = _over_noise(frequency, length, value, noise)
        for posture in np.unique(observations.posture):
            here = (observations.posture == posture) & (observations.level == level)
            if over.shape[1] and here.any() and over[here].mean(axis=0).max() > RINGS:
                return True
    return False


def _over_noise(
    frequency: Float[np.ndarray, " line"], length: float, value: np.ndarray, noise: np.ndarray
) -> Float[np.ndarray, "observation frequency"]:
    """|h_f|² over that of the noise, at frequencies of which each is seen apart from the next."""
    first, last = PART
    duration, middle = (last - first) * length, (first + last) / 2 * length
    off = ASIDE / duration
    near = np.arange(frequency[0] + off, frequency[-1] - off, 1 / duration)
    distance = frequency[:, None] - near
    x = distance * duration
    single = np.abs(np.abs(x) - 1) < 1e-9
    window = np.where(single, 0.5, np.sinc(x) / np.where(single, 1.0, 1 - x**2))
    seen = np.abs(value @ (window * np.exp(2j * np.pi * distance * middle))) ** 2
    return np.asarray(seen / np.maximum(noise @ window**2, 1e-300))
