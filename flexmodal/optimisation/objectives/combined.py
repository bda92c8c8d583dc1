"""Several objectives as one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.optimisation.objectives.objective import SHARPNESS, Limit, Objective

_WAYS = ("product", "sum", "worst")


@dataclass(frozen=True, eq=False)
class CombinedObjective:
    """Objectives put together.

    "product" weighs the costs, so that the value is a weighted geometric mean; values to be large count by
    their reciprocals. "sum" adds weighted values and "worst" takes the largest weighted one: both need
    values of one unit, and all to be small.
    """

    parts: tuple[Objective, ...]
    weights: tuple[float, ...] = ()
    way: str = "product"
    larger_is_better: ClassVar[bool] = False

    def __post_init__(self) -> None:
        weights = np.array(self.weights or (1.0,) * len(self.parts), dtype=float)
        faults = []
        if not self.parts:
            faults.append(Fault("call", "parts", "none", "at least one objective"))
        if self.way not in _WAYS:
            faults.append(Fault("call", "way", repr(self.way), ", ".join(_WAYS)))
        if len(weights) != len(self.parts) or not np.all(np.isfinite(weights) & (weights > 0)):
            found = str(self.weights)
            faults.append(Fault("call", "weights", found, f"{len(self.parts)} finite numbers above 0"))
        if self.way != "product" and any(part.larger_is_better for part in self.parts):
            faults.append(Fault("call", "parts", "values to be large", f"values to be small in a {self.way}"))
        if self.way != "product" and len({part.unit for part in self.parts}) > 1:
            units = ", ".join(sorted({part.unit for part in self.parts}))
            faults.append(Fault("call", "parts", f"values in {units}", f"one unit in a {self.way}"))
        if faults:
            raise InvalidRequest(faults)
        total = weights.sum() if self.way == "product" else 1.0
        object.__setattr__(self, "weights", tuple((weights / total).tolist()))

    @property
    def unit(self) -> str:
        """The one unit of the parts; nothing of a product of different ones."""
        units = {part.unit for part in self.parts}
        return units.pop() if len(units) == 1 and not any(p.larger_is_better for p in self.parts) else "–"

    def value(self, posed: PosedRobot) -> float:
        """Geometric mean, sum or largest of the values."""
        values = np.array([part.value(posed) for part in self.parts])
        if self.way == "product":
            signs = np.array([-1.0 if part.larger_is_better else 1.0 for part in self.parts])
            with np.errstate(divide="ignore"):
                return float(np.exp(np.sum(self.weights * signs * np.log(values))))
        weighted = values * self.weights
        return float(weighted.sum() if self.way == "sum" else weighted.max())

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Logarithm of the (smooth) value, and its gradient."""
        found = [part.cost_and_gradient(posed) for part in self.parts]
        costs, slopes = np.array([cost for cost, _ in found]), np.array([slope for _, slope in found])
        weights = np.array(self.weights)
        if self.way == "product":
            return float(weights @ costs), weights @ slopes
        return power_sum(costs + np.log(weights), slopes, float(SHARPNESS if self.way == "worst" else 1))

    def limit(self, cost: float, robot: Robot) -> Limit:
        """A single part speaks for itself; of several, one at its limit is no reason to stop."""
        return self.parts[0].limit(cost, robot) if len(self.parts) == 1 else Limit.NONE


def power_sum(
    costs: Float[np.ndarray, " part"], slopes: Float[np.ndarray, "part joint"], power: float
) -> tuple[float, Float[np.ndarray, " joint"]]:
    """Ln (Σ e^(power·cost))^(1/power) and its gradient: a sum at power 1, nearly a maximum at a high one.

    Args:
        costs: logarithms.
        slopes: their derivatives.
        power: 1 or more.
    """
    top = float(costs.max())
    shares = np.exp(power * (costs - top))
    return top + float(np.log(shares.sum())) / power, shares / shares.sum() @ slopes
