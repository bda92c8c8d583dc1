"""The smallest unstable depth, when all one can ask is whether a depth is stable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.branches import branches
from flexmodal.machining.stability.zero_order import zero_order
from flexmodal.machining.tip_receptance import TipReceptance

_STEP = 1.15
"""Ratio of the depths tried on the way up: an unstable island narrower than this may be stepped over."""
_SHALLOWEST = 1e-6
_BELOW, _BEYOND = 0.2, 6.0
"""The search begins and ends at these multiples of the zero-order limit."""
_FAR = 1000.0
"""Where there is no such limit it ends at this multiple of the depth at which the gain first is one."""


@dataclass(frozen=True)
class Search:
    """Where to look for the limit at one spindle speed."""

    shallow: float
    """Where to begin [m]."""
    deep: float
    """Where to end [m]; not a search at all where it is 0."""
    near: float
    """Frequency at which chatter is expected [Hz]."""


def searches(tip: TipReceptance, cut: Cut, speed: Float[np.ndarray, " speed"]) -> list[Search]:
    """Where to look at each spindle speed, by the zero-order solution or, without a limit there, by the gain.

    Args:
        tip: how the tip gives way.
        cut: the cut.
        speed: spindle speeds [rev/min].

    Raises:
        SingularResponse: a mode that the tip sees has no damping.
    """
    guess, found = zero_order(tip, cut, speed), branches(tip, cut)
    if not len(found.low):
        return [Search(0.0, 0.0, 0.0)] * len(speed)
    strongest = int(np.argmax(np.abs(found.at_low)))
    unit, frequency = 0.5 / float(np.abs(found.at_low[strongest])), float(found.low[strongest])
    return [
        Search(_BELOW * depth, _BEYOND * depth, chatter)
        if np.isfinite(depth)
        else Search(_BELOW * unit, _FAR * unit, frequency)
        for depth, chatter in zip(guess.depth.tolist(), guess.chatter_frequency.tolist(), strict=True)
    ]


def first_loss(unstable: Callable[[float], bool], search: Search, *, tolerance: float = 1e-3) -> float:
    """Bracket the first unstable depth from below, then halve the bracket.

    Args:
        unstable: whether a depth [m] is unstable.
        search: where to look.
        tolerance: relative width of the last bracket.

    Returns:
        The depth [m]; infinite where everything down to the end of the search is stable.
    """
    if not search.deep:
        return float("inf")
    low = search.shallow
    while unstable(low):
        low /= 4
        if low < _SHALLOWEST * search.shallow:
            return 0.0
    high = low * _STEP
    while not unstable(high):
        low, high = high, high * _STEP
        if low > search.deep:
            return float("inf")
    while high - low > tolerance * high:
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return (low + high) / 2
