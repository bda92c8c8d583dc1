"""A robot at rest in a posture, as bodies and motion maps: all that a change of its parameters needs.

A motion map has six rows (linear, angular; world axes) over the coordinates: what one unit of each does to a
point. The mass matrix is the sum of Gᵀ I G over the bodies, which `tests/identification` holds against
Pinocchio's; parameters of bodies enter it linearly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

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


Load = tuple[str, tuple[float, float, float], float]
"""Link, place in its frame [m] and mass [kg] of something bolted on."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot in one posture."""

    robot: Robot
    q: Mapping[str, float]
    """Values of commanded joints [rad, m]; a joint left out is 0."""
    locked: tuple[str, ...] = ()
    """Joints that are held."""
    bolted: tuple[Load, ...] = ()
    """Masses beside those of the URDF."""

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
                    maps[link][:3, column] = crossed(axis, placed[link][:3, 3] - pivot)
                    maps[link][3:, column] = axis
        return FrozenDict(maps)

    @cached_property
    def bodies(self) -> Mapping[str, Body]:
        """Links that have mass."""
        return bodies_of(self.robot.urdf)


@dataclass(frozen=True, eq=False)
class Arms:
    """A robot in several postures side by side; otherwise as an `Arm`."""

    robot: Robot
    placed: Mapping[str, Float[np.ndarray, "posture 4 4"]]
    maps: Mapping[str, Float[np.ndarray, "posture 6 joint"]]
    bodies: Mapping[str, Body]
    locked: tuple[tuple[str, ...], ...] = ()
    bolted: tuple[tuple[Load, ...], ...] = ()
    """Of each posture; see `Arm`."""

    @classmethod
    def of(cls, arms: Sequence[Arm]) -> Arms:
        """One after the other."""
        first = arms[0]
        placed = {link: np.array([arm.placed[link] for arm in arms]) for link in first.placed}
        maps = {link: np.array([arm.maps[link] for arm in arms]) for link in first.maps}
        locked, bolted = tuple(arm.locked for arm in arms), tuple(arm.bolted for arm in arms)
        return cls(first.robot, FrozenDict(placed), FrozenDict(maps), first.bodies, locked, bolted)

    def take(self, postures: Int[np.ndarray, " taken"]) -> Arms:
        """Some of them, in any order, any of them several times."""
        placed, maps = (
            FrozenDict({link: value[postures] for link, value in table.items()})
            for table in (self.placed, self.maps)
        )
        locked, bolted = (tuple(table[k] for k in postures.tolist()) for table in (self.locked, self.bolted))
        return Arms(self.robot, placed, maps, self.bodies, locked, bolted)


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
    """The link and every link it carries.

    Args:
        urdf: with the link.
        link: name of the one that the others hang on.
    """
    return urdf.beyond[link]


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

    Args:
        robot: with the link.
        link: its name.
    """
    ends = [np.asarray(joint.xyz) for joint in robot.urdf.joints if joint.parent == link]
    if not any(np.linalg.norm(end) > 0 for end in ends):
        ends += [np.array(point.xyz) for point in robot.points.values() if point.link == link]
    if not any(np.linalg.norm(end) > 0 for end in ends):
        ends.append(2 * np.asarray(robot.urdf.link_by_name[link].com))
    return max(ends, key=lambda end: float(np.linalg.norm(end)))


def carried(
    motion: Float[np.ndarray, "*#many 6 dof"], lever: Float[np.ndarray, "*#many 3"]
) -> Float[np.ndarray, "*many 6 dof"]:
    """Motion of the same body at a point `lever` away [m]: v + ω × lever, and ω.

    Args:
        motion: of the point that is known, over the coordinates: linear rows first, then turning ones.
        lever: from that point to the other, in the same axes [m].
    """
    shape = np.broadcast_shapes(motion.shape[:-2], lever.shape[:-1])
    moved = np.empty((*shape, *motion.shape[-2:]))
    moved[...] = motion
    x, y, z = (lever[..., k, None] for k in range(3))
    a, b, c = (motion[..., k, :] for k in range(3, 6))
    moved[..., 0, :] += b * z - c * y
    moved[..., 1, :] += c * x - a * z
    moved[..., 2, :] += a * y - b * x
    return moved


def crossed(
    a: Float[np.ndarray, "*#many 3"], b: Float[np.ndarray, "*#many 3"]
) -> Float[np.ndarray, "*many 3"]:
    """A × b, written out: `np.cross` takes ten times as long on few vectors.

    Args:
        a: the first vectors.
        b: the second ones, in the same axes.
    """
    found = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., k] = a[..., i] * b[..., j] - a[..., j] * b[..., i]
    return found
