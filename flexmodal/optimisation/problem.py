"""A posture problem: what is judged, what is held, which joints are free and how far."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.cards import FrozenDict
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal.optimisation.function import FunctionObjective
from flexmodal.optimisation.hold import TOLERANCE, Hold
from flexmodal.optimisation.objective import Objective

_TURN = np.pi
"""Continuous joints, and limits wider than a turn, are sampled over one turn [rad]."""


@dataclass(frozen=True, eq=False)
class PostureProblem:
    """Minimise the objective's cost over the commanded joints, within limits, the hold kept.

    Vectors are in the order of `robot.commanded` [rad, m].
    """

    robot: Robot
    objective: Objective
    hold: Hold | None = None
    limits: tuple[np.ndarray, np.ndarray] | None = None
    """Lower and upper limits that stand in for those of the joints, such as narrower ones [rad, m]."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The commanded joints."""
        return tuple(self.robot.commanded)

    @cached_property
    def columns(self) -> np.ndarray:
        """Where the commanded joints stand among the moving ones."""
        order = list(self.robot.moving)
        return np.array([order.index(name) for name in self.names])

    @cached_property
    def lower(self) -> Float[np.ndarray, " commanded"]:
        """Lower limits; −∞ for continuous joints."""
        if self.limits is not None:
            return self.limits[0]
        return np.array([joint.lower for joint in self.robot.commanded.values()])

    @cached_property
    def upper(self) -> Float[np.ndarray, " commanded"]:
        """Upper limits; ∞ for continuous joints."""
        if self.limits is not None:
            return self.limits[1]
        return np.array([joint.upper for joint in self.robot.commanded.values()])

    def posture(self, values: Float[np.ndarray, " commanded"]) -> Posture:
        """A posture from a vector."""
        return Posture(FrozenDict(dict(zip(self.names, values.tolist(), strict=True))))

    def vector(self, posture: Posture) -> Float[np.ndarray, " commanded"]:
        """A vector from a posture."""
        return np.array([posture.values[name] for name in self.names])

    def posed(self, values: Float[np.ndarray, " commanded"]) -> PosedRobot:
        """The robot at a vector; within the limits by construction."""
        return _pose(self, values.tobytes())

    def cost_and_gradient(
        self, values: Float[np.ndarray, " commanded"]
    ) -> tuple[float, Float[np.ndarray, " commanded"]]:
        """The objective's cost and its gradient along the commanded joints."""
        cost, gradient = self.objective.cost_and_gradient(self.posed(values))
        return cost, gradient[self.columns]

    def cost(self, values: Float[np.ndarray, " commanded"]) -> float:
        """The cost alone; where the gradient is one of differences, that is a small part of the work."""
        if isinstance(self.objective, FunctionObjective):
            return self.objective.cost(self.posed(values))
        return self.cost_and_gradient(values)[0]

    def if_below(
        self, values: Float[np.ndarray, " commanded"], bound: float
    ) -> tuple[float, Float[np.ndarray, " commanded"]] | None:
        """Cost and gradient if the cost is at most `bound`; differences are not taken in vain."""
        if isinstance(self.objective, FunctionObjective) and not self.cost(values) <= bound:
            return None
        cost, gradient = self.cost_and_gradient(values)
        return (cost, gradient) if cost <= bound else None

    def held(self, values: Float[np.ndarray, " commanded"]) -> tuple[np.ndarray, np.ndarray]:
        """Error of the hold and its Jacobian; without a hold, empty ones."""
        if self.hold is None:
            return np.zeros(0), np.zeros((0, len(self.names)))
        posed = self.posed(values)
        return self.hold.error(posed), self.hold.jacobian(posed)[:, self.columns]

    def retract(self, values: Float[np.ndarray, " commanded"], *, steps: int = 60) -> np.ndarray | None:
        """Bring a vector back onto the hold by Newton steps inside the limits; None if it cannot.

        Joints at a limit stay there if the others can do it.
        """
        values = np.clip(values, self.lower, self.upper)
        if self.hold is None:
            return values
        inside = (values > self.lower) & (values < self.upper)
        found = None if np.all(inside) else self._newton(values, inside, steps)
        return self._newton(values, np.ones(len(values), dtype=bool), steps) if found is None else found

    def _newton(self, values: np.ndarray, allowed: np.ndarray, steps: int) -> np.ndarray | None:
        """Newton steps with the joints allowed to move; one that meets its limit sits the next step out."""
        free = allowed
        for _ in range(steps):
            error, jacobian = self.held(values)
            if np.linalg.norm(error) <= TOLERANCE:
                return values
            step = np.zeros(len(values))
            step[free] = np.linalg.lstsq(jacobian[:, free], -error, rcond=1e-9)[0]  # the shortest there is
            longest = np.max(np.abs(step))
            if longest < 1e-14:
                return None
            wanted = values + step * min(1.0, 0.7 / longest)
            values = np.clip(wanted, self.lower, self.upper)
            inward = values == wanted
            free = allowed if np.all(inward) else free & inward
        return None

    def random_vector(self, generator: np.random.Generator) -> Float[np.ndarray, " commanded"]:
        """A vector drawn evenly between the limits, over one turn at most, not on the hold yet."""
        wide = self.upper - self.lower > 2 * _TURN
        middle = np.where(wide, np.clip(0.0, self.lower + _TURN, self.upper - _TURN), 0.0)
        low = np.where(wide, middle - _TURN, self.lower)
        high = np.where(wide, middle + _TURN, self.upper)
        return generator.uniform(low, high)


@lru_cache(maxsize=8)
def _pose(problem: PostureProblem, values: bytes) -> PosedRobot:
    """Poses the robot, and remembers the last few: a search asks for error, cost and Jacobian in turn."""
    return PosedRobot(problem.robot, problem.posture(np.frombuffer(values)))
