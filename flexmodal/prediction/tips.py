"""The tip of a cutter in any posture, by a prediction; see `flexmodal.machining.TipSource`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.machining import Cut, MeasuredTip, point_of_cut, tip_in_cut, world_receptance
from flexmodal.model import PosedRobot
from flexmodal.prediction.band import remoteness
from flexmodal.prediction.predict import beyond
from flexmodal.prediction.source import PredictedReceptances


@dataclass(frozen=True, eq=False)
class PredictedTips:
    """Tips by one method of `METHODS`, at a point that was struck and measured, on the measured lines.

    Along directions that nobody struck or measured there the arm counts as rigid.
    """

    source: PredictedReceptances

    def tip(self, posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None) -> MeasuredTip:
        """See `TipSource`.

        Args:
            posed: the robot in the posture.
            cut: says where the tip is and how its axes lie.
            added: measured receptance of tool and spindle, in that frame.

        Raises:
            InvalidCut, InvalidPoint: no FRFs at the point of the cut, or not of every pair of directions.
        """
        return self._tip(posed, cut, added, 0.0)

    def ends(
        self, posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None
    ) -> tuple[MeasuredTip, MeasuredTip]:
        """See `TipSource`.

        Args:
            posed: the robot in the posture.
            cut: says where the tip is and how its axes lie.
            added: measured receptance of tool and spindle, in that frame.

        Raises:
            InvalidCut, InvalidPoint: as `tip`.
        """
        return self._tip(posed, cut, added, 1.0), self._tip(posed, cut, added, -1.0)

    def rigid(self, posed: PosedRobot, cut: Cut) -> int:
        """Directions of the world, 0 to 2, along which nothing is known of the tip.

        Args:
            posed: the robot in the posture.
            cut: says where the tip is.

        Raises:
            InvalidCut, InvalidPoint: as `tip`.
        """
        pairs, ways = self.source.drive(posed, point_of_cut(posed, cut))
        nothing = {(str(one), str(other)): np.zeros(1, complex) for one, other in pairs}
        return 3 - world_receptance(nothing, ways)[1]

    def standing(self, posed: PosedRobot) -> tuple[float, tuple[str, ...]]:
        """See `TipSource`.

        Args:
            posed: the robot in the posture.
        """
        q = dict(posed.posture.values)
        return remoteness(self.source.problem.left_out, q), beyond(self.source.problem, q)

    def facts(self) -> Mapping[str, Any]:
        """Those of the source, and its verdict."""
        return self.source.facts()

    def _tip(self, posed: PosedRobot, cut: Cut, added: MeasuredTip | None, side: float) -> MeasuredTip:
        """Every receptance times e^(side × half its band)."""
        pairs, ways = self.source.drive(posed, point_of_cut(posed, cut))
        axis: Float[np.ndarray, " line"] = self.source.lines
        value = self.source.receptances(posed, pairs, axis)
        if side:
            value = value * np.exp(side * self.source.band(posed, pairs, axis).log_size)
        known = {(str(one), str(other)): value[:, k] for k, (one, other) in enumerate(pairs)}
        world, _ = world_receptance(known, ways)
        return tip_in_cut(posed, cut, axis, world, added)
