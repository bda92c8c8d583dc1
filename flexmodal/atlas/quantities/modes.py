"""Modes of an atlas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.atlas.quantities.quantity import Quantity, Variable, posed_at
from flexmodal.model import Robot


@dataclass(frozen=True, eq=False)
class NaturalModes(Quantity):
    """Natural frequencies and damping ratios, in the order of |pole|.

    There are as many as flexible joints, and one more for each overdamped mode: room is kept for all, and
    what a posture has no mode for is not a number.
    """

    robot: Robot

    name = "modes"
    postures_per_chunk = 2048
    releases = False

    @property
    def most(self) -> int:
        """Entries kept: n where no joint can overdamp anything, else 2n."""
        n = len(self.robot.joints)
        return n if not np.any(self.robot.damping) else 2 * n

    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """Numbers of the modes, from 1."""
        return {"mode": np.arange(1.0, self.most + 1)}

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Two real arrays."""
        return (
            Variable("natural_frequency", ("mode",), "float64", "Hz", "natural frequency"),
            Variable("damping_ratio", ("mode",), "float64", "1", "damping ratio; 1 for a real pole"),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Modes of each posture by itself."""
        found = {one.name: np.full((len(values), self.most), np.nan) for one in self.variables}
        for place, posed in enumerate(posed_at(self.robot, values)):
            modes = posed.modes()
            found["natural_frequency"][place, : len(modes.pole)] = modes.frequency
            found["damping_ratio"][place, : len(modes.pole)] = modes.damping_ratio
        return found

    def facts(self) -> dict[str, Any]:
        """Its name and size."""
        return {"name": self.name, "modes": self.most}
