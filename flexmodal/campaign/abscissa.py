"""Abscissas carry six digits in a UFF file: when do two agree, and when is one even?"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

DIGITS = 1e-5
"""Relative deviation that six digits excuse, of two numbers rounded one by one or by their common step."""
PART = 0.4
"""But never as much of a step as would let two lines be confused."""


def same_axis(one: Float[np.ndarray, " m"], other: Float[np.ndarray, " n"]) -> bool:
    """Whether two ascending abscissas agree line for line within the six digits that a UFF file carries.

    Args:
        one: ascending values.
        other: the values to compare with them.
    """
    if len(one) != len(other):
        return False
    step = (one[-1] - one[0]) / (len(one) - 1)
    allowed = np.minimum(DIGITS * np.maximum(np.abs(one), step), PART * step)
    return bool(np.all(np.abs(one - other) <= allowed))


def evened(axis: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"] | None:
    """The evenly spaced axis that `axis` is within six digits, or None where its spacing is uneven."""
    even = np.linspace(axis[0], axis[-1], len(axis))
    return even if same_axis(even, axis) else None
