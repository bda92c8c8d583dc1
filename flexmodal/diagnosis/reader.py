"""What sensors make of the motion at their points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.structure.structure import Axis


@dataclass(frozen=True, eq=False)
class Reader:
    """What sensors make of the motion at their points."""

    points: Sequence[str]
    """Response point of each observation."""
    placements: Sequence[tuple[Effect, Placement]]
    moved: Sequence[tuple[str, float, Sequence[tuple[Effect, Placement]]]]

    def __call__(self, axis: Axis) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """ln(reading / motion) [observation line], and its derivatives."""
        base = self._log(axis, self.placements)
        return base, {
            name: (self._log(axis, placements) - base) / step for name, step, placements in self.moved
        }

    def _log(self, axis: Axis, placements: Sequence[tuple[Effect, Placement]]) -> np.ndarray:
        total = np.zeros((len(self.points), len(axis)), dtype=complex)
        for effect, placement in placements:
            if effect.read is not None:
                total[[point == placement.where for point in self.points]] += effect.read(placement, axis)
        return total
