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
from flexmodal.machining import Cut, TipSource, stability_lobes, tip_at
from flexmodal.machining.stability.lobes import speed_axis
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
    tips: TipSource | None = None
    """Where tips come from, such as a prediction; the robot itself if None."""

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
        """The depth at each speed, and the least of them; of a prediction with the ends of its band."""
        speed = ("spindle_speed",)
        plain = (
            Variable("limiting_depth", speed, "float64", "m", "depth stable at a spindle speed"),
            Variable("critical_depth", (), "float64", "m", "depth stable at every one of the speeds"),
        )
        if self.tips is None:
            return plain
        large, small = "with every receptance as large as its band", "as small"
        return (
            *plain,
            Variable("low_limiting_depth", speed, "float64", "m", f"limiting_depth {large}"),
            Variable("high_limiting_depth", speed, "float64", "m", f"limiting_depth {small}"),
            Variable("low_critical_depth", (), "float64", "m", f"critical_depth {large}"),
            Variable("high_critical_depth", (), "float64", "m", f"critical_depth {small}"),
            Variable("remote", (), "float64", "1", "distance from what was struck over that between these"),
            Variable("beyond", (), "float64", "1", "how many joints are outside the range that was struck"),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Depths of each posture by itself."""
        found = {one.name: np.zeros((len(values), *self._shape(one))) for one in self.variables}
        for place, posed in enumerate(posed_at(self.robot, values)):
            tips = {"": tip_at(posed, self.cut, tips=self.tips)}
            if self.tips is not None:
                tips["low_"], tips["high_"] = self.tips.ends(posed, self.cut)
                remote, outside = self.tips.standing(posed)
                found["remote"][place], found["beyond"][place] = remote, len(outside)
            for end, tip in tips.items():
                try:
                    depth = stability_lobes(tip, self.cut, speeds=self.axis).depth
                except SingularResponse:
                    continue
                found[f"{end}limiting_depth"][place] = depth
                found[f"{end}critical_depth"][place] = depth.min()
        return found

    def _shape(self, variable: Variable) -> tuple[int, ...]:
        return (len(self.axis),) if variable.dims else ()

    def facts(self) -> dict[str, Any]:
        """The cut, by its title and a digest of its numbers, and the source."""
        digest = hashlib.sha256(repr(self.cut).encode()).hexdigest()[:16]
        told = {"name": self.name, "cut": self.cut.title, "cut_digest": digest, "speeds": self.speeds}
        return told if self.tips is None else {**told, "source": dict(self.tips.facts())}
