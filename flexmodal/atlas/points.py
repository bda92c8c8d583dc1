"""Which postures an atlas covers: a grid over some joints, or a random sample; never all in memory."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Container, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.atlas.layout import Slices
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.text.words import strange

MOST_POSTURES = 10**12
"""More are a slip of the keyboard: their places alone would fill a disk."""
MOST_VALUES = 1_000_000
"""Of one joint of a grid."""
_BLOCK = 1024
"""Postures of a sample that are drawn together; the same whatever the chunks are."""


@dataclass(frozen=True, eq=False)
class Points(ABC):
    """Postures of a robot, in an order of their own."""

    robot: Robot

    @property
    @abstractmethod
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions that the postures lie along."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Lengths of those dimensions."""

    @property
    @abstractmethod
    def held(self) -> Mapping[str, float]:
        """Joints that stand still [rad, m]."""

    @abstractmethod
    def values(self, region: Slices) -> Float[np.ndarray, "posture commanded"]:
        """The postures of a region of the dimensions, the last dimension fastest [rad, m]."""

    @abstractmethod
    def facts(self) -> dict[str, Any]:
        """What tells these postures from others, for JSON."""

    @property
    def count(self) -> int:
        """How many there are."""
        return math.prod(self.shape)


@dataclass(frozen=True, eq=False)
class Grid(Points):
    """Every combination of some values of each joint; a joint with one value stands still."""

    joints: Mapping[str, Float[np.ndarray, " value"]]
    """Ascending values of every commanded joint [rad, m]."""

    def __post_init__(self) -> None:
        """Check joints, order, limits and the number of postures.

        Raises:
            InvalidRequest: a joint that is missing or unknown, values outside the limits or not ascending.
        """
        faults = _name_faults(self.robot, self.joints, "grid")
        names = [name for name in self.robot.commanded if name not in self.joints]
        if names:
            allowed = "every joint that a posture sets: JOINT=START:STOP:COUNT, or JOINT=VALUE"
            faults.append(Fault("call", "grid", f"nothing for {', '.join(names)}", allowed))
        known = {name: self.joints[name] for name in self.robot.commanded if name in self.joints}
        for name, given in known.items():
            axis = np.atleast_1d(np.array(given, dtype=float))
            axis.flags.writeable = False
            known[name] = axis
            if not 1 <= axis.size <= MOST_VALUES or axis.ndim != 1:
                allowed = f"1 to {MOST_VALUES:,}"
                faults.append(Fault("call", f"grid {name}", f"{axis.size} values", allowed))
            elif not np.all(np.isfinite(axis)) or (axis.size > 1 and np.min(np.diff(axis)) <= 0):
                faults.append(Fault("call", f"grid {name}", "values out of order", "ascending numbers"))
            else:
                faults += _limit_faults(self.robot, "grid", name, float(axis[0]), float(axis[-1]))
        object.__setattr__(self, "joints", known)
        if not faults:
            faults = _count_faults("grid", self.count)
        if faults:
            raise InvalidRequest(faults)

    @cached_property
    def varied(self) -> Mapping[str, Float[np.ndarray, " value"]]:
        """The joints with several values; of a single posture the first, with one."""
        found = {name: axis for name, axis in self.joints.items() if len(axis) > 1}
        return found or dict([next(iter(self.joints.items()))])

    @property
    def dims(self) -> tuple[str, ...]:
        """The joints with several values."""
        return tuple(self.varied)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each of them has."""
        return tuple(len(axis) for axis in self.varied.values())

    @property
    def held(self) -> Mapping[str, float]:
        """The joints with one value [rad, m]."""
        return {name: float(axis[0]) for name, axis in self.joints.items() if name not in self.varied}

    def values(self, region: Slices) -> Float[np.ndarray, "posture commanded"]:
        """The postures of a region, the last joint fastest [rad, m]."""
        axes = [axis[part] for axis, part in zip(self.varied.values(), region, strict=True)]
        mesh = dict(zip(self.varied, np.meshgrid(*axes, indexing="ij"), strict=True))
        out = np.empty((math.prod(len(axis) for axis in axes), len(self.joints)))
        for place, name in enumerate(self.joints):
            out[:, place] = mesh[name].ravel() if name in mesh else self.joints[name][0]
        return out

    def facts(self) -> dict[str, Any]:
        """The values of every joint."""
        return {"kind": "grid", "joints": {name: axis.tolist() for name, axis in self.joints.items()}}


@dataclass(frozen=True, eq=False)
class Sample(Points):
    """Postures drawn evenly from ranges of the joints."""

    size: int
    ranges: Mapping[str, tuple[float, float]]
    """Of every commanded joint [rad, m]; both ends alike where it stands still."""
    seed: int = 0

    def __post_init__(self) -> None:
        """Check joints, ranges and the number of postures.

        Raises:
            InvalidRequest: a joint that is missing or unknown, a range outside the limits or reversed.
        """
        faults = _count_faults("sample", self.size) + _name_faults(self.robot, self.ranges, "range")
        missing = [name for name in self.robot.commanded if name not in self.ranges]
        if missing:
            allowed = "a range of every joint that a posture sets"
            faults.append(Fault("call", "range", f"nothing for {', '.join(missing)}", allowed))
        if isinstance(self.seed, bool) or self.seed < 0:
            faults.append(Fault("call", "seed", str(self.seed), "a whole number ≥ 0"))
        known = {name: self.ranges[name] for name in self.robot.commanded if name in self.ranges}
        for name, (low, high) in known.items():
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                faults.append(Fault("call", f"range {name}", f"{low:g} to {high:g}", "START:STOP, ascending"))
            else:
                faults += _limit_faults(self.robot, "range", name, low, high)
        object.__setattr__(self, "ranges", known)
        if faults:
            raise InvalidRequest(faults)

    @property
    def dims(self) -> tuple[str, ...]:
        """One, of the postures."""
        return ("posture",)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many postures."""
        return (self.size,)

    @property
    def held(self) -> Mapping[str, float]:
        """The joints whose range is one value [rad, m]."""
        return {name: low for name, (low, high) in self.ranges.items() if low == high}

    def values(self, region: Slices) -> Float[np.ndarray, "posture commanded"]:
        """The postures of a region [rad, m]; each is the same whatever the region."""
        (part,) = region
        low, high = (np.array(ends) for ends in zip(*self.ranges.values(), strict=True))
        edges = range(part.start // _BLOCK, -(-part.stop // _BLOCK))
        drawn = [np.random.default_rng([self.seed, block]).random((_BLOCK, len(low))) for block in edges]
        first = part.start - edges.start * _BLOCK
        unit = np.concatenate(drawn)[first : first + part.stop - part.start]
        return np.clip(low + (high - low) * unit, low, high)

    def facts(self) -> dict[str, Any]:
        """Size, seed and ranges."""
        ranges = {name: list(ends) for name, ends in self.ranges.items()}
        return {"kind": "sample", "size": self.size, "seed": self.seed, "ranges": ranges}


def whole_range(robot: Robot, but: Container[str] = ()) -> dict[str, tuple[float, float]]:
    """All that the limits of each commanded joint allow, over one turn at most [rad, m].

    Args:
        robot: whose joints.
        but: joints that are left out.

    Raises:
        InvalidRequest: a sliding joint without limits.
    """
    found = {}
    for name, joint in robot.commanded.items():
        if name in but:
            continue
        low, high = joint.lower, joint.upper
        if joint.is_prismatic and not (math.isfinite(low) and math.isfinite(high)):
            raise InvalidRequest(Fault("call", f"range {name}", "nothing, and no limits", "START:STOP [m]"))
        if high - low > 2 * math.pi and not joint.is_prismatic:
            middle = min(max(0.0, low + math.pi), high - math.pi)
            low, high = middle - math.pi, middle + math.pi
        found[name] = (float(low), float(high))
    return found


def _name_faults(robot: Robot, given: Mapping[str, Any], what: str) -> list[Fault]:
    allowed = ", ".join(robot.commanded)
    strangers = [name for name in given if name not in robot.commanded]
    return [Fault("call", what, f"unknown joint {strange(n, robot.commanded)}", allowed) for n in strangers]


def _limit_faults(robot: Robot, what: str, name: str, low: float, high: float) -> list[Fault]:
    joint = robot.commanded[name]
    if joint.lower <= low and high <= joint.upper:
        return []
    allowed = f"{joint.lower:.6g} to {joint.upper:.6g}, the joint's limits"
    return [Fault("call", f"{what} {name}", f"{low:.6g} to {high:.6g}", allowed)]


def _count_faults(what: str, count: int) -> list[Fault]:
    if 1 <= count <= MOST_POSTURES:
        return []
    return [Fault("call", what, f"{count:,} postures", f"1 to {MOST_POSTURES:,}")]
