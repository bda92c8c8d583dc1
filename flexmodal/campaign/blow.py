"""One hammer blow: the force and what the sensors felt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from jaxtyping import Float

from flexmodal.frf import Form

Quantity = Literal["displacement", "velocity", "acceleration"]
FORM_OF: Mapping[Quantity, Form] = MappingProxyType(
    {"displacement": "receptance", "velocity": "mobility", "acceleration": "inertance"}
)
"""What a response quantity per force is called."""


@dataclass(frozen=True, eq=False)
class Blow:
    """Time records of one blow, all on one evenly spaced axis."""

    posture: int
    trial: int
    sequence: int
    """1 for the first blow of a trial."""
    reference: tuple[int, int]
    """Point and direction of the force, ±1 ±2 ±3 for ±x ±y ±z of the world frame."""
    time: Float[np.ndarray, " sample"]
    """[s]."""
    force: Float[np.ndarray, " sample"]
    """Along the reference direction [N]."""
    channels: tuple[tuple[int, int], ...]
    """Point and direction of each response."""
    response: Float[np.ndarray, "channel sample"]
    """[m], [m/s] or [m/s²], along the direction of its channel."""
    quantity: Quantity = "acceleration"

    @property
    def step(self) -> float:
        """Time between two samples [s]."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))
