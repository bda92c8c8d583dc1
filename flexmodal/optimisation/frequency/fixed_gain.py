"""The thesis's way to a frequency, for comparison: steps of a fixed gain down the slope [Hearne 3.3].

A step is as long as the slope is steep, and beside a resonance the slope is steepest: there a step can land
beyond the maximum that it was to lead away from ("maximum hopping"). Nothing in the rule notices. `tune` does
not step at all, and so cannot hop.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot
from flexmodal.optimisation.frequency.partial_fractions import direction_rows, logarithmic_slope
from flexmodal.optimisation.frequency.sampled import slope_per_hertz
from flexmodal.optimisation.frequency.tune import Tuning


@dataclass(frozen=True, eq=False)
class FrequencyDescent:
    """The frequencies that a fixed gain went through."""

    frequency: Float[np.ndarray, " step"]
    """[Hz], the start first; held at 0 and at the band's upper end."""

    def hops(self, tuning: Tuning) -> tuple[tuple[float, float], ...]:
        """Steps that passed over a maximum: from and to [Hz]."""
        peaks = np.array([peak.frequency for peak in tuning.maxima])
        steps = zip(self.frequency[:-1], self.frequency[1:], strict=True)
        return tuple(
            (float(a), float(b)) for a, b in steps if np.any((peaks > min(a, b)) & (peaks < max(a, b)))
        )


def fixed_gain_descent(
    posed: PosedRobot,
    start: float,
    *,
    gain: float,
    ceiling: float,
    direction: str | PointDirection | None = None,
    steps: int = 2000,
) -> FrequencyDescent:
    """Go down d ln|α|/df from a frequency by steps of a fixed gain.

    Args:
        posed: the robot in its posture.
        start: first frequency [Hz].
        gain: step per unit slope [Hz²].
        ceiling: frequencies above are held there [Hz].
        direction: drive point, such as "tool:+z".
        steps: how many.

    Raises:
        InvalidRequest: numbers out of range.
        InvalidSystem: the mass matrix is not positive definite.
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    if not (0 < start < ceiling and gain > 0 and steps > 0):
        allowed = "0 < start < ceiling, gain > 0, steps > 0"
        raise InvalidRequest(Fault("call", "start", f"{start:g} Hz, gain {gain:g}", allowed))
    (along,) = posed.directions(direction)
    slope = _slope(posed, along)
    path = [start]
    for _ in range(steps):
        rate = float(slope(np.array([path[-1]]))[0])
        path.append(float(np.clip(path[-1] - gain * rate, 0.0, ceiling)))
        if path[-1] == path[-2]:
            break
    return FrequencyDescent(np.array(path))


def _slope(posed: PosedRobot, along: PointDirection) -> Callable[[np.ndarray], np.ndarray]:
    """D ln|α| / df at some frequencies [1/Hz]."""
    loss = posed.system.hysteresis
    if loss is None or loss.frequency is None:
        return logarithmic_slope(posed, along, along).per_hertz
    rows = direction_rows(posed, along, along)
    return lambda frequency: slope_per_hertz(posed.system, rows, frequency)
