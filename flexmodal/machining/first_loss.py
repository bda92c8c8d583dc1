"""The smallest unstable depth, when all one can ask is whether a depth is stable."""

from __future__ import annotations

from collections.abc import Callable

_STEP = 1.15
"""Ratio of the depths tried on the way up: an unstable island narrower than this may be stepped over."""
_DEEPEST = 6.0
"""Depths are tried up to this many times the guess."""
_SHALLOWEST = 1e-6


def first_loss(unstable: Callable[[float], bool], guess: float, *, tolerance: float = 1e-3) -> float:
    """Bracket the first unstable depth from below, then halve the bracket.

    Args:
        unstable: whether a depth [m] is unstable.
        guess: where the limit is expected, as the zero-order solution has it [m].
        tolerance: relative width of the last bracket.

    Returns:
        The depth [m]; infinite where everything up to six times the guess is stable.
    """
    low = 0.2 * guess
    while unstable(low):
        low /= 4
        if low < _SHALLOWEST * guess:
            return 0.0
    high = low * _STEP
    while not unstable(high):
        low, high = high, high * _STEP
        if low > _DEEPEST * guess:
            return float("inf")
    while high - low > tolerance * high:
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return (low + high) / 2
