"""From which coherence on a line is used."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

COHERENT = 0.8
"""Coherence from which on a line is used (file format, section 3)."""


def is_coherent(coherence: Float[np.ndarray, "*many"]) -> Bool[np.ndarray, "*many"]:
    """Which lines may be used, by their coherence.

    Args:
        coherence: from 0 to 1.
    """
    return np.asarray(coherence >= COHERENT)
