"""How near an arm comes to itself and to what stands around it, with the derivative along every joint.

Between two bodies with the nearest points p₁ and p₂ and the unit vector n from the first to the second,

    d = n · (p₂ − p₁),    ∂d/∂q = nᵀ (J₂(p₂) − J₁(p₁)),

negative where they overlap: moving the nearest points along their surfaces changes d by nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidCard
from flexmodal.model.build import pinocchio
from flexmodal.model.collision.shapes import add_obstacle, shapes_of
from flexmodal.model.posed import PosedRobot
from flexmodal.model.robot import Robot

_SAMPLES = 96
"""Random postures by which pairs are told that always touch."""

_TOLERANCE = 1e-9
"""Of distances [m]."""

_MOSTLY = 0.95
"""Share of them from which a pair counts as touching by its build, as the assistant of MoveIt has it."""


@dataclass(frozen=True, eq=False)
class Nearness:
    """The pairs of shapes that are nearer to each other than a distance."""

    distance: Float[np.ndarray, " pair"]
    """[m], negative where they overlap."""
    gradient: Float[np.ndarray, "pair moving"]
    """Along every moving joint [m/rad, m/m]."""
    names: tuple[tuple[str, str], ...]


@dataclass(frozen=True, eq=False)
class Scene:
    """Shapes on the links and around the arm, and which pairs of them are watched."""

    robot: Robot
    pairs: tuple[tuple[str, str], ...]
    """What is watched."""
    left_out: tuple[tuple[str, str], ...]
    """Pairs that are as near by the build of the arm, or stand on each other, in nearly every posture."""
    obstacles: tuple[str, ...]
    _shapes: Any
    """Pinocchio's geometry model."""
    _places: Any
    """Its scratch: one search at a time."""

    def distances(self, posed: PosedRobot) -> Float[np.ndarray, " pair"]:
        """Distance of every watched pair [m], in the order of `pairs`."""
        pin = pinocchio()
        data, configuration = posed._data
        pin.updateGeometryPlacements(self.robot.pinocchio, data, self._shapes, self._places, configuration)
        pin.computeDistances(self._shapes, self._places)
        return np.array([result.min_distance for result in self._places.distanceResults])

    def nearest(self, posed: PosedRobot) -> tuple[float, tuple[str, str]]:
        """The smallest distance [m], and between what."""
        found = self.distances(posed)
        place = int(np.argmin(found))
        return float(found[place]), self.pairs[place]

    def within(self, posed: PosedRobot, reach: float) -> Nearness:
        """The pairs nearer to each other than `reach`, with derivatives.

        Args:
            posed: the robot in its posture.
            reach: [m].
        """
        found = self.distances(posed)
        near = np.flatnonzero(found < reach)
        names = tuple(self.pairs[int(place)] for place in near)
        return Nearness(found[near], self._slopes(posed, near), names)

    def _slopes(self, posed: PosedRobot, near: np.ndarray) -> Float[np.ndarray, "pair moving"]:
        """Derivatives of some pairs' distances: Jᵀ of a unit force along n at each end.

        In Jacobians about the world's origin a force f at p is the wrench (f, p × f).
        """
        places, pairs, carried = self._places.distanceResults, self._shapes.collisionPairs, self._carried
        turning = np.array(posed._data[0].J)
        answer = np.empty((len(near), turning.shape[1]))
        for row, place in enumerate(near.tolist()):
            result, pair = places[place], pairs[place]
            force = result.normal.ravel()
            push = force @ turning[:3]
            ends = (result.getNearestPoint1(), pair.first), (result.getNearestPoint2(), pair.second)
            first, second = (
                (push + _cross(point.ravel(), force) @ turning[3:]) * carried[shape] for point, shape in ends
            )
            answer[row] = second - first
        return answer

    @cached_property
    def _carried(self) -> list[np.ndarray]:
        """For each shape, which of the moving joints carry it."""
        model = self.robot.pinocchio
        found = []
        for shape in self._shapes.geometryObjects:
            mask, joint = np.zeros(model.nv), shape.parentJoint
            while joint > 0:
                mask[model.joints[joint].idx_v] = 1.0
                joint = model.parents[joint]
            found.append(mask)
        return found


def _cross(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    (a, b, c), (x, y, z) = left, right
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def scene_of(robot: Robot, *, near: float = 0.0) -> Scene | None:
    """The scene of a robot: shapes of its URDF, obstacles of its card; None without a pair to watch.

    Pairs that the SRDF of the card disables are not watched, nor neighbours along the chain, nor pairs that
    touch, or are as near as a distance, in nearly every posture: the arm is built so.

    Args:
        robot: as it was loaded.
        near: that distance [m].

    Raises:
        InvalidUrdf: collision meshes that are missing or cannot be read.
        InvalidCard: meshes of obstacles, or an SRDF, that cannot be read.
    """
    model = robot.pinocchio
    shapes = shapes_of(robot.urdf, model)
    where = robot.urdf.path if robot.path is None else robot.path
    for name, obstacle in robot.obstacles.items():
        add_obstacle(shapes, model, name, obstacle, robot.urdf.root, where)
    shapes.addAllCollisionPairs()
    for pair in list(shapes.collisionPairs):
        if _is_neighbourly(model, shapes, pair):
            shapes.removeCollisionPair(pair)
    if robot.srdf is not None:
        _disable(model, shapes, robot.srdf, where)
    if len(shapes.collisionPairs) == 0:
        return None
    touching = _touching(robot, shapes, near)
    dropped = [shapes.collisionPairs[place] for place in touching]
    left_out = tuple(_names(model, shapes, pair) for pair in dropped)
    for pair in dropped:
        shapes.removeCollisionPair(pair)
    if len(shapes.collisionPairs) == 0:
        return None
    watched = tuple(_names(model, shapes, pair) for pair in shapes.collisionPairs)
    return Scene(robot, watched, left_out, tuple(robot.obstacles), shapes, _places(shapes))


def _places(shapes: Any) -> Any:
    """Scratch for distances that are exact enough to be differentiated."""
    places = pinocchio().GeometryData(shapes)
    for request in places.distanceRequests:
        request.gjk_tolerance, request.epa_tolerance = _TOLERANCE, _TOLERANCE
    return places


def _is_neighbourly(model: Any, shapes: Any, pair: Any) -> bool:
    """Whether two shapes are on one body, or on links that a joint connects; obstacles have no neighbours."""
    first, second = (shapes.geometryObjects[number] for number in (pair.first, pair.second))
    one, other = first.parentJoint, second.parentJoint
    if one == other:
        return True
    if any(shape.name.startswith("obstacle ") and shape.parentJoint == 0 for shape in (first, second)):
        return False
    return bool(model.parents[one] == other or model.parents[other] == one)


def _touching(robot: Robot, shapes: Any, near: float) -> list[int]:
    """Pairs that overlap, or are as near, in nearly every posture."""
    pin, model = pinocchio(), robot.pinocchio
    data, places = model.createData(), pin.GeometryData(shapes)
    generator = np.random.default_rng(0)
    low = np.array([max(joint.lower, -np.pi) for joint in robot.moving.values()])
    high = np.array([min(joint.upper, np.pi) for joint in robot.moving.values()])
    pseudo = np.array([name in robot.pseudo_joints for name in robot.moving])
    hits = np.zeros(len(shapes.collisionPairs))
    for _ in range(_SAMPLES):
        values = np.where(pseudo, 0.0, generator.uniform(np.minimum(low, high), np.maximum(low, high)))
        pin.computeDistances(model, data, shapes, places, pin.integrate(model, pin.neutral(model), values))
        hits += np.array([result.min_distance <= near for result in places.distanceResults])
    return np.flatnonzero(hits >= _MOSTLY * _SAMPLES).tolist()


def _disable(model: Any, shapes: Any, srdf: Path, card: Path) -> None:
    try:
        pinocchio().removeCollisionPairs(model, shapes, str(srdf))
    except (ValueError, RuntimeError) as error:
        raise InvalidCard(Fault(str(card), "srdf", str(error), "an SRDF that Pinocchio can read")) from None


def _names(model: Any, shapes: Any, pair: Any) -> tuple[str, str]:
    """The obstacle, or the link, of each shape."""

    def name(number: int) -> str:
        shape = shapes.geometryObjects[number]
        if shape.name.startswith("obstacle "):
            return str(shape.name.removeprefix("obstacle "))
        return str(model.frames[shape.parentFrame].name)

    return name(pair.first), name(pair.second)
