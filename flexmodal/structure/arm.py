"""A robot at rest in a posture, as bodies and motion maps: all that a change of its parameters needs.

A motion map has six rows (linear, angular; world axes) over the coordinates: what one unit of each does to a
point. The mass matrix is the sum of Gᵀ I G over the bodies, which `tests/identification` holds against
Pinocchio's; parameters of bodies enter it linearly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.cards import FrozenDict, Urdf
from flexmodal.model import Robot
from flexmodal.model.chain import FlexibleChain
from flexmodal.model.placements import link_placements


@dataclass(frozen=True, eq=False)
class Body:
    """Mass properties of a link, in its frame."""

    mass: float
    """[kg]"""
    centre: Float[np.ndarray, "3"]
    """[m]"""
    inertia: Float[np.ndarray, "3 3"]
    """About the mass centre [kg·m²]."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot in one posture."""

    robot: Robot
    q: Mapping[str, float]
    """Values of commanded joints [rad, m]; a joint left out is 0."""

    @cached_property
    def placed(self) -> Mapping[str, Float[np.ndarray, "4 4"]]:
        """Every link in the world."""
        return link_placements(self.robot, self.q)

    @cached_property
    def maps(self) -> Mapping[str, Float[np.ndarray, "6 joint"]]:
        """Motion of the origin of every link, over the flexible joints."""
        robot, placed = self.robot, self.placed
        joints = [robot.urdf.joint_by_name[name] for name in robot.joints]
        maps = {link.name: np.zeros((6, len(joints))) for link in robot.urdf.links}
        for column, joint in enumerate(joints):
            axis = placed[joint.child][:3, :3] @ joint.axis
            pivot = placed[joint.child][:3, 3]
            for link in beyond(robot.urdf, joint.child):
                if joint.is_prismatic:
                    maps[link][:3, column] = axis
                else:
                    maps[link][:3, column] = np.cross(axis, placed[link][:3, 3] - pivot)
                    maps[link][3:, column] = axis
        return FrozenDict(maps)

    @cached_property
    def bodies(self) -> Mapping[str, Body]:
        """Links that have mass."""
        return bodies_of(self.robot.urdf)


def bodies_of(urdf: Urdf) -> Mapping[str, Body]:
    """Mass properties of the links of a URDF that have mass."""
    none = np.zeros((3, 3))
    return FrozenDict(
        {
            link.name: Body(link.mass, link.com, none if link.inertia is None else link.inertia)
            for link in urdf.links
            if link.mass
        }
    )


def beyond(urdf: Urdf, link: str) -> tuple[str, ...]:
    """The link and every link it carries."""
    found = [link]
    for member in found:
        found += [joint.child for joint in urdf.joints if joint.parent == member]
    return tuple(found)


def moved_bodies(robot: Robot) -> tuple[str, ...]:
    """Links with mass that at least one flexible joint moves, in the order of the URDF."""
    moved: set[str] = set()
    for name in robot.joints:
        moved.update(beyond(robot.urdf, robot.urdf.joint_by_name[name].child))
    return tuple(link.name for link in robot.urdf.links if link.name in moved and link.mass)


def plane_normal(robot: FlexibleChain) -> Float[np.ndarray, "3"] | None:
    """Unit normal of the plane that a planar chain moves in; None for a spatial one."""
    return robot.task[2, 3:].copy() if robot.is_planar else None


def far_end(robot: Robot, link: str) -> Float[np.ndarray, "3"]:
    """From the origin of a link to its far end, in its frame [m].

    Where the farthest joint on it sits; without one its farthest named point or, without that, twice its mass
    centre.
    """
    ends = [np.asarray(joint.xyz) for joint in robot.urdf.joints if joint.parent == link]
    if not any(np.linalg.norm(end) > 0 for end in ends):
        ends += [np.array(point.xyz) for point in robot.points.values() if point.link == link]
    if not any(np.linalg.norm(end) > 0 for end in ends):
        ends.append(2 * np.asarray(robot.urdf.link_by_name[link].com))
    return max(ends, key=lambda end: float(np.linalg.norm(end)))


def carried(motion: Float[np.ndarray, "6 dof"], lever: Float[np.ndarray, "3"]) -> Float[np.ndarray, "6 dof"]:
    """Motion of the same body at a point `lever` away [m]: v + ω × lever, and ω."""
    moved = motion.copy()
    x, y, z = lever
    a, b, c = motion[3:]
    moved[0] += b * z - c * y
    moved[1] += c * x - a * z
    moved[2] += a * y - b * x
    return moved
