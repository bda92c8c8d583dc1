"""Posture and frequency together: each posture judged at the frequency of a band that suits it best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot, Robot
from flexmodal.optimisation.frequency.tune import Band, tune
from flexmodal.optimisation.objectives.objective import Limit, OneGiven, ReceptanceObjective


@dataclass(frozen=True, eq=False)
class TunedObjective:
    """The least |receptance| within a band, to be small; both posture and frequency are free.

    The gradient is that of the receptance at the best frequency held fixed: there the slope along the
    frequency is 0, or the frequency sits at an end of the band.
    """

    direction: OneGiven
    band: Band
    """[Hz]."""
    larger_is_better: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", PointDirection.parse(self.direction))
        if not 0 <= self.band[0] < self.band[1]:
            found = f"{self.band[0]:g} to {self.band[1]:g} Hz"
            raise InvalidRequest(Fault("call", "band", found, "0 ≤ low < high [Hz]"))

    @property
    def unit(self) -> str:
        """Unit of the receptance."""
        return "rad/(N·m)" if self.direction.is_rotation else "m/N"

    def frequency_at(self, posed: PosedRobot) -> float:
        """The best frequency of the band at a posture [Hz]."""
        return tune(posed, self.band, response=self.direction).best.frequency

    def value(self, posed: PosedRobot) -> float:
        """|α| at the best frequency [m/N]."""
        return tune(posed, self.band, response=self.direction).best.receptance

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Ln |α| at the best frequency, and its gradient."""
        return self._there(posed).cost_and_gradient(posed)

    def limit(self, cost: float, robot: Robot) -> Limit:
        """As for the receptance at one frequency."""
        return ReceptanceObjective((self.direction,), np.array([self.band[0]])).limit(cost, robot)

    def _there(self, posed: PosedRobot) -> ReceptanceObjective:
        return ReceptanceObjective((self.direction,), np.array([self.frequency_at(posed)]))
