"""Forced vibration of a stable cut, and the error it leaves on the wall.

The teeth push at the tooth-passing frequency and its harmonics. A vibration of that period is the same one
tooth later, so the regenerative term is zero and the answer is simply `r_k = Φ(k/T) F_k`, whatever the depth,
as long as the cut is stable (Schmitz and Smith, Machining Dynamics, chapter 5; Altintas, Manufacturing
Automation). F_k are closed forms. The wall is left where a tooth passes the normal of the feed: its error is
the deflection along y at that moment, higher up a helix at a later one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.directional import helix_lag, static_force_harmonics
from flexmodal.machining.tip_receptance import TipReceptance

_HARMONICS = 60
"""The displacement falls with the cube of the harmonic beyond the last resonance."""
_HEIGHTS = 21
_SAMPLES = 360


@dataclass(frozen=True, eq=False)
class ForcedVibration:
    """Periodic vibration of the tip at one spindle speed and depth."""

    cut: Cut
    speed: float
    """[rev/min]."""
    depth: float
    """[m]."""
    frequency: Float[np.ndarray, " harmonic"]
    """0, the tooth-passing frequency and its multiples [Hz]."""
    force: Complex[np.ndarray, "harmonic 3"]
    """Fourier coefficients of the force on the tip along x, y, z: half the amplitude but for 0 Hz [N]."""
    displacement: Complex[np.ndarray, "harmonic 3"]
    """The same of the displacement [m]."""

    @property
    def static(self) -> Float[np.ndarray, "3"]:
        """Mean deflection along x, y, z [m]."""
        return self.displacement[0].real

    def at(self, angle: Float[np.ndarray, " angle"]) -> Float[np.ndarray, "angle 3"]:
        """Displacement when the first tooth's tip stands at an angle [rad]: [m]."""
        return (_waves(angle, self.cut.cutter.teeth, len(self.frequency)) @ self.displacement).real

    @property
    def peak(self) -> Float[np.ndarray, "3"]:
        """Largest departure from the mean deflection along x, y, z over a tooth period [m]."""
        waves = _period(self.cut.cutter.teeth, len(self.frequency))
        return np.max(np.abs((waves[:, 1:] @ self.displacement[1:]).real), axis=0)

    @property
    def height(self) -> Float[np.ndarray, " height"]:
        """Heights above the tip at which the wall is looked at [m]; only 0 without a helix."""
        straight = helix_lag(self.cut, self.depth) == 0
        return np.zeros(1) if straight else np.linspace(0, self.depth, _HEIGHTS)

    @property
    def entry_wall(self) -> Float[np.ndarray, " height"] | None:
        """Error of the wall at +y by height, positive where too much is cut; none without that wall [m]."""
        return self._wall(0.0, 1.0) if self.cut.engagement.leaves_entry_wall else None

    @property
    def exit_wall(self) -> Float[np.ndarray, " height"] | None:
        """Error of the wall at −y by height, positive where too much is cut; none without that wall [m]."""
        return self._wall(np.pi, -1.0) if self.cut.engagement.leaves_exit_wall else None

    @property
    def surface_error(self) -> float | None:
        """The error of largest size on any wall [m]; none where the cut leaves no wall."""
        return _largest(self.entry_wall, self.exit_wall)

    @property
    def dynamic_error(self) -> float | None:
        """The same without the mean deflection, which an offset of the path can take back [m]."""
        along = float(self.static[1])
        entry = None if self.entry_wall is None else self.entry_wall - along
        leaving = None if self.exit_wall is None else self.exit_wall + along
        return _largest(entry, leaving)

    def _wall(self, passing: float, outward: float) -> np.ndarray:
        lag = 2 * self.height * np.tan(self.cut.cutter.helix) / self.cut.cutter.diameter
        return outward * self.at(passing + lag)[:, 1]


def forced_vibration(
    tip: TipReceptance, cut: Cut, spindle_speed: float, depth: float | None = None
) -> ForcedVibration:
    """Vibration of the tip under the cutting force of the undisturbed cut.

    Args:
        tip: receptance of the tip in the frame of the cut.
        cut: the cut; it has to say the feed per tooth.
        spindle_speed: [rev/min].
        depth: axial depth of cut [m]; that of the cut if none.

    Raises:
        InvalidRequest: no feed per tooth, or no depth.
        InvalidFrequencies: a measured receptance does not cover 0 Hz or the tooth-passing frequency.
    """
    depth = cut.engagement.depth if depth is None else depth
    if cut.engagement.feed_per_tooth is None or depth is None:
        raise InvalidRequest(
            Fault("cut", "engagement", "no feed_per_tooth and depth", "both, for forced vibration")
        )
    frequency = _harmonics(tip, cut, spindle_speed)
    force = static_force_harmonics(cut, np.arange(len(frequency)), depth)
    displacement = np.einsum("kij,kj->ki", tip.receptance(frequency), force)
    return ForcedVibration(cut, spindle_speed, depth, frequency, force, displacement)


def _harmonics(tip: TipReceptance, cut: Cut, spindle_speed: float) -> Float[np.ndarray, " harmonic"]:
    """0, the tooth-passing frequency and its multiples, as far as the tip is known [Hz]."""
    passing, most = 1 / cut.tooth_period(spindle_speed), _HARMONICS
    if np.isfinite(tip.highest):
        most = max(1, min(most, int(np.floor(tip.highest / passing))))
    return np.arange(most + 1) * passing


def _waves(angle: np.ndarray, teeth: int, count: int) -> np.ndarray:
    """From Fourier coefficients of orders 0 … to a real function at angles of the cutter."""
    order = np.arange(count)
    return np.exp(1j * np.outer(angle, order * teeth)) * np.where(order == 0, 1, 2)


@lru_cache(maxsize=8)
def _period(teeth: int, count: int) -> np.ndarray:
    """The same over a tooth period."""
    return _waves(2 * np.pi / teeth * np.arange(_SAMPLES) / _SAMPLES, teeth, count)


def _largest(*walls: np.ndarray | None) -> float | None:
    """The entry of largest size; none if there is no wall."""
    every = np.concatenate([np.zeros(0), *(wall for wall in walls if wall is not None)])
    return float(every[np.argmax(np.abs(every))]) if len(every) else None


@dataclass(frozen=True, eq=False)
class ForcedSweep:
    """Forced vibration over spindle speed, at one depth."""

    speed: Float[np.ndarray, " speed"]
    """[rev/min]."""
    depth: float
    """[m]."""
    static: Float[np.ndarray, "speed 3"]
    """Mean deflection along x, y, z [m]."""
    peak: Float[np.ndarray, "speed 3"]
    """Largest departure from it [m]."""
    surface_error: Float[np.ndarray, " speed"]
    """Error of largest size on a wall, positive where too much is cut [m]; not a number without a wall."""
    dynamic_error: Float[np.ndarray, " speed"]
    """The same without the mean deflection [m]."""


def forced_sweep(
    tip: TipReceptance, cut: Cut, speed: Float[np.ndarray, " speed"], depth: float | None = None
) -> ForcedSweep:
    """`forced_vibration` at several speeds.

    Args:
        tip: how the tip gives way.
        cut: the cut.
        speed: spindle speeds [rev/min].
        depth: axial depth; that of the cut if None [m].

    Raises:
        As `forced_vibration`.
        InvalidRequest: see there.
    """
    each = [forced_vibration(tip, cut, float(one), depth) for one in speed]
    errors, dynamic = (
        np.array([getattr(one, name) for one in each], dtype=float)  # none becomes not a number
        for name in ("surface_error", "dynamic_error")
    )
    static, peak = np.array([one.static for one in each]), np.array([one.peak for one in each])
    return ForcedSweep(speed, each[0].depth, static, peak, errors, dynamic)
