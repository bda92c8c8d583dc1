"""Depths of cut of an atlas."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.atlas.quantities.quantity import Quantity, Variable, posed_at
from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.machining import Cut, stability_lobes
from flexmodal.machining.stability.lobes import speed_axis
from flexmodal.machining.tip import tool_tip
from flexmodal.model import Robot

MOST_SPEEDS = 10_000
"""Of a range of spindle speeds."""


@dataclass(frozen=True, eq=False)
class DepthOfCut(Quantity):
    """Axial depth below which a cut is stable, over its spindle speeds, by the zero-order solution.

    Infinite where nothing limits it, 0 where an undamped mode is seen by the tip.
    """

    robot: Robot
    cut: Cut
    speeds: int = 24

    name = "depth"
    postures_per_chunk = 64
    releases = False

    def __post_init__(self) -> None:
        """Check the number of speeds.

        Raises:
            InvalidRequest: none, or too many.
        """
        if not 2 <= self.speeds <= MOST_SPEEDS:
            raise InvalidRequest(Fault("call", "speeds", str(self.speeds), f"2 to {MOST_SPEEDS:,}"))

    @cached_property
    def axis(self) -> Float[np.ndarray, " speed"]:
        """Spindle speeds [rev/min]."""
        return speed_axis(self.cut, self.speeds)

    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """Spindle speeds [rev/min]."""
        return {"spindle_speed": self.axis}

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The depth at each speed, and the least of them."""
        return (
            Variable("limiting_depth", ("spindle_speed",), "float64", "m", "depth stable at a spindle speed"),
            Variable("critical_depth", (), "float64", "m", "depth stable at every one of the speeds"),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Depths of each posture by itself."""
        depth = np.zeros((len(values), len(self.axis)))
        for place, posed in enumerate(posed_at(self.robot, values)):
            try:
                depth[place] = stability_lobes(tool_tip(posed, self.cut), self.cut, speeds=self.axis).depth
            except SingularResponse:
                continue
        return {"limiting_depth": depth, "critical_depth": depth.min(axis=1)}

    def facts(self) -> dict[str, Any]:
        """The cut, by its title and a digest of its numbers."""
        digest = hashlib.sha256(repr(self.cut).encode()).hexdigest()[:16]
        return {"name": self.name, "cut": self.cut.title, "cut_digest": digest, "speeds": self.speeds}
