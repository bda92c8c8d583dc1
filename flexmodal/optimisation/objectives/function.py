"""A judge given as a function of the posed robot, such as the depth of a cut."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError
from flexmodal.model import PosedRobot, Robot
from flexmodal.optimisation.objectives.objective import Limit

_STEP = 1e-5
"""Of the differences [rad, m]: with values known to 10⁻¹² or so, errors of some 10⁻⁷ of the slope."""


@dataclass(frozen=True, eq=False)
class FunctionObjective:
    """A positive number of the posed robot, to be small or large, differentiated by central differences.

    At a limit of a joint the difference is taken to the inside. Where the function has kinks, as a least of
    several numbers has, a descent may end at one that is no minimum: start from several places.
    """

    function: Callable[[PosedRobot], float]
    """0 where nothing is left to gain, or infinite where large is better."""
    unit: str = "–"
    larger_is_better: bool = False

    def value(self, posed: PosedRobot) -> float:
        """The number."""
        return float(self.function(posed))

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """± its logarithm, and differences of that; joints that follow others have none of their own."""
        cost, order = self.cost(posed), list(posed.robot.moving)
        slope = np.zeros(len(order))
        if not np.isfinite(cost):
            return cost, slope
        for name, joint in posed.robot.commanded.items():
            here = posed.posture.values[name]
            ends = (max(here - _STEP, joint.lower), min(here + _STEP, joint.upper))
            costs = [self.cost(_moved(posed, name, end)) for end in ends]
            if np.all(np.isfinite(costs)) and ends[1] > ends[0]:
                slope[order.index(name)] = (costs[1] - costs[0]) / (ends[1] - ends[0])
        return cost, slope

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Nothing is better than a cost of −∞."""
        return Limit.PERFECT if cost == -np.inf else Limit.NONE

    def cost(self, posed: PosedRobot) -> float:
        """± the logarithm of the value; infinite where there is none."""
        try:
            value = self.value(posed)
        except FlexmodalError:
            return float("inf")
        with np.errstate(divide="ignore"):
            cost = float(np.log(value)) if value >= 0 else float("nan")
        return -cost if self.larger_is_better else cost


def _moved(posed: PosedRobot, name: str, value: float) -> PosedRobot:
    return PosedRobot(posed.robot, posed.robot.posture({**posed.posture.values, name: value}))
