"""Holding the end-effector where it is wanted while the arm moves through its redundancy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.posture import middle
from flexmodal.optimisation.hold.orientation import FixedOrientation, Orientation, aligned

_FARTHEST = 1e6
"""No arm reaches farther [m]."""

_AXES = {sign + name: row for name, row in zip("xyz", np.eye(3), strict=True) for sign in ("", "+")} | {
    "-" + name: -row for name, row in zip("xyz", np.eye(3), strict=True)
}


@dataclass(frozen=True, eq=False)
class Hold:
    """A point held at a target, and, if wanted, its frame turned as wanted.

    The position has two coordinates in the plane of a planar chain, three in space. The orientation adds
    three components in space where it is wholly held, two where the frame may turn about one axis; one in a
    plane.
    """

    point: str
    rows: Float[np.ndarray, "held 3"]
    """Unit vectors along which the position is held."""
    target: Float[np.ndarray, " held"]
    """Coordinates along them [m]."""
    orientation: Orientation | None = None

    @classmethod
    def at(
        cls,
        robot: Robot,
        target: tuple[float, ...],
        point: str | None = None,
        *,
        orientation: Sequence[float] | None = None,
        axis: Sequence[float] | None = None,
        tool_axis: str = "",
    ) -> Hold:
        """Hold the tool (or another point) at a position, and perhaps its orientation.

        Args:
            robot: whose point.
            target: two in-plane coordinates of a planar chain, such as (x, z), or three in space [m].
            point: a named point or link; the tool if none.
            orientation: roll, pitch and yaw about the fixed world axes, as in a URDF [rad]; of a planar chain
                the one angle of `tool_axis`, from the first of the plane's axes towards the second.
            axis: world direction that `tool_axis` points along, free to turn about it; excludes
                `orientation`.
            tool_axis: axis of the point's frame, such as "z" or "-x"; if empty "z", of a planar chain "x".

        Raises:
            InvalidRequest: the wrong number of coordinates, not finite, or contradictory.
            InvalidPoint: no such point.
        """
        point = point or robot.tool
        robot.frame_of(point)
        rows, values = _position(robot, point, target)
        return cls(point, rows, values, _orientation(robot, point, orientation, axis, tool_axis))

    @property
    def components(self) -> int:
        """How many components the error has."""
        return len(self.rows) + (0 if self.orientation is None else self.orientation.components)

    def error(self, posed: PosedRobot) -> Float[np.ndarray, " held"]:
        """How far the point is from its target [m], and its frame from its orientation [rad]."""
        error = self.rows @ posed.position(self.point) - self.target
        if self.orientation is None:
            return error
        return np.concatenate([error, self.orientation.error(posed.rotation(self.point))])

    def jacobian(self, posed: PosedRobot) -> Float[np.ndarray, "held moving"]:
        """Derivative of `error` along every moving joint."""
        full = posed.full_jacobian(self.point)
        moved = self.rows @ full[:3]
        if self.orientation is None:
            return moved
        turned = self.orientation.jacobian(posed.rotation(self.point), full[3:])
        return np.concatenate([moved, turned])


def _position(robot: Robot, point: str, target: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    values = np.array(target, dtype=float)
    if not np.all(np.abs(values) <= _FARTHEST):
        allowed = f"finite coordinates [m], none beyond {_FARTHEST:g}"
        raise InvalidRequest(Fault("call", "hold", str(tuple(target)), allowed))
    if robot.is_planar and len(values) == 2:
        return robot.task[:2, :3], values
    if robot.is_planar and len(values) == 3:
        return _inside_plane(robot, point, values)
    if not robot.is_planar and len(values) == 3:
        return np.eye(3), values
    allowed = "2 or 3 coordinates (planar chain)" if robot.is_planar else "3 coordinates (spatial chain)"
    raise InvalidRequest(Fault("call", "hold", f"{len(values)} coordinates", allowed))


def _inside_plane(robot: Robot, point: str, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Three coordinates for a planar chain: the third must be where the plane lies."""
    normal = robot.task[2, 3:]
    plane = float(normal @ PosedRobot(robot, middle(robot.commanded)).position(point))
    if abs(float(normal @ target) - plane) > 1e-9:
        found = f"a target {float(normal @ target) - plane:.6g} m out of the plane the chain moves in"
        raise InvalidRequest(Fault("call", "hold", found, f"{plane:.6g} m along the plane's normal"))
    return robot.task[:2, :3], robot.task[:2, :3] @ target


def _orientation(
    robot: Robot,
    point: str,
    orientation: Sequence[float] | None,
    axis: Sequence[float] | None,
    tool_axis: str,
) -> Orientation | None:
    if orientation is None and axis is None:
        return None
    faults = []
    name = tool_axis or ("x" if robot.is_planar else "z")
    if name not in _AXES:
        faults.append(Fault("call", "tool_axis", repr(tool_axis), "x, y, z, or one of them with - before it"))
    if orientation is not None and axis is not None:
        faults.append(Fault("call", "axis", "given with an orientation", "one of them"))
    given = np.array(orientation if axis is None else axis, dtype=float)
    count = 1 if robot.is_planar and axis is None else 3
    if given.shape != (count,) or not np.all(np.isfinite(given)) or (axis is not None and not np.any(given)):
        what = "angle" if axis is None else "component"
        allowed = f"{count} finite {what}{'s' * (count > 1)}{'' if axis is None else ', not all 0'}"
        faults.append(Fault("call", "orientation" if axis is None else "axis", str(tuple(given)), allowed))
    if faults:
        raise InvalidRequest(faults)
    if axis is None and not robot.is_planar:
        return FixedOrientation(_roll_pitch_yaw(given))
    normal = robot.task[2, 3:] if robot.is_planar else None
    first, second = robot.task[:2, :3]
    target = first * np.cos(given[0]) + second * np.sin(given[0]) if axis is None else given
    target = target / np.linalg.norm(target)
    if normal is not None:
        own = PosedRobot(robot, middle(robot.commanded)).rotation(point) @ _AXES[name]
        for key, vector in (("axis", target), ("tool_axis", own)):
            if abs(float(normal @ vector)) > 1e-9:
                found = "a direction out of the plane the chain moves in"
                faults.append(Fault("call", key, found, "one inside the plane"))
        if faults:
            raise InvalidRequest(faults)
    return aligned(_AXES[name], target, normal)


def _roll_pitch_yaw(angles: np.ndarray) -> np.ndarray:
    """Rotation about the fixed axes x, then y, then z, as a URDF writes it."""
    (a, b, c), (d, e, f) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
    about_y = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
    about_z = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)
