"""Stability lobes: the depth of cut that stays stable, over spindle speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from flexmodal.machining.cut import Cut

LINEAR_RATIO = 12
"""Speed ranges wider than this are looked at in equal ratios, narrower ones in equal steps."""


@dataclass(frozen=True, eq=False)
class Lobes:
    """The stability limit of a cut over spindle speed, by one method."""

    cut: Cut
    method: str
    """"zero-order", "multi-frequency" or "semi-discretisation"."""
    speed: Float[np.ndarray, " speed"]
    """Ascending [rev/min]."""
    depth: Float[np.ndarray, " speed"]
    """Largest axial depth of cut below which the cut is stable [m]; infinite where no limit was found."""
    chatter_frequency: Float[np.ndarray, " speed"]
    """Of the vibration that sets in there [Hz]; not a number where there is no limit."""
    lobe: Int[np.ndarray, " speed"]
    """Whole waves between two teeth: 0 for the rightmost lobe; −1 where there is no limit."""
    flip: np.ndarray
    """Whether it sets in at half the tooth-passing frequency (period doubling)."""

    @property
    def critical_depth(self) -> float:
        """Depth that is stable at every speed of the range [m]."""
        return float(np.min(self.depth))

    @property
    def critical_speed(self) -> float:
        """Speed where the least depth is stable [rev/min]."""
        return float(self.speed[np.argmin(self.depth)])

    def at(self, spindle_speed: float) -> float:
        """Stable depth at the nearest of the speeds looked at [m]."""
        return float(self.depth[np.argmin(np.abs(self.speed - spindle_speed))])

    def best(self, most: int = 5) -> tuple[tuple[float, float], ...]:
        """Speeds between lobes where the stable depth peaks, the deepest first: speed [rev/min], depth [m].

        The ends of the range count as peaks where the depth falls from them.
        """
        depth = np.concatenate([[-np.inf], self.depth, [-np.inf]])
        peak = np.flatnonzero((depth[1:-1] > depth[:-2]) & (depth[1:-1] >= depth[2:]))
        order = sorted(peak.tolist(), key=lambda place: -self.depth[place])
        return tuple((float(self.speed[place]), float(self.depth[place])) for place in order[:most])


def speed_axis(cut: Cut, count: int) -> Float[np.ndarray, " speed"]:
    """Speeds over the cut's range [rev/min].

    Args:
        cut: whose range of speeds.
        count: how many.
    """
    low, high = cut.engagement.spindle_speed
    return np.geomspace(low, high, count) if high / low > LINEAR_RATIO else np.linspace(low, high, count)


def unfolded(base: float, period: float, near: float) -> tuple[float, int, bool]:
    """What a Floquet multiplier's angle stands for.

    Args:
        base: the angle as a frequency in 0 … 1/2T [Hz]; whole tooth-passing frequencies and sign are lost.
        period: T [s].
        near: the frequency expected [Hz].

    Returns:
        The frequency nearest to that [Hz], its lobe, and whether it doubles the period.
    """
    aliases = [abs(sign * base + round((near - sign * base) * period) / period) for sign in (1, -1)]
    frequency = min(aliases, key=lambda value: abs(value - near))
    return frequency, int(np.floor(frequency * period + 1e-9)), bool(abs(2 * base * period - 1) < 1e-6)


def joined(parts: Sequence[Lobes]) -> Lobes:
    """Lobes of one cut and method over several sets of speeds as one, each speed once."""
    speed, order = np.unique(np.concatenate([one.speed for one in parts]), return_index=True)
    arrays = (
        np.concatenate([getattr(one, name) for one in parts])[order]
        for name in ("depth", "chatter_frequency", "lobe", "flip")
    )
    return Lobes(parts[0].cut, parts[0].method, speed, *arrays)
