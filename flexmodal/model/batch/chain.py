"""What the compiled kinematics need to know of a robot, taken once from its Pinocchio model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float, Int

from flexmodal.model.build import pinocchio
from flexmodal.model.robot import Robot


@dataclass(frozen=True, eq=False)
class Chain:
    """A serial chain of revolute and prismatic joints; bodies hang behind their joints, in joint frames."""

    turns: Bool[np.ndarray, " moving"]
    """Whether a joint is revolute."""
    axis: Float[np.ndarray, "moving 3"]
    rotation: Float[np.ndarray, "moving 3 3"]
    """Of the joint's frame in the frame of the joint before it."""
    offset: Float[np.ndarray, "moving 3"]
    mass: Float[np.ndarray, " moving"]
    centre: Float[np.ndarray, "moving 3"]
    """Centre of mass."""
    inertia: Float[np.ndarray, "moving 3 3"]
    """About the centre of mass."""
    rotor: Float[np.ndarray, " moving"]
    """Reflected rotor inertia."""

    @cached_property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """The fields, for a compiled function."""
        return (
            self.turns, self.axis, self.rotation, self.offset, self.mass, self.centre, self.inertia,
            self.rotor
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Places:
    """Points on the bodies, and the directions at them that make rows."""

    joint: Int[np.ndarray, " row"]
    """Number of the joint that carries the point; −1 for the base."""
    offset: Float[np.ndarray, "row 3"]
    """Of the point in that joint's frame [m]."""
    selector: Float[np.ndarray, "row 6"]
    """Direction in world axes, translations first."""


_KNOWN: WeakKeyDictionary[Robot, Chain | None] = WeakKeyDictionary()


def chain_of(robot: Robot) -> Chain | None:
    """The robot's chain; None if it branches or has other joints."""
    if robot not in _KNOWN:
        serial = all(parent == number - 1 for number, parent in enumerate(parents_of(robot)))
        _KNOWN[robot] = joints_of(robot) if serial else None
    return _KNOWN[robot]


def parents_of(robot: Robot) -> tuple[int, ...]:
    """Number of the joint that carries each joint; −1 for the base. Each stands behind its own parent."""
    return tuple(int(parent) - 1 for parent in robot.pinocchio.parents[1:])


def joints_of(robot: Robot) -> Chain | None:
    """Joints and bodies as in a chain, whether or not they branch; None if there are other joints.

    Args:
        robot: the robot; `parents_of` says which joint stands on which.
    """
    model = robot.pinocchio
    count = model.nv
    if model.njoints != count + 1:
        return None
    pin = pinocchio()
    data = model.createData()
    columns = pin.computeJointJacobians(model, data, pin.neutral(model)).reshape(6, -1)  # flat for one joint
    local = np.array([data.oMi[i + 1].actInv(pin.Motion(columns[:, i])).vector for i in range(count)])
    turns = np.linalg.norm(local[:, 3:], axis=1) > 0.5
    axis = np.where(turns[:, None], local[:, 3:], local[:, :3])
    off_axis = np.linalg.norm(np.where(turns[:, None], local[:, :3], local[:, 3:]), axis=1)
    if np.any(np.abs(np.linalg.norm(axis, axis=1) - 1) > 1e-12) or np.any(off_axis > 1e-9):
        return None
    bodies = [model.inertias[i] for i in range(1, count + 1)]
    placements = [model.jointPlacements[i] for i in range(1, count + 1)]
    return Chain(
        turns=turns,
        axis=np.ascontiguousarray(axis),
        rotation=np.array([place.rotation for place in placements]),
        offset=np.array([place.translation for place in placements]),
        mass=np.array([float(body.mass) for body in bodies]),
        centre=np.array([body.lever for body in bodies]),
        inertia=np.array([body.inertia for body in bodies]),
        rotor=np.array(model.armature, dtype=float),
    )


def places_of(robot: Robot, directions: tuple[tuple[str, np.ndarray], ...]) -> Places:
    """Points, by name, and selectors of six entries, as a compiled function wants them.

    Args:
        robot: the robot.
        directions: name of the point and selector of each.
    """
    frames = [robot.pinocchio.frames[robot.frame_of(point)] for point, _ in directions]
    return Places(
        joint=np.array([frame.parentJoint - 1 for frame in frames], dtype=np.int64),
        offset=np.array([frame.placement.translation for frame in frames]),
        selector=np.array([selector for _, selector in directions], dtype=float),
    )


def turn_of(robot: Robot, point: str) -> Float[np.ndarray, "3 3"]:
    """Axes of a point's frame in the frame of the joint that carries it, column by column.

    Args:
        robot: the robot.
        point: name of the point.
    """
    return np.array(robot.pinocchio.frames[robot.frame_of(point)].placement.rotation)
