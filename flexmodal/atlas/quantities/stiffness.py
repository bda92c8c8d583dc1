"""Stiffness of an atlas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.atlas.quantities.quantity import Quantity, Variable, posed_at
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.model.batch import read_pairs
from flexmodal.model.measures import measure


@dataclass(frozen=True, eq=False)
class Stiffnesses(Quantity):
    """Stiffness and mobility measures and static receptance along directions."""

    robot: Robot
    directions: tuple[PointDirection, ...]

    name = "stiffness"
    postures_per_chunk = 2048
    releases = False

    @classmethod
    def of(cls, robot: Robot, directions: Sequence[str | PointDirection]) -> Stiffnesses:
        """Check the directions.

        Args:
            robot: the robot.
            directions: such as "tool:+z".

        Raises:
            InvalidPoint, InvalidRequest: bad text, no such point, none, or one twice.
        """
        read, _, _ = read_pairs(robot, directions)
        if len(set(read)) < len(read):
            raise InvalidRequest(Fault("call", "directions", "a direction twice", "each once"))
        return cls(robot, tuple(one for one, _ in read))

    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """The directions."""
        return {"direction": [str(one) for one in self.directions]}

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Three real arrays."""
        along = ("direction",)
        return (
            Variable(
                "stiffness", along, "float64", "N/m", "force felt when the tool is moved along one direction"
            ),
            Variable("mobility", along, "float64", "m2/rad2", "squared length of the Jacobian's row"),
            Variable(
                "static_receptance", along, "float64", "m/N", "deflection over a force that stands still"
            ),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Measures of each posture by itself."""
        found = {one.name: np.empty((len(values), len(self.directions))) for one in self.variables}
        for place, posed in enumerate(posed_at(self.robot, values)):
            for column, direction in enumerate(self.directions):
                one = measure(posed, direction)
                for name, array in found.items():
                    array[place, column] = getattr(one, name)
        return found

    def facts(self) -> dict[str, Any]:
        """The directions."""
        return {"name": self.name, "directions": [str(one) for one in self.directions]}
