"""A posture: one value for every commanded joint, inside its limits."""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmodal.cards import FrozenDict, UrdfJoint
from flexmodal.cards.consistency import TOLERANCE
from flexmodal.errors import Fault, InvalidPosture
from flexmodal.text.words import strange


@dataclass(frozen=True)
class Posture:
    """Values of the commanded joints [rad, m]; evidence that they exist and lie within the limits."""

    values: Mapping[str, float]
    name: str = ""
    degrees: frozenset[str] = field(default=frozenset(), compare=False)
    """Joints that were given in degrees, and are shown so."""

    def __str__(self) -> str:
        """The name, or the values as they are typed on the command line."""
        return self.name or ", ".join(f"{joint}={self._shown(joint)}" for joint in self.values)

    def __repr__(self) -> str:
        """Its name and its values."""
        values = " ".join(f"{joint}={value:.4g}" for joint, value in self.values.items())
        return f"<Posture {self.name + ': ' if self.name else ''}{values}>"

    def _shown(self, joint: str) -> str:
        value = self.values[joint]
        return f"{math.degrees(value):.6g}deg" if joint in self.degrees else f"{value:.6g}"


FARTHEST = 1e4
"""Beyond it a number is no angle of a joint that has no limits: sines have lost their digits [rad, m]."""

Pose = str | Posture | Mapping[str, float] | Sequence[float | int] | np.ndarray
"""A posture's name, a checked posture, values by joint name, or values in Pinocchio's order."""


def middle(commanded: Mapping[str, UrdfJoint]) -> Posture:
    """A posture inside the limits: 0 where that is allowed, else half-way between them."""
    values = {
        name: 0.0 if joint.lower <= 0 <= joint.upper else (joint.lower + joint.upper) / 2
        for name, joint in commanded.items()
    }
    return Posture(FrozenDict(values))


def check_posture(
    given: Mapping[str, float],
    commanded: Mapping[str, UrdfJoint],
    pseudo: tuple[str, ...],
    *,
    name: str = "",
    source: str = "call",
) -> Posture:
    """Fill in the joints left out with 0 and check the rest.

    Args:
        given: value by joint name [rad, m].
        commanded: the joints a posture may set.
        pseudo: pseudo-joints, which rest at 0 and are never commanded.
        name: what the posture is called.
        source: where it came from, for the error.

    Raises:
        InvalidPosture: unknown or pseudo joints, values that are not finite numbers, values outside
            the limits; all at once.
    """
    faults = []
    for joint, value in given.items():
        if joint not in commanded:
            faults.append(_unknown(joint, commanded, pseudo, source))
        elif not is_number(value):
            faults.append(Fault(source, f"posture: {joint}", repr(value), "a finite number [rad, m]"))
    for joint, urdf in commanded.items():
        value = given.get(joint, 0.0)
        low, high = max(urdf.lower, -FARTHEST), min(urdf.upper, FARTHEST)
        if is_number(value) and not low - TOLERANCE <= value <= high + TOLERANCE:
            allowed = f"{low:.6g} to {high:.6g}"
            allowed += ", the joint's limits" if math.isfinite(urdf.upper - urdf.lower) else ""
            left_out = "" if joint in given else " (left out, so 0)"
            faults.append(Fault(source, f"posture: {joint}", f"{float(value):.6g}{left_out}", allowed))
    if faults:
        raise InvalidPosture(faults)
    return Posture(FrozenDict({joint: float(given.get(joint, 0.0)) for joint in commanded}), name)


def is_number(value: object) -> bool:
    """Whether it is a finite real number, Python's or numpy's; truth values are not."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that no float can hold
        return False


def _unknown(joint: str, commanded: Mapping[str, UrdfJoint], pseudo: tuple[str, ...], source: str) -> Fault:
    if joint in pseudo:
        found = f"the pseudo-joint {joint}, which rests at 0 and is never commanded"
    else:
        found = f"unknown joint {strange(joint, commanded)}"
    return Fault(source, "posture", found, ", ".join(commanded))
