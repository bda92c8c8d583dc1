"""How far the poles keep from the operating frequency, or from one another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.errors import DefectiveModes, Fault, InvalidRequest
from flexmodal.model import PosedRobot, Robot
from flexmodal.optimisation.objectives.objective import SHARPNESS, Limit


@dataclass(frozen=True, eq=False)
class SeparationObjective:
    """Distance between poles in the complex plane, over 2π, to be large.

    With a frequency it is the distance from iω to the nearest pole; without one, the least distance between
    the poles of two vibrating modes. A pole moves with the posture by dλ = −λ² uᵀ dD u, its shape scaled to
    uᵀ(2λD + B)u = 1.
    """

    frequency: float | None = None
    """Operating frequency [Hz]."""
    unit: str = "Hz"
    larger_is_better: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.frequency is not None and not 0 <= self.frequency < np.inf:
            raise InvalidRequest(Fault("call", "frequency", f"{self.frequency} Hz", "finite, ≥ 0 Hz"))

    def value(self, posed: PosedRobot) -> float:
        """The least distance [Hz].

        Raises:
            InvalidRequest: a robot of one mode, and no frequency to keep away from.
        """
        modes = posed.modes()
        return float(np.min(np.abs(self._gaps(modes.pole, modes.overdamped)))) / (2 * np.pi)

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """−ln of a smooth minimum of the distances, and its gradient.

        Raises:
            DefectiveModes: critically damped poles, which no derivative exists for.
            InvalidRequest: a robot of one mode, and no frequency to keep away from.
        """
        modes = posed.modes()
        if not np.all(np.isfinite(modes.condition)):
            raise DefectiveModes("critically damped poles: they have no derivative along the posture")
        pulled = np.einsum("ip,ijk,jp->pk", modes.shape, posed.mass_derivative(), modes.shape)
        rate = self._gaps(-(modes.pole[:, None] ** 2) * pulled, modes.overdamped, change=True)
        gap = self._gaps(modes.pole, modes.overdamped)
        size = np.abs(gap) / (2 * np.pi)
        least = float(np.maximum(size.min(), np.finfo(float).tiny))
        shares = (least / np.maximum(size, least)) ** SHARPNESS
        cost = -np.log(least) + np.log(shares.sum()) / SHARPNESS
        slopes = (gap.conj()[:, None] * rate).real / np.maximum(np.abs(gap), 1e-300)[:, None] ** 2
        return float(cost), -(shares / shares.sum()) @ slopes

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Distances between poles are bounded."""
        return Limit.NONE

    def _gaps(self, poles: np.ndarray, overdamped: np.ndarray, *, change: bool = False) -> np.ndarray:
        """Differences of poles, or of their changes."""
        if self.frequency is not None:
            return poles if change else poles - 2j * np.pi * self.frequency
        vibrating = poles[~overdamped]
        if len(vibrating) < 2:
            found = f"{len(vibrating)} vibrating mode{'s' * (len(vibrating) != 1)}"
            raise InvalidRequest(Fault("call", "objective", found, "two, or a frequency to keep away from"))
        first, second = np.triu_indices(len(vibrating), 1)
        return np.asarray(vibrating[first] - vibrating[second])
