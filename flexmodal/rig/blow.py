"""The hammer: a smooth pulse whose length the tip sets, and a hand that never strikes twice alike.

The pulse is a haversine, f(t) = P/2 (1 − cos(2πt/T)) for 0 ≤ t ≤ T. Its spectrum first vanishes at 2/T and
falls as 1/f³ beyond. A harder blow is a little shorter: T ∝ P^(−1/6), as for Hertz's contact of a sphere,
where T ∝ v^(−1/5) and P ∝ v^(6/5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

TIPS = {"soft": 5.0e-3, "medium": 2.5e-3, "hard": 1.0e-3}
"""Length of a pulse of `REFERENCE_PEAK` by the hardness of the tip [s]."""
REFERENCE_PEAK = 100.0
"""[N]"""

PEAK_SCATTER = 0.10
"""Standard deviation of the logarithm of the peak."""
PLACE_SCATTER = 0.5e-3
"""Standard deviation of where the hammer lands, along each axis [m]."""
DIRECTION_SCATTER = np.radians(0.25)
"""Standard deviation of its tilt about each of two axes across the direction [rad]."""


@dataclass(frozen=True)
class Strike:
    """One blow as it truly fell."""

    peak: float
    """[N]"""
    duration: float
    """[s]"""
    start: float
    """When the tip touches, from the start of the record [s]."""
    offset: Float[np.ndarray, "3"]
    """From the marked point to where it landed, in the frame of the link [m]."""
    tilt: Float[np.ndarray, "3 3"]
    """Rotation of the nominal direction, world axes."""

    def force(self, time: Float[np.ndarray, " time"]) -> Float[np.ndarray, " time"]:
        """The force at given times [N]."""
        phase = (time - self.start) / self.duration
        inside = (phase > 0) & (phase < 1)
        return np.where(inside, self.peak / 2 * (1 - np.cos(2 * np.pi * phase)), 0.0)


def strike(
    peak: float, tip: str, trigger: float, interval: float, scatter: float, random: np.random.Generator
) -> Strike:
    """Draw one blow.

    Args:
        peak: typical peak of its kind [N].
        tip: a name of `TIPS`.
        trigger: when the pulse begins in the record, up to one interval later [s].
        interval: of the analyser's samples [s].
        scatter: multiple of the standard deviations of this page; 0 strikes the same blow each time.
        random: consumed alike whatever the arguments, so that campaigns compare blow by blow.
    """
    normal = random.standard_normal(6)
    late = random.uniform()
    actual = peak * float(np.exp(scatter * PEAK_SCATTER * normal[0]))
    angles = scatter * DIRECTION_SCATTER * normal[4:6]
    return Strike(
        peak=actual,
        duration=TIPS[tip] * float((actual / REFERENCE_PEAK) ** (-1 / 6)),
        start=trigger + interval * late,
        offset=scatter * PLACE_SCATTER * normal[1:4],
        tilt=_tilt(angles, random.uniform(0, np.pi)),
    )


def _tilt(angles: np.ndarray, heading: float) -> np.ndarray:
    """A small rotation about a random pair of world axes."""
    from flexmodal.rig.plant.geometry import turn

    size = float(np.hypot(*angles))
    if size == 0:
        return np.eye(3)
    axis = np.array([np.cos(heading), np.sin(heading) * angles[0] / size, np.sin(heading) * angles[1] / size])
    return turn(axis, size)
