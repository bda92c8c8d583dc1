"""Keeping away from obstacles: a barrier in the cost, with its gradient, that no iterate can pass.

With the distance d of a pair of shapes, the clearance c and the reach r of the barrier, x = (d − c)/r and

    b(x) = −(1 − x)² ln x    for 0 < x < 1,    0 beyond,

is smooth, and infinite at the clearance (Li et al. 2020, Incremental potential contact). A descent that
starts clear stays clear, whatever the weight; the smaller the weight, the nearer it comes to the constrained
optimum.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InCollision, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.collision import Scene, scene_of
from flexmodal.optimisation.objectives import Limit
from flexmodal.text.shown import Shown, several

DISTANCE = 0.01
"""Clearance if nobody says [m]."""

_MOST = 10.0


@dataclass(frozen=True, eq=False, repr=False)
class Clearance(Shown):
    """A distance that every watched pair of shapes is to keep."""

    scene: Scene
    distance: float = DISTANCE
    """[m]."""
    reach: float = 0.05
    """How far beyond the distance the barrier begins [m]."""
    weight: float = 1e-4
    """Of the barrier beside the logarithm of the objective."""

    def __post_init__(self) -> None:
        for key, value in (("distance", self.distance), ("reach", self.reach), ("weight", self.weight)):
            least = 0.0 if key == "distance" else 1e-12
            if not least <= value <= _MOST:
                allowed = f"a number from {least:g} to {_MOST:g}"
                raise InvalidRequest(Fault("call", f"clearance {key}", f"{value}", allowed))

    @classmethod
    def of(cls, robot: Robot, distance: float = DISTANCE) -> Clearance:
        """The clearance of a robot's own shapes and of the obstacles of its card.

        Args:
            robot: with collision shapes in its URDF.
            distance: to keep [m].

        Raises:
            InvalidRequest: there is nothing to keep away from.
            InvalidUrdf: a mesh that is missing or cannot be read.
        """
        scene = scene_of(robot, near=distance)
        if scene is None:
            allowed = "<collision> shapes in the URDF and [obstacle.NAME] in the card: docs/collisions.md"
            raise InvalidRequest(Fault(robot.name, "clearance", "no two shapes that could meet", allowed))
        return cls(scene, distance)

    def _facts(self) -> Mapping[str, object]:
        return {
            "": f"{1e3 * self.distance:g} mm",
            "obstacles": several(self.scene.obstacles) or "none",
            "pairs watched": len(self.scene.pairs),
        }

    def is_clear(self, posed: PosedRobot) -> bool:
        """Whether every pair keeps the distance."""
        return self.scene.nearest(posed)[0] >= self.distance

    def barrier(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """What is added to the cost, and its gradient along every moving joint; 0 where all is far away.

        Raises:
            InCollision: some pair is nearer than the distance.
        """
        near = self.scene.within(posed, self.distance + self.reach)
        share = (near.distance - self.distance) / self.reach
        if len(share) == 0:
            return 0.0, np.zeros(near.gradient.shape[1])
        worst = int(np.argmin(share))
        if share[worst] <= 0:
            one, other = near.names[worst]
            raise InCollision(
                f"{one} and {other} are {1e3 * near.distance[worst]:.3g} mm apart; "
                f"{1e3 * self.distance:g} mm are to be kept"
            )
        logarithm = np.log(share)
        slope = 2 * (1 - share) * logarithm - (1 - share) ** 2 / share
        value = float(np.sum(-((1 - share) ** 2) * logarithm))
        return self.weight * value, self.weight / self.reach * (slope @ near.gradient)


@dataclass(frozen=True, eq=False)
class Apart:
    """An objective that only moves shapes away from each other: 1 where all is clear, more else."""

    clearance: Clearance
    spare: float
    """Share of the barrier's reach to be kept besides."""
    larger_is_better: bool = False
    unit: str = ""

    def value(self, posed: PosedRobot) -> float:
        """The exponential of the cost."""
        return float(np.exp(self.cost_and_gradient(posed)[0]))

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Half the sum of the squares of what is missing [1/reach²]."""
        wanted = self.clearance.distance + self.spare * self.clearance.reach
        near = self.clearance.scene.within(posed, wanted)
        missing = (wanted - near.distance) / self.clearance.reach
        return 0.5 * float(missing @ missing), -(missing @ near.gradient) / self.clearance.reach

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Perfect where nothing is missing."""
        return Limit.PERFECT if cost <= 0.0 else Limit.NONE
