"""What sensors make of the motion at their points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.diagnosis.effects.effect import Effect, Site
from flexmodal.structure.structure import Axis


@dataclass(frozen=True, eq=False)
class Reader:
    """What sensors make of the motion at their points."""

    points: Sequence[str]
    """Response point of each observation."""
    sites: Sequence[tuple[Effect, Site]]
    moved: Sequence[tuple[str, float, Sequence[tuple[Effect, Site]]]]

    def __call__(self, axis: Axis) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """ln(reading / motion) [observation line], and its derivatives."""
        base = self._log(axis, self.sites)
        return base, {name: (self._log(axis, sites) - base) / step for name, step, sites in self.moved}

    def _log(self, axis: Axis, sites: Sequence[tuple[Effect, Site]]) -> np.ndarray:
        total = np.zeros((len(self.points), len(axis)), dtype=complex)
        for effect, site in sites:
            if effect.read is not None:
                total[[point == site.where for point in self.points]] += effect.read(site, axis)
        return total
