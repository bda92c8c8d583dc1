"""A milling cut: the cutter, its forces, how it engages, and how it stands to the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import InvalidCut
from flexmodal.machining.fields import Field, angle, direction, number, numbers, read_table, text, whole
from flexmodal.text.words import FaultList

_RATIO = Field(number(-10.0, 10.0), "a number from -10 to 10, in parts of force.tangential")
_EDGE = Field(number(0.0, 1e9), "a number in N/m, from 0 to 1e9")
_WHOLE_SIDE = 1e-9
"""How near an entry angle has to be to 0, or an exit angle to 180°, to leave a wall behind [rad]."""

CUTTER = {
    "teeth": Field(whole(1, 100), "a whole number from 1 to 100", required=True),
    "diameter": Field(number(1e-6, 10.0), "a number in m, above 0 (from 1e-6) and at most 10", required=True),
    "helix": Field(angle(0.0, 80.0), 'an angle from 0 to 80 degrees: rad, or like "30deg"'),
    "approach": Field(angle(1.0, 90.0), 'an angle from 1 to 90 degrees: rad, or like "45deg"'),
}
FORCE = {
    "tangential": Field(
        number(1e-3, 1e13), "a number in N/m², above 0 (from 1e-3), at most 1e13", required=True
    ),
    "radial_ratio": _RATIO,
    "axial_ratio": _RATIO,
    "tangential_edge": _EDGE,
    "radial_edge": _EDGE,
    "axial_edge": _EDGE,
}
ENGAGEMENT = {
    "entry": Field(angle(0.0, 180.0), 'an angle from 0 to 180 degrees: rad, or like "90deg"', required=True),
    "exit": Field(angle(0.0, 180.0), 'an angle from 0 to 180 degrees: rad, or like "180deg"', required=True),
    "spindle_speed": Field(
        numbers(2, 1e-3, 1e7), "two numbers in rev/min, the lower first, from 0.001 to 1e7", required=True
    ),
    "feed_per_tooth": Field(number(1e-9, 1.0), "a number in m, above 0 (from 1e-9) and at most 1"),
    "depth": Field(number(1e-9, 10.0), "a number in m, above 0 (from 1e-9) and at most 10"),
}
FRAME = {
    "relative_to": Field(text("tool", "world"), '"tool" or "world"', required=True),
    "axis": Field(direction, 'a direction: "+x", "-z", … or three numbers, not all 0', required=True),
    "feed": Field(direction, 'a direction: "+x", "-z", … or three numbers, not all 0', required=True),
    "point": Field(text(), "the name of a point of the robot or of a URDF link"),
    "offset": Field(numbers(3, -1e3, 1e3), "three numbers in m, from -1000 to 1000"),
}
MODE = {
    "direction": Field(text("x", "y", "z"), '"x" (feed), "y" (normal) or "z" (axis)', required=True),
    "frequency": Field(number(1e-6, 1e6), "a number in Hz, above 0 (from 1e-6), at most 1e6", required=True),
    "damping_ratio": Field(number(1e-6, 0.999), "a number from 1e-6 to 0.999", required=True),
    "stiffness": Field(
        number(1e-6, 1e15), "a number in N/m, above 0 (from 1e-6) and at most 1e15", required=True
    ),
}


@dataclass(frozen=True)
class Cutter:
    """The end mill or face mill; cuts clockwise seen from the spindle, teeth evenly spaced."""

    teeth: int
    diameter: float
    """[m]."""
    helix: float = 0.0
    """Helix angle [rad]."""
    approach: float = math.pi / 2
    """Angle κ between the cutting edge and the plane across the axis [rad]; 90° of an end mill."""

    def __post_init__(self) -> None:
        faults = _settle(self, CUTTER, "cutter")
        if not faults.faults and self.helix > 0 and self.approach < math.pi / 2:
            found = f"{math.degrees(self.helix):g} degrees beside an approach angle below 90 degrees"
            faults.add("cutter.helix", found, "0, or an approach angle of 90 degrees")
        _raise(faults)


@dataclass(frozen=True)
class CuttingForce:
    """Force = (specific force × chip thickness + edge force) × width of cut, on each tooth."""

    tangential: float
    """K_t [N/m²]."""
    radial_ratio: float = 0.0
    """K_r / K_t, along the normal of the cutting edge and away from the chip."""
    axial_ratio: float = 0.0
    """K_a / K_t, along the cutting edge towards the tip."""
    tangential_edge: float = 0.0
    """[N/m]."""
    radial_edge: float = 0.0
    """[N/m]."""
    axial_edge: float = 0.0
    """[N/m]."""

    def __post_init__(self) -> None:
        _raise(_settle(self, FORCE, "force"))

    @property
    def specific(self) -> Float[np.ndarray, "3"]:
        """K_t, K_r, K_a [N/m²]."""
        return self.tangential * np.array([1.0, self.radial_ratio, self.axial_ratio])

    @property
    def edge(self) -> Float[np.ndarray, "3"]:
        """Edge forces per width, tangential, radial, axial [N/m]."""
        return np.array([self.tangential_edge, self.radial_edge, self.axial_edge])


@dataclass(frozen=True)
class Engagement:
    """Where a tooth cuts, how fast it turns and what it is fed.

    Angles are counted from the normal y of the frame, clockwise seen from the spindle: a tooth enters at
    `entry`, moves against the feed's normal and leaves at `exit`. Up-milling begins at 0, down-milling
    ends at 180°.
    """

    entry: float
    """[rad]."""
    exit: float
    """[rad]."""
    spindle_speed: tuple[float, float]
    """Lowest and highest speed looked at [rev/min]."""
    feed_per_tooth: float | None = None
    """[m]; with `depth`, for forced vibration."""
    depth: float | None = None
    """Axial depth of cut that is meant to be taken [m]."""

    def __post_init__(self) -> None:
        faults = _settle(self, ENGAGEMENT, "engagement")
        if not faults.faults:
            if not self.exit - self.entry > _WHOLE_SIDE:
                found = f"{math.degrees(self.exit):g} degrees"
                faults.add(
                    "engagement.exit", found, f"more than entry, which is {math.degrees(self.entry):g}"
                )
            if self.spindle_speed[0] >= self.spindle_speed[1]:
                low, high = self.spindle_speed
                faults.add(
                    "engagement.spindle_speed", f"[{low:g}, {high:g}]", ENGAGEMENT["spindle_speed"].allowed
                )
            if (self.feed_per_tooth is None) != (self.depth is None):
                missing = "feed_per_tooth" if self.feed_per_tooth is None else "depth"
                faults.add(f"engagement.{missing}", "nothing", "both of feed_per_tooth and depth, or neither")
        _raise(faults)

    @property
    def leaves_entry_wall(self) -> bool:
        """Whether the wall at +y is cut, as in up-milling."""
        return self.entry <= _WHOLE_SIDE

    @property
    def leaves_exit_wall(self) -> bool:
        """Whether the wall at −y is cut, as in down-milling."""
        return self.exit >= math.pi - _WHOLE_SIDE


def immersion_angles(immersion: float, milling: str) -> tuple[float, float]:
    """Entry and exit angle [rad] of a radial depth given in parts of the diameter; "up" or "down".

    Args:
        immersion: radial depth over diameter, above 0 and at most 1.
        milling: "up" or "down".
    """
    if milling == "up":
        return 0.0, math.acos(1 - 2 * immersion)
    return math.acos(2 * immersion - 1), math.pi


@dataclass(frozen=True)
class CutFrame:
    """Axes of the cut: z from the tip into the spindle, x the way the tool is fed, y = z × x."""

    relative_to: str
    """Whether the directions turn with the robot's tool or stand in the world."""
    axis: str | tuple[float, float, float]
    """From the tip into the spindle: "+z" and the like, or a vector; a unit vector once made."""
    feed: str | tuple[float, float, float]
    """The way the tool moves over the work; the same."""
    point: str | None = None
    """Point of the robot or URDF link that carries the cutter; the robot's tool if none."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The cutter's tip from that point, along the axes of its link [m]."""

    def __post_init__(self) -> None:
        faults = _settle(self, FRAME, "frame")
        along = 0.0 if faults.faults else abs(float(np.dot(_vector(self.axis), _vector(self.feed))))
        if along > 1e-3:
            degrees = math.degrees(math.acos(min(1.0, along)))
            faults.add(
                "frame.feed", f"{degrees:.3g} degrees from frame.axis", "a direction across frame.axis"
            )
        _raise(faults)

    @property
    def rows(self) -> Float[np.ndarray, "3 3"]:
        """Unit vectors x, y, z as rows, along the axes of what the frame is relative to."""
        z, feed = _vector(self.axis), _vector(self.feed)
        x = feed - np.dot(feed, z) * z
        x /= np.linalg.norm(x)
        return np.array([x, np.cross(z, x), z])


@dataclass(frozen=True)
class ToolMode:
    """A mode of cutter, holder and spindle on their own, seen at the tip."""

    direction: str
    """x, y or z of the frame of the cut."""
    frequency: float
    """[Hz]."""
    damping_ratio: float
    stiffness: float
    """Modal stiffness at the tip [N/m]."""

    def __post_init__(self) -> None:
        _raise(_settle(self, MODE, "mode"))


@dataclass(frozen=True)
class Cut:
    """A milling cut. Get one from a file with `read_cut`."""

    cutter: Cutter
    force: CuttingForce
    engagement: Engagement
    frame: CutFrame
    modes: tuple[ToolMode, ...] = ()
    title: str = ""
    source: str = ""

    def tooth_period(self, spindle_speed: float) -> float:
        """Time between two teeth [s] at a spindle speed [rev/min]."""
        return 60 / (self.cutter.teeth * spindle_speed)


def _vector(given: str | tuple[float, float, float]) -> np.ndarray:
    """A direction already read."""
    return np.asarray(given, dtype=float)


def _settle(record: Any, table: Mapping[str, Field], section: str) -> FaultList:
    """Judge the fields of a dataclass by its table and put the values read in their place."""
    faults = FaultList(Path("call"))
    given = {field.name: getattr(record, field.name) for field in fields(record)}
    values = read_table({key: v for key, v in given.items() if v is not None}, table, section, faults)
    for key, value in (values or {}).items():
        object.__setattr__(record, key, value)
    return faults


def _raise(faults: FaultList) -> None:
    if faults.faults:
        raise InvalidCut(faults.faults)
