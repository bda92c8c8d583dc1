"""The measures of the thesis without a frequency, as objectives: stiffness [3.17] and mobility [3.18]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.gradient import jacobian_derivative
from flexmodal.model.measures import measure, reduced_task
from flexmodal.optimisation.objectives.objective import Limit, OneGiven

LEVER = 1e-3
"""A lever arm below this [m] counts as none."""


@dataclass(frozen=True, eq=False)
class StiffnessObjective:
    """The stiffness measure ξ_K = uᵀ J⁺ᵀ K J⁺ u [Hearne 3.17], to be large."""

    direction: OneGiven
    task: str = "full"
    unit: str = "N/m"
    larger_is_better: ClassVar[bool] = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", PointDirection.parse(self.direction))

    def value(self, posed: PosedRobot) -> float:
        """ξ_K [N/m]."""
        return measure(posed, self.direction, task=self.task).stiffness

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """−ln ξ_K, and its gradient by the derivative of the Moore–Penrose inverse at constant rank.

        dJ⁺ = −J⁺ dJ J⁺ + J⁺J⁺ᵀ dJᵀ (1 − JJ⁺) + (1 − J⁺J) dJᵀ J⁺ᵀJ⁺ (Golub and Pereyra 1973).

        Raises:
            InvalidRequest: the chain cannot move along the direction.
        """
        rows = reduced_task(posed, self.task)
        pick = posed.robot.flexible_index
        full = posed.full_jacobian(self.direction.point)
        jacobian = rows @ full[:, pick]
        slope = np.einsum("tr,rik->tik", rows, jacobian_derivative(full)[:, pick, :])
        along = rows @ self.direction.selector
        if not np.any(along):
            found = f"{self.direction}, along which nothing moves under task {self.task!r}"
            raise InvalidRequest(Fault("call", "direction", found, "a direction the chain can move along"))
        inverse = np.linalg.pinv(jacobian)
        deflection = inverse @ along
        missed = along - jacobian @ deflection
        pulled = inverse.T @ deflection
        change = (
            -inverse @ np.einsum("tik,i->tk", slope, deflection)
            + inverse @ (inverse.T @ np.einsum("tik,t->ik", slope, missed))
            + (np.eye(len(pick)) - inverse @ jacobian) @ np.einsum("tik,t->ik", slope, pulled)
        )
        moment = posed.robot.stiffness @ deflection
        value = float(deflection @ moment)
        return -float(np.log(value)), -2 * (moment @ change) / value

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Where J is singular ξ_K is infinite: constraint, not springs, resists the motion.

        Taken as reached when the stiffest joint would resist with a lever arm below a millimetre.
        """
        return Limit.UNBOUNDED if -cost > np.log(np.max(robot.stiffness) / LEVER**2) else Limit.NONE


@dataclass(frozen=True, eq=False)
class MobilityObjective:
    """The mobility measure ξ_M = uᵀ J Jᵀ u [Hearne 3.18], to be small."""

    direction: OneGiven
    unit: str = "m²/rad²"
    larger_is_better: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", PointDirection.parse(self.direction))

    def value(self, posed: PosedRobot) -> float:
        """ξ_M [m²/rad²]."""
        return measure(posed, self.direction).mobility

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Ln ξ_M and its gradient."""
        pick = posed.robot.flexible_index
        full = posed.full_jacobian(self.direction.point)
        row = (self.direction.selector @ full)[pick]
        slope = np.tensordot(self.direction.selector, jacobian_derivative(full), 1)[pick]
        value = float(row @ row) + np.finfo(float).tiny
        return float(np.log(value)), 2 * (row @ slope) / value

    def limit(self, cost: float, robot: Robot) -> Limit:
        """No joint moves the point along the direction."""
        return Limit.PERFECT if cost < 2 * np.log(LEVER**2) else Limit.NONE
