"""Holding the end-effector where it is wanted while the arm moves through its redundancy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.posture import middle

_FARTHEST = 1e6
"""No arm reaches farther [m]."""

TOLERANCE = 1e-10
"""How near the held point is kept to its target [m]."""


@dataclass(frozen=True, eq=False)
class Hold:
    """A point held at a target: two coordinates in the plane of a planar chain, three in space."""

    point: str
    rows: Float[np.ndarray, "held 3"]
    """Unit vectors along which the position is held."""
    target: Float[np.ndarray, " held"]
    """Coordinates along them [m]."""

    @classmethod
    def at(cls, robot: Robot, target: tuple[float, ...], point: str | None = None) -> Hold:
        """Hold the tool (or another point) at a position.

        Args:
            robot: whose point.
            target: two in-plane coordinates of a planar chain, such as (x, z), or three in space [m].
            point: a named point or link; the tool if none.

        Raises:
            InvalidRequest: the wrong number of coordinates, or not finite.
            InvalidPoint: no such point.
        """
        point = point or robot.tool
        robot.frame_of(point)
        values = np.array(target, dtype=float)
        if not np.all(np.abs(values) <= _FARTHEST):
            allowed = f"finite coordinates [m], none beyond {_FARTHEST:g}"
            raise InvalidRequest(Fault("call", "hold", str(tuple(target)), allowed))
        if robot.is_planar and len(values) == 2:
            return cls(point, robot.task[:2, :3], values)
        if robot.is_planar and len(values) == 3:
            return _inside_plane(robot, point, values)
        if not robot.is_planar and len(values) == 3:
            return cls(point, np.eye(3), values)
        allowed = "2 or 3 coordinates (planar chain)" if robot.is_planar else "3 coordinates (spatial chain)"
        raise InvalidRequest(Fault("call", "hold", f"{len(values)} coordinates", allowed))

    def error(self, posed: PosedRobot) -> Float[np.ndarray, " held"]:
        """How far the point is from its target [m]."""
        return self.rows @ posed.position(self.point) - self.target

    def jacobian(self, posed: PosedRobot) -> Float[np.ndarray, "held moving"]:
        """Derivative of `error` along every moving joint."""
        return self.rows @ posed.full_jacobian(self.point)[:3]


def _inside_plane(robot: Robot, point: str, target: np.ndarray) -> Hold:
    """Three coordinates for a planar chain: the third must be where the plane lies."""
    normal = robot.task[2, 3:]
    plane = float(normal @ PosedRobot(robot, middle(robot.commanded)).position(point))
    if abs(float(normal @ target) - plane) > 1e-9:
        found = f"a target {float(normal @ target) - plane:.6g} m out of the plane the chain moves in"
        raise InvalidRequest(Fault("call", "hold", found, f"{plane:.6g} m along the plane's normal"))
    return Hold(point, robot.task[:2, :3], robot.task[:2, :3] @ target)
