"""The noise of FRFs whose variance nobody stated, from how neighbouring lines disagree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.measured import Measured

_AROUND = 20
"""Lines to either side over which the noise is taken to be alike."""

_QUIETEST = 1e-8
"""Noise over signal, in power, below which all FRFs count as equally clean."""


def with_variance(measured: Measured) -> Measured:
    """The same FRFs with a variance, estimated line by line where none was given."""
    if measured.variance is not None:
        return measured
    floor = (1e-12 * np.max(np.abs(measured.value), axis=0)) ** 2
    return replace(measured, variance=np.maximum(scatter(measured.value), floor))


def noise_levels(measured: Measured) -> Float[np.ndarray, " frf"]:
    """Root mean square noise of each FRF, none taken for less than 80 dB below its signal."""
    power = np.mean(np.abs(measured.value) ** 2, axis=0)
    noise = np.mean(np.asarray(with_variance(measured).variance), axis=0)
    return np.sqrt(np.maximum(noise, _QUIETEST * power))


def scatter(value: Complex[np.ndarray, "line frf"]) -> Float[np.ndarray, "line frf"]:
    """E|noise|² about each line: the median of squared third differences, which smooth curves hardly have.

    White complex noise of variance v has third differences of variance 20 v, whose squared magnitudes are
    exponentially distributed with the median ln 2 × 20 v. Resonances narrower than a few lines raise single
    differences and so leave the median alone.
    """
    third = np.abs(np.diff(value, n=3, axis=0)) ** 2
    window = min(2 * _AROUND + 1, len(third))
    local = np.median(np.lib.stride_tricks.sliding_window_view(third, window, axis=0), axis=-1)
    missing = len(value) - len(local)
    before = missing // 2
    return np.pad(local, ((before, missing - before), (0, 0)), mode="edge") / (20 * np.log(2))
