"""A posture problem: what is judged, what is held, which joints are free and how far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeGuard

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.cards import FrozenDict
from flexmodal.errors import FlexmodalError
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal.model.receptance_source import ModelReceptances
from flexmodal.optimisation.clearance import Clearance
from flexmodal.optimisation.descent import PERFECT, UNBOUNDED, UNSETTLED, Box, retract, work_for
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objectives import FunctionObjective, Limit, Objective, ReceptanceObjective
from flexmodal.text.shown import Shown

_TURN = np.pi
"""Continuous joints, and limits wider than a turn, are sampled over one turn [rad]."""


@dataclass(frozen=True, eq=False, repr=False)
class PostureProblem(Shown):
    """Minimise the objective's cost over the commanded joints, within limits, the hold kept.

    Vectors are in the order of `robot.commanded` [rad, m].

    >>> import flexmodal
    >>> robot = flexmodal.load("six_link")
    >>> judge = flexmodal.ReceptanceObjective("tool:+z", 5.0)
    >>> hold = flexmodal.Hold.at(robot, (-2.0, 2.0))
    >>> problem = flexmodal.PostureProblem(robot, judge, hold)
    >>> found = flexmodal.optimise(problem, start="start_2", starts=4, way="plain")
    >>> found.best.objective < found.start
    True
    """

    robot: Robot
    objective: Objective
    hold: Hold | None = None
    limits: tuple[np.ndarray, np.ndarray] | None = None
    """Lower and upper limits that stand in for those of the joints, such as narrower ones [rad, m]."""
    clearance: Clearance | None = None
    """What the arm keeps away from; nothing is checked without it."""

    def _facts(self) -> Mapping[str, object]:
        hold = self.hold
        return {
            "": self.robot.name,
            "objective": f"{type(self.objective).__name__} [{self.objective.unit}]",
            "hold": "none" if hold is None else f"{hold.point} at {np.round(hold.target, 4)} m",
        }

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

    @cached_property
    def box(self) -> Box:
        """Lower and upper limits."""
        return Box(self.lower, self.upper)

    @cached_property
    def turning(self) -> Bool[np.ndarray, " commanded"]:
        """Whether a commanded joint turns: whole turns are the same posture then."""
        return np.array([not joint.is_prismatic for joint in self.robot.commanded.values()])

    def is_clear(self, values: Float[np.ndarray, " commanded"]) -> bool:
        """Whether the clearance is kept; always without one."""
        return self.clearance is None or self.clearance.is_clear(self.posed(values))

    @property
    def held_components(self) -> int:
        """How many components the hold's error has."""
        return 0 if self.hold is None else self.hold.components

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
        """The objective's cost, with the clearance's barrier, and its gradient along the commanded joints.

        Raises:
            InCollision: the clearance is not kept there.
        """
        posed = self.posed(values)
        if self.clearance is None:
            cost, gradient = self.objective.cost_and_gradient(posed)
            return cost, gradient[self.columns]
        barrier, away = self.clearance.barrier(posed)
        cost, gradient = self.objective.cost_and_gradient(posed)
        return cost + barrier, (gradient + away)[self.columns]

    def cost(self, values: Float[np.ndarray, " commanded"]) -> float:
        """The cost alone; where the gradient is one of differences, that is a small part of the work."""
        if _is_differenced(self.objective):
            posed = self.posed(values)
            barrier = 0.0 if self.clearance is None else self.clearance.barrier(posed)[0]
            return barrier + self.objective.cost(posed)
        return self.cost_and_gradient(values)[0]

    def held(self, values: Float[np.ndarray, " commanded"]) -> tuple[np.ndarray, np.ndarray]:
        """Error of the hold and its Jacobian; without a hold, empty ones."""
        if self.hold is None:
            return np.zeros(0), np.zeros((0, len(self.names)))
        posed = self.posed(values)
        return self.hold.error(posed), self.hold.jacobian(posed)[:, self.columns]

    def retract(self, values: Float[np.ndarray, " commanded"], *, steps: int = 60) -> np.ndarray | None:
        """Bring a vector back onto the hold by Newton steps inside the limits; None if it cannot.

        Joints at a limit stay there if the others can do it.

        Args:
            values: from where [rad, m].
            steps: most steps, and as many again with all joints.
        """
        here, work = np.array(values, dtype=float), work_for(self.held_components, len(self.names))
        return here if retract(Evaluation(self), self.box, here, steps, work, work.constraint) else None

    def random_vector(self, generator: np.random.Generator) -> Float[np.ndarray, " commanded"]:
        """A vector drawn evenly between the limits, over one turn at most, not on the hold yet."""
        wide = self.upper - self.lower > 2 * _TURN
        middle = np.where(wide, np.clip(0.0, self.lower + _TURN, self.upper - _TURN), 0.0)
        low = np.where(wide, middle - _TURN, self.lower)
        high = np.where(wide, middle + _TURN, self.upper)
        return generator.uniform(low, high)


class Evaluation:
    """A problem at one vector after another, as `flexmodal.optimisation.descent` asks for it."""

    def __init__(self, problem: PostureProblem) -> None:
        self.problem = problem
        self.trouble: FlexmodalError | None = None
        """Why there was no cost where there was none last."""
        self._values = problem.lower
        self._gradient: np.ndarray | None = None

    def hold_at(self, values: np.ndarray, error: np.ndarray, constraint: np.ndarray) -> float:
        """Go to a vector; the size of the hold's error, which with its derivative is filled in.

        Args:
            values: of the commanded joints [rad, m].
            error: receives what is off target [m, rad].
            constraint: receives its derivative; held × commanded.
        """
        self._values = values.copy()
        error[:], constraint[:] = self.problem.held(self._values)
        return float(np.linalg.norm(error))

    def cost_at(self) -> float:
        """The cost there; infinite where there is none. Differences for a gradient are not taken yet."""
        self._gradient = None
        try:
            if _is_differenced(self.problem.objective):
                return self.problem.cost(self._values)
            cost, self._gradient = self.problem.cost_and_gradient(self._values)
        except FlexmodalError as error:
            self.trouble = error
            return float("inf")
        return cost

    def slope_at(self, gradient: np.ndarray) -> None:
        """Fill in the derivative of the cost taken last."""
        known = self._gradient
        gradient[:] = self.problem.cost_and_gradient(self._values)[1] if known is None else known

    def limit_at(self, cost: float) -> int:
        """PERFECT or UNBOUNDED where a cost says so, else UNSETTLED."""
        limit = self.problem.objective.limit(cost, self.problem.robot)
        return {Limit.PERFECT: PERFECT, Limit.UNBOUNDED: UNBOUNDED}.get(limit, UNSETTLED)


def _is_differenced(objective: Objective) -> TypeGuard[FunctionObjective | ReceptanceObjective]:
    """Whether its gradient is one of differences, many times the work of its cost."""
    if isinstance(objective, ReceptanceObjective):
        return not isinstance(objective.source, ModelReceptances)
    return isinstance(objective, FunctionObjective)


@lru_cache(maxsize=8)
def _pose(problem: PostureProblem, values: bytes) -> PosedRobot:
    """Poses the robot, and remembers the last few: a search asks for error, cost and Jacobian in turn."""
    return PosedRobot(problem.robot, problem.posture(np.frombuffer(values)))
