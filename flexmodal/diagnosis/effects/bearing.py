"""The ways in which the bearing of a joint gives across its axis, and their coordinates.

Two tilts, two shifts across the axis and one along it; of a planar chain the two shifts alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.model.placements import link_placements
from flexmodal.structure.assembly import Assembly

ALL = "joints"
"""Where all joints are meant."""
RADIUS = 0.15
"""Of a bearing, about [m]: what a tilt's stiffness makes of one across or along the axis."""
TILT = 5.0
"""Stiffness of a tilt over that of the joint, about."""


@dataclass(frozen=True, eq=False)
class Way:
    """One way in which a bearing gives."""

    kind: str
    """tilt, radial or axial."""
    number: int
    """1 or 2."""
    vector: Float[np.ndarray, "3"]
    """Direction, or axis of the turn, in the frame of the joint on the side of the carrying link."""

    @property
    def turns(self) -> bool:
        """Whether it is a turn."""
        return self.kind == "tilt"

    @property
    def name(self) -> str:
        """Such as tilt 1."""
        return f"{self.kind} {self.number}"


def frame_of(context: Context, joint: str) -> Float[np.ndarray, "3 3"]:
    """Axes of the joint in the carrying link.

    Args:
        context: of the diagnosis.
        joint: its name.
    """
    still, described = link_placements(context.robot, {}), context.robot.urdf.joint_by_name[joint]
    return still[described.parent][:3, :3].T @ still[described.child][:3, :3]


@lru_cache(maxsize=256)
def ways(context: Context, joint: str) -> tuple[Way, ...]:
    """In how many ways a joint can give that the chain can show; slides have none.

    Args:
        context: of the diagnosis.
        joint: its name.
    """
    described = context.robot.urdf.joint_by_name[joint]
    if described.is_prismatic:
        return ()
    axis = np.asarray(described.axis) / np.linalg.norm(described.axis)
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    sides = (first, np.cross(axis, first))
    radial = tuple(Way("radial", k + 1, side) for k, side in enumerate(sides))
    if context.normal is not None:
        return radial
    return (*(Way("tilt", k + 1, side) for k, side in enumerate(sides)), *radial, Way("axial", 1, axis))


def joints_at(context: Context, where: str) -> tuple[str, ...]:
    """Those of a place.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
    """
    return context.joints if where == ALL else (where,)


def given(context: Context, where: str, joint: str) -> tuple[Way, ...]:
    """The ways in which a joint gives at a place: of all joints alike, tilts alone.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
        joint: name of one there.
    """
    return tuple(way for way in ways(context, joint) if where != ALL or way.turns)


def size(context: Context, joint: str) -> float:
    """A stiffness of tilts that a joint's own suggests [N·m/rad].

    Args:
        context: of the diagnosis.
        joint: its name.
    """
    return TILT * float(context.robot.joints[joint].stiffness)


def coordinate(joint: str, way: Way) -> str:
    """Name of the coordinate of a way.

    Args:
        joint: its name.
        way: in which it gives.
    """
    return f"{joint} {way.name}"


def names_of(context: Context, where: str) -> list[tuple[str, Way, str]]:
    """Joint, way and coordinate, one after the other.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
    """
    return [
        (joint, way, coordinate(joint, way))
        for joint in joints_at(context, where)
        for way in given(context, where, joint)
    ]


def add_ways(assembly: Assembly, placement: Placement, *, turning: bool = False) -> None:
    """A coordinate for each way in which joints give.

    Args:
        assembly: the robot, its motions not complete yet.
        placement: of the effect; its place is the joint, or `ALL`.
        turning: whether the ways turn with the carried link.
    """
    context, where = placement.context, placement.where
    for joint in joints_at(context, where):
        some = given(context, where, joint)
        if not some:
            continue
        described = context.robot.urdf.joint_by_name[joint]
        columns = assembly.add_coordinates([coordinate(joint, way) for way in some])
        if turning:
            axes = assembly.axes(described.child)
        else:
            axes = assembly.axes(described.parent) @ frame_of(context, joint)
        motion = np.zeros((*axes.shape[:-2], 6, len(some)))
        for k, way in enumerate(some):
            motion[..., 3 * way.turns : 3 * way.turns + 3, k] = axes @ way.vector
        assembly.move_link(described.child, columns, motion)


@lru_cache(maxsize=256)
def levers(context: Context, where: str, joint: str) -> Float[np.ndarray, "way way"]:
    """Motion along each way, by each tilt, of a point on the joint's axis as far from its middle as 1.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
        joint: name of one there.
    """
    some, axis = given(context, where, joint), np.asarray(context.robot.urdf.joint_by_name[joint].axis)
    along = np.array([np.zeros(3) if way.turns else way.vector for way in some])
    tilted = np.array([np.cross(way.vector, axis) if way.turns else np.zeros(3) for way in some])
    return along @ tilted.T
