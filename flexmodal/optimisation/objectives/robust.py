"""A posture that is good although stiffness and damping are known only so well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.cards import FrozenDict
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.optimisation.objectives.combined import power_sum
from flexmodal.optimisation.objectives.objective import SHARPNESS, Limit, Objective

_JUDGED = ("expected", "worst")

PerJoint = float | Mapping[str, float]
"""One relative standard deviation for every joint, or one for each joint named."""


@dataclass(frozen=True, eq=False)
class RobustObjective:
    """An objective over a sample of robots that the real one might be.

    "expected" takes the mean over the sample, of a value to be large the harmonic mean; "worst" takes the
    worst.
    """

    objective: Objective
    robots: tuple[Robot, ...]
    judge: str = "expected"

    def __post_init__(self) -> None:
        faults = []
        if not self.robots:
            faults.append(Fault("call", "robots", "none", "at least one sample"))
        if self.judge not in _JUDGED:
            faults.append(Fault("call", "judge", repr(self.judge), " or ".join(_JUDGED)))
        if len({(tuple(robot.commanded), tuple(robot.moving)) for robot in self.robots}) > 1:
            faults.append(Fault("call", "robots", "samples with different joints", "the same joints in all"))
        if faults:
            raise InvalidRequest(faults)

    @property
    def larger_is_better(self) -> bool:
        """As of the objective itself."""
        return self.objective.larger_is_better

    @property
    def unit(self) -> str:
        """As of the objective itself."""
        return self.objective.unit

    def values(self, posed: PosedRobot) -> Float[np.ndarray, " sample"]:
        """The objective of each sample at the posture."""
        return np.array([self.objective.value(PosedRobot(robot, posed.posture)) for robot in self.robots])

    def value(self, posed: PosedRobot) -> float:
        """Mean (harmonic where large is better) or worst of the sample."""
        values = self.values(posed)
        if self.judge == "worst":
            return float(values.min() if self.larger_is_better else values.max())
        return float(1 / np.mean(1 / values) if self.larger_is_better else values.mean())

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Logarithm of the mean or of the smooth maximum, and its gradient."""
        found = [self.objective.cost_and_gradient(PosedRobot(robot, posed.posture)) for robot in self.robots]
        costs, slopes = np.array([cost for cost, _ in found]), np.array([slope for _, slope in found])
        power = 1.0 if self.judge == "expected" else float(SHARPNESS)
        cost, slope = power_sum(costs, slopes, power)
        return cost - np.log(len(costs)) / power, slope

    def limit(self, cost: float, robot: Robot) -> Limit:
        """As of the objective itself."""
        return self.objective.limit(cost, robot)


def sample_robots(
    robot: Robot,
    count: int,
    *,
    stiffness: PerJoint = 0.1,
    damping: PerJoint = 0.3,
    seed: int = 0,
) -> tuple[Robot, ...]:
    """Robots that differ from one by log-normal factors on each joint's stiffness and damping.

    Args:
        robot: the median of the sample.
        count: how many.
        stiffness: relative standard deviation of the stiffness (of its logarithm).
        damping: the same of the damping.
        seed: the same seed gives the same sample.

    Raises:
        InvalidRequest: a count below 1, deviations that are negative or not finite, or unknown joints.
    """
    names = tuple(robot.joints)
    faults = [] if count >= 1 else [Fault("call", "count", str(count), "at least 1")]
    spread = []
    for key, given in (("stiffness", stiffness), ("damping", damping)):
        each = given if isinstance(given, Mapping) else dict.fromkeys(names, given)
        unknown = [name for name in each if name not in names]
        faults += [Fault("call", key, f"joint {name!r}", ", ".join(names)) for name in unknown]
        values = np.array([each.get(name, 0.0) for name in names], dtype=float)
        if not np.all((values >= 0) & (values <= 3)):
            faults.append(Fault("call", key, str(given), "relative deviations from 0 to 3"))
        spread.append(values)
    if faults:
        raise InvalidRequest(faults)
    draws = np.random.default_rng(seed).normal(size=(count, 2, len(names)))
    factors = np.exp(draws * np.array(spread))
    return tuple(_varied(robot, dict(zip(names, zip(*both, strict=True), strict=True))) for both in factors)


def _varied(robot: Robot, factors: Mapping[str, tuple[float, float]]) -> Robot:
    joints = {
        name: replace(
            joint,
            stiffness=joint.stiffness * float(factors[name][0]),
            damping=joint.damping * float(factors[name][1]),
        )
        for name, joint in robot.joints.items()
    }
    return replace(robot, joints=FrozenDict(joints))
