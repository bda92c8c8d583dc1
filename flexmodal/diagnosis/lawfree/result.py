"""What a law-free look says: places with their misfits, the curve, its class, effects that it could be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

NEAR = 2.5
"""Times the misfit of the best port, up to which an effect at another one is still fitted."""
PORT_OF: Mapping[str, str] = {
    "joint_coupling": "coupling",
    "structural_damping": "damping",
    "base_flexibility": "base",
    "link_flexibility": "link",
    "added_mass": "body",
    "local_absorber": "body",
    "servo_compliance": "joint",
    "sensor_mass": "carried",
    "sensor_gain": "sensor",
    "time_delay": "sensor",
    "sensor_misalignment": "channel",
    "coulomb_friction": "torque",
    "nonlinear_stiffness": "torque",
}
"""The kind of port that each effect of the catalogue sits at."""
_ELASTIC = ("spring", "spring and damper", "spring with constant loss")
CLASSES_OF: Mapping[str, tuple[str, ...]] = {
    "joint_coupling": ("spring", "spring and damper", "relaxation"),
    "structural_damping": ("constant loss", "relaxation"),
    "base_flexibility": _ELASTIC,
    "link_flexibility": _ELASTIC,
    "added_mass": ("mass",),
    "local_absorber": ("resonance",),
    "servo_compliance": ("resonance", "something in series, with a resonance of its own", "relaxation"),
    "sensor_mass": ("mass",),
    "sensor_gain": ("gain",),
    "time_delay": ("delay",),
}
"""The classes that its curve can be of; effects that are not listed have no common curve to be of a class."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Free functions of a port as they were found; one posture and blow, if they differ."""

    frequency: Float[np.ndarray, " line"]
    """[Hz]"""
    names: tuple[str, ...]
    unit: str
    value: Complex[np.ndarray, "function line"]
    deviation: Float[np.ndarray, "function line"]
    """Standard deviation of the real and of the imaginary part."""


@dataclass(frozen=True)
class Class:
    """A class of physics laid beside the curve."""

    name: str
    says: str
    """In words with its numbers."""
    coefficients: tuple[tuple[float, ...], ...]
    """Of the terms of each function."""
    misfit: float
    """Root of the reduced χ² of the template; about 1 where the curve is of this class."""
    share: float
    """Part of the curve's own χ², against nothing at all, that the template takes."""
    score: float
    """χ², tempered by that of the best class, and ln(number of values) for each parameter."""


@dataclass(frozen=True)
class PlaceTried:
    """A port, fitted and judged."""

    port: str
    """Kind."""
    where: str
    says: str
    """What it would be, for people."""
    misfit: float
    """In units of the noise, on the postures fitted; about 0.6 if perfect."""
    held_out: float | None
    """The same on postures that judged."""
    unknowns: int
    """Functions and parameters of its geometry."""

    @property
    def judged(self) -> float:
        """The larger of both misfits."""
        return self.misfit if self.held_out is None else max(self.misfit, self.held_out)


@dataclass(frozen=True, eq=False)
class Findings:
    """A law-free look in short."""

    alone: float
    """Misfit of the re-tuned robot without any port."""
    places: tuple[PlaceTried, ...]
    """The best first."""
    alike: tuple[PlaceTried, ...]
    """Those that cannot be told from the best; the simplest first."""
    explains: bool
    """Whether a port takes what is missing down to the noise."""
    needed: bool
    """Whether anything is gained by one."""
    curve: Curve | None
    """Of the simplest of the best; None where it has no function in common."""
    classes: tuple[Class, ...]
    """Those that its curve may be of, the likeliest first; empty where it is of none."""
    says: str

    @property
    def share(self) -> float:
        """Part of what the robot alone leaves above the noise that the best port takes."""
        return 1.0 - max(self.best.judged**2 - 1.0, 0.0) / max(self.alone**2 - 1.0, 1e-300)

    @property
    def best(self) -> PlaceTried:
        """The simplest of the best."""
        return self.alike[0]

    def worth_trying(self, effect: str, where: str) -> bool:
        """Whether an effect is to be fitted at a place at all; everything is where no port explains enough.

        Args:
            effect: its name; those that no port stands for are tried always.
            where: its place.
        """
        port = PORT_OF.get(effect)
        if not self.explains or port is None:
            return True
        limit = NEAR * self.places[0].judged
        return any((one.port, one.where) == (port, where) and one.judged <= limit for one in self.places)

    def could_be(self, effect: str, where: str) -> bool:
        """Whether the place and the class allow for an effect of the catalogue.

        Args:
            effect: its name.
            where: its place.
        """
        here = any((one.port, one.where) == (PORT_OF.get(effect), where) for one in self.alike)
        if not here or effect not in CLASSES_OF or self.best.where != where:
            return here
        return any(one.name in CLASSES_OF[effect] for one in self.classes)
