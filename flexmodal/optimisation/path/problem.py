"""A path problem: what is held and judged at each point, and how fast the joints may go between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.optimisation.clearance import Clearance
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objectives import Objective, ReceptanceObjective
from flexmodal.optimisation.path.toolpath import Toolpath
from flexmodal.optimisation.problem import PostureProblem

_BETWEEN = 8
"""Looks at the clearance from point to point."""

_WAYS = ("sum", "worst")


@dataclass(frozen=True, eq=False)
class PathPoint:
    """One point of the path."""

    hold: Hold
    objective: Objective
    time: float
    """When it is passed [s]."""


@dataclass(frozen=True, eq=False)
class PathProblem:
    """A posture for each point, no joint faster than it may be, with the least vibration.

    The cost is ln Σ v or ln max v over the points' values v, plus `smoothness` times the mean square of the
    joints' shares of the steps they may take. Values to be large count by their reciprocals.
    """

    robot: Robot
    points: tuple[PathPoint, ...]
    way: str = "sum"
    """"sum" or "worst"."""
    speed: Float[np.ndarray, " commanded"] | None = None
    """Most that each joint may do [rad/s, m/s]; the URDF's velocities if none."""
    smoothness: float = 1e-3
    stride: float = 0.2
    """Most that a joint may move between neighbouring points, however long it has [rad, m]: between them the
    joints go straight and the tool does not."""
    clearance: Clearance | None = None
    """What the arm keeps away from at every point; nothing is checked without it."""

    def __post_init__(self) -> None:
        faults = []
        if self.way not in _WAYS:
            faults.append(Fault("call", "way", repr(self.way), " or ".join(_WAYS)))
        if len(self.points) < 2:
            faults.append(Fault("call", "points", str(len(self.points)), "at least 2"))
        if np.any(np.diff([point.time for point in self.points]) <= 0):
            faults.append(Fault("call", "points", "times that do not increase", "times that increase"))
        if not (np.isfinite(self.stride) and self.stride > 0):
            faults.append(Fault("call", "stride", f"{self.stride}", "a finite number above 0"))
        if not (np.isfinite(self.smoothness) and self.smoothness >= 0):
            faults.append(Fault("call", "smoothness", f"{self.smoothness}", "a finite number, 0 or more"))
        if not np.all(self.speeds > 0) or self.speeds.shape != (len(self.robot.commanded),):
            found, allowed = str(self.speeds.tolist()), "a speed above 0 for each commanded joint"
            faults.append(Fault("call", "speed", found, allowed))
        if faults:
            raise InvalidRequest(faults)

    @cached_property
    def speeds(self) -> Float[np.ndarray, " commanded"]:
        """Most that each joint may do [rad/s, m/s]."""
        if self.speed is not None:
            return np.asarray(self.speed, dtype=float)
        given = np.array([joint.velocity for joint in self.robot.commanded.values()], dtype=float)
        return np.where(given > 0, given, np.inf)

    @cached_property
    def reach(self) -> Float[np.ndarray, "step commanded"]:
        """How far each joint may go between neighbouring points [rad, m]."""
        steps = np.diff([point.time for point in self.points])
        return np.minimum(np.outer(steps, self.speeds), self.stride)

    @cached_property
    def at(self) -> tuple[PostureProblem, ...]:
        """The posture problem of each point."""
        return tuple(
            PostureProblem(self.robot, point.objective, point.hold, clearance=self.clearance)
            for point in self.points
        )

    def nearest(self, postures: Float[np.ndarray, "point commanded"]) -> tuple[float, tuple[str, str]] | None:
        """What comes nearest along the sequence, between points too, and how near [m]; None if unchecked.

        Args:
            postures: one a point; between them the joints go straight, and are looked at in steps.
        """
        if self.clearance is None:
            return None
        shares = np.linspace(0, 1, _BETWEEN, endpoint=False)[:, None]
        way = [a + shares * (b - a) for a, b in pairwise(postures)]
        found = [
            self.clearance.scene.nearest(self.at[0].posed(q)) for q in np.concatenate([*way, postures[-1:]])
        ]
        return min(found)

    def values(self, postures: Float[np.ndarray, "point commanded"]) -> Float[np.ndarray, " point"]:
        """The objective at each point."""
        pairs = zip(self.at, postures, strict=True)
        return np.array([problem.objective.value(problem.posed(q)) for problem, q in pairs])

    def shares(self, postures: Float[np.ndarray, "point commanded"]) -> Float[np.ndarray, "step commanded"]:
        """Step of each joint between neighbouring points as a share of what it may go."""
        return np.abs(np.diff(postures, axis=0)) / self.reach

    def deviation(self, postures: Float[np.ndarray, "point commanded"]) -> float:
        """How far the tool is half-way between points from the middle of their targets [m]."""
        middles = (postures[:-1] + postures[1:]) / 2
        gaps = []
        for at, after, values in zip(self.at[:-1], self.at[1:], middles, strict=True):
            assert at.hold is not None
            assert after.hold is not None
            place = at.hold.rows @ at.posed(values).position(at.hold.point)
            gaps.append(np.linalg.norm(place - (at.hold.target + after.hold.target) / 2))
        return float(max(gaps))

    @classmethod
    def along(
        cls,
        robot: Robot,
        toolpath: Toolpath,
        frequency: float,
        *,
        force: tuple[float, float, float] | None = None,
        hold: Callable[[tuple[float, ...]], Hold] | None = None,
        way: str = "sum",
        speed: Float[np.ndarray, " commanded"] | None = None,
        smoothness: float = 1e-3,
        stride: float = 0.2,
        clearance: Clearance | None = None,
    ) -> PathProblem:
        """Judge each point by ‖α f‖, the tool's whole motion under the cutting force there.

        Args:
            robot: the robot.
            toolpath: positions, times, and force directions if they change.
            frequency: of the force [Hz].
            force: its direction in the world where the toolpath has none; z if left out.
            hold: what is held at a position; the position alone if left out.
            way: "sum" or "worst".
            speed: most that each joint may do [rad/s, m/s].
            smoothness: weight of the mean square share of a step.
            stride: most that a joint may move between neighbouring points [rad, m].
            clearance: what the arm keeps away from.

        Raises:
            InvalidRequest: a force across the plane of a planar chain, or bad arguments.
        """
        axes = [name for name, row in zip("xyz", np.eye(3), strict=True) if _moves(robot, row)]
        directions = tuple(PointDirection(robot.tool, axis) for axis in axes)
        pushes = toolpath.force
        if pushes is None:
            pushes = np.tile(np.array(force or (0.0, 0.0, 1.0), dtype=float), (len(toolpath.time), 1))
        points = []
        for place, time, push in zip(toolpath.position, toolpath.time, pushes, strict=True):
            weights = tuple(float(push["xyz".index(axis)]) for axis in axes)
            if not np.any(weights):
                found = f"{tuple(push.tolist())}, across the plane the chain moves in"
                raise InvalidRequest(Fault("call", "force", found, "a direction inside the plane"))
            objective = ReceptanceObjective(directions, np.array([float(frequency)]), "force", weights)
            target = tuple(place.tolist())
            held = Hold.at(robot, target) if hold is None else hold(target)
            points.append(PathPoint(held, objective, float(time)))
        return cls(robot, tuple(points), way, speed, smoothness, stride, clearance)


def _moves(robot: Robot, row: np.ndarray) -> bool:
    """Whether the chain can move along a world axis."""
    return not robot.is_planar or bool(np.any(np.abs(robot.task[:2, :3] @ row) > 1e-9))
