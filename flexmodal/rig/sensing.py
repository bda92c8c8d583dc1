"""Sensors as they are, beside what the records say of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import part_of_turn, turn

Filter = Callable[[np.ndarray], np.ndarray]
"""Reading over truth by angular frequency [rad/s]."""


@dataclass
class Sensor:
    """One accelerometer on its point; made sound, then spoilt by effects."""

    gain: float = 1.0
    """Reading over truth."""
    delay: float = 0.0
    """[s]"""
    step: float = 0.0
    """How much later each of its axes comes than the one before [s]."""
    turned: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    """Rotation of the sensor on its link, axes of the link; or any other mixture of its axes."""
    leaning: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    """Rotation of the sensor that stays the same in the world, whatever the posture."""
    following: tuple[Float[np.ndarray, "3 3"], float] | None = None
    """Axes of its link in the first posture, and the part of the link's turn since that it makes too."""
    sagging: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """How it stands out of its link, in the frame of the link, times the turn that its weight gives it where
    that is level [rad]."""
    resets: tuple[tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 3"]], ...] = ()
    """Of each posture the axes of its link, and a rotation of the sensor on it, in these axes."""
    offset: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """From the marked point to where it truly measures, in the frame of the link [m]."""
    mass: float = 0.0
    """[kg]"""
    loads: list[Callable[[PlantAssembly, CampaignPoint], None]] = field(default_factory=list)
    """What else it puts onto the structure where it sits."""
    later: list[Callable[[Sensor, int], None]] = field(default_factory=list)
    """What becomes of it from posture to posture, told the number of the posture, from 0 on."""
    filters: list[Filter] = field(default_factory=list)
    """What its electronics and its mount make of the signal."""
    range: float = np.inf
    """Where it saturates [m/s²]."""

    @property
    def weighs(self) -> bool:
        """Whether the structure feels it."""
        return self.mass > 0 or bool(self.loads)

    def load(self, assembly: PlantAssembly, point: CampaignPoint) -> None:
        """Put it onto the structure.

        Args:
            assembly: the plant in the making.
            point: that carries it.
        """
        if self.mass > 0:
            assembly.add_body(point.link, np.array(point.xyz), self.mass)
        for load in self.loads:
            load(assembly, point)

    def direction(
        self, axes: Float[np.ndarray, "3 3"], nominal: Float[np.ndarray, "3"]
    ) -> Float[np.ndarray, "3"]:
        """World direction that it measures when it is recorded as `nominal`, on a link with these axes.

        Args:
            axes: of the link in the world, column by column.
            nominal: unit vector in the world that the record names.
        """
        if self.following is not None:
            first, part = self.following
            nominal = part_of_turn(axes @ first.T, part) @ nominal
        set_on = self._reset(axes) @ self.turned
        return self.leaning @ self._sagged(axes) @ axes @ set_on @ axes.T @ nominal

    def _reset(self, axes: np.ndarray) -> np.ndarray:
        """Rotation of the posture in which its link stands most nearly like this."""
        if not self.resets:
            return np.eye(3)
        return max(self.resets, key=lambda one: float(np.sum(one[0] * axes)))[1]

    def _sagged(self, axes: np.ndarray) -> np.ndarray:
        """Rotation in the world by the vector `sagging` × down."""
        pulled = np.cross(axes @ self.sagging, np.array([0.0, 0.0, -1.0]))
        angle = float(np.linalg.norm(pulled))
        return turn(pulled, angle) if angle > 0 else np.eye(3)

    def response(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, " line"]:
        """Reading over the acceleration along its direction."""
        value = self.gain * np.exp(-2j * np.pi * frequency * self.delay)
        for shape in self.filters:
            value = value * shape(2 * np.pi * frequency)
        return value

    def skew(self, omega: Float[np.ndarray, " line"], axes: int) -> Complex[np.ndarray, "axis line"]:
        """What it makes of each axis that comes later than the first.

        Args:
            omega: angular frequencies [rad/s].
            axes: how many.
        """
        return np.exp(-1j * self.step * np.arange(axes)[:, None] * omega)

    def filtered(
        self, record: Float[np.ndarray, "*many axis sample"], rate: float
    ) -> Float[np.ndarray, "*many axis sample"]:
        """Records as its filters leave them; the filters are causal, so that nothing of the end comes back.

        Args:
            record: samples.
            rate: of sampling [Hz].
        """
        if not self.filters and not self.step:
            return record
        count = record.shape[-1]
        omega = 2 * np.pi * np.fft.rfftfreq(2 * count, 1 / rate)
        spectrum = np.fft.rfft(record, 2 * count, axis=-1)
        for shape in self.filters:
            spectrum = spectrum * shape(omega)
        if self.step:
            spectrum = spectrum * self.skew(omega, record.shape[-2])
        return np.fft.irfft(spectrum, 2 * count, axis=-1)[..., :count]
