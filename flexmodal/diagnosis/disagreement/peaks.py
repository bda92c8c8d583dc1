"""Peaks of a curve by their prominence; loading `scipy.signal` for it would take longer than all its use."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int


def peaks(curve: Float[np.ndarray, " line"], prominence: float) -> Int[np.ndarray, " peak"]:
    """Places of the local maxima that stand out; in the middle of flat ones.

    Args:
        curve: values.
        prominence: height, at least, over the higher of the two lowest places that part a peak from whatever
            is higher on either side, or from the ends.
    """
    turns = np.flatnonzero(np.diff(curve)) + 1  # first line of each run of equal values
    first = np.concatenate([[0], turns])
    last = np.concatenate([turns, [len(curve)]]) - 1
    level = curve[first]
    tops = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    some = np.array([k for k in tops.tolist() if _prominence(level, k) >= prominence], dtype=int)
    return np.asarray((first[some] + last[some]) // 2)


def _prominence(level: Float[np.ndarray, " run"], k: int) -> float:
    higher = np.flatnonzero(level > level[k])
    place = int(np.searchsorted(higher, k))
    start = int(higher[place - 1]) + 1 if place else 0
    end = int(higher[place]) if place < len(higher) else len(level)
    return float(level[k] - max(level[start : k + 1].min(), level[k:end].min()))
