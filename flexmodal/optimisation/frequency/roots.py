"""Every place in an interval where a sum of fractions vanishes, with a proof that no other is there.

Intervals are halved until bounds decide each: either the sum cannot be 0 in it, or it only rises or only
falls, so that the signs at its ends say whether there is one root or none (branch and bound; the bounds are
exact for each fraction, so that they close in as the interval shrinks).
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.optimisation.frequency.partial_fractions import LogarithmicSlope

_NARROW = 1e-14
"""Relative width below which an interval is not halved again: two roots that rounding cannot part."""


def roots(
    function: LogarithmicSlope, edges: Float[np.ndarray, " edge"]
) -> tuple[Float[np.ndarray, " root"], Bool[np.ndarray, " root"]]:
    """All sign changes between the first and the last edge, edges left out.

    Args:
        function: finite between its poles.
        edges: ascending; every pole of the function within the range has to be among them.

    Returns:
        The roots, ascending, and whether the function rises there.
    """
    low, high = edges[:-1], edges[1:]
    brackets: list[tuple[np.ndarray, np.ndarray]] = []
    while len(low):
        least, greatest = function.bounds(low, high)
        open_ = ~((least > 0) | (greatest < 0))
        low, high = low[open_], high[open_]
        falls, rises = function.slope_bounds(low, high)
        settled = (falls > 0) | (rises < 0) | (high - low <= _NARROW * np.abs(high))
        brackets.append((low[settled], high[settled]))
        low, high = low[~settled], high[~settled]
        middle = (low + high) / 2
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    low, high = (np.concatenate(side) for side in zip(*brackets, strict=True))
    first = _sign(function, low, np.nextafter(low, high))
    last = _sign(function, high, np.nextafter(high, low))
    crossed = first * last < 0
    found = _bisect(function, low[crossed], high[crossed], first[crossed])
    order = np.argsort(found)
    return found[order], (first[crossed] < 0)[order]


def _sign(function: LogarithmicSlope, place: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Sign at an end of an interval; just inside of it where the end is a pole."""
    value = function.at(place)
    return np.sign(np.where(np.isfinite(value), value, function.at(inside)))


def _bisect(function: LogarithmicSlope, low: np.ndarray, high: np.ndarray, first: np.ndarray) -> np.ndarray:
    for _ in range(200):
        middle = (low + high) / 2
        if np.all((middle == low) | (middle == high)):
            break
        same = np.sign(function.at(middle)) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
