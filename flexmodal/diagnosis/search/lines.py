"""Which lines a look at the observations sees."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Int

from flexmodal.identification import Observations
from flexmodal.identification.descent import robust
from flexmodal.identification.frf_fit import Weighting, residual

COARSE = 48
"""Lines of the coarse looks, closer together where resonances are narrow."""
WORST = 16
"""Further lines of the coarse looks, where what is to be explained is."""
CLOSE = 160
"""Lines of the closer ones."""
WORST_ERROR = 0.03
"""Model error at which these are looked for."""


def some_lines(observations: Observations, count: int) -> Int[np.ndarray, " line"]:
    """Numbers of about so many lines, half of them evenly spaced, half on a logarithmic scale.

    Args:
        observations: whose axis.
        count: how many lines; all of them where there are no more than that.
    """
    every = len(observations.axis)
    if count >= every:
        return np.arange(every)
    even = np.linspace(0, every - 1, count // 2)
    frequency = observations.axis.frequency
    spread = np.interp(
        np.linspace(np.log(frequency[0]), np.log(frequency[-1]), count - count // 2),
        np.log(frequency),
        np.arange(every),
    )
    return np.unique(np.concatenate([even, spread]).round().astype(int))


def worst_lines(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> Int[np.ndarray, " worst"]:
    """Lines where a model is far from the measurement, the closer together the further it is.

    Args:
        observations: what was measured, with its noise.
        predicted: the same by the model.
    """
    weight = Weighting(WORST_ERROR, np.arange(len(observations.axis))).weight(observations)
    far = robust(weight * np.abs(residual(predicted, observations.value)) ** 2).sum(axis=0)
    above = np.cumsum(np.maximum(far - np.median(far), 0.0))
    if above[-1] < 1e-6:  # in units of noise: rounding
        return np.zeros(0, dtype=int)
    return np.unique(np.searchsorted(above, (np.arange(WORST) + 0.5) / WORST * above[-1]))
