"""The noise of FRFs whose variance nobody stated, from how neighbouring lines disagree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.ema.measured import Measured


def with_variance(measured: Measured) -> Measured:
    """The same FRFs with a variance, estimated as one number for each FRF where none was given."""
    if measured.variance is not None:
        return measured
    level = scatter(measured)
    floor = (1e-12 * np.max(np.abs(measured.value), axis=0)) ** 2
    variance = np.broadcast_to(np.maximum(level, floor), measured.value.shape).copy()
    return replace(measured, variance=variance)


def scatter(measured: Measured) -> Float[np.ndarray, " frf"]:
    """E|noise|² of each FRF: the median of its squared third differences, which smooth curves hardly have.

    White complex noise of variance v has third differences of variance 20 v, whose squared magnitudes are
    exponentially distributed with the median ln 2 × 20 v. Resonances narrower than a few lines raise single
    differences and so leave the median alone.
    """
    third = np.diff(measured.value, n=3, axis=0)
    return np.median(np.abs(third) ** 2, axis=0) / (20 * np.log(2))
