"""What a port adds to a structure: a dynamic stiffness on a pattern, or a compliance behind a coordinate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class StiffnessPort:
    """A dynamic stiffness on a fixed pattern [N/m, N·m/rad for a pattern without unit]."""

    pattern: Float[np.ndarray, "system dof dof"]
    """P, symmetric."""


@dataclass(frozen=True, eq=False)
class CompliancePort:
    """A compliance behind a coordinate that is rigid without it [m/N, rad/(N·m)]."""

    coordinate: int
    other: int | None = None
    """Another such coordinate, for what the force through one does to both; itself if None."""

    @property
    def both(self) -> tuple[int, int]:
        """The coordinate and the other one, or itself."""
        return self.coordinate, self.coordinate if self.other is None else self.other


Port = StiffnessPort | CompliancePort
