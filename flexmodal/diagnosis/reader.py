"""What sensors make of the motion at their points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Int

from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.structure.structure import Axis


@dataclass(frozen=True, eq=False)
class Reader:
    """What sensors make of the motion at their points."""

    responses: Int[np.ndarray, "entry 2"]
    """Id of the response point of each receptance, and the direction."""
    systems: Int[np.ndarray, " entry"]
    """In which of the placements' systems each was read."""
    placements: Sequence[tuple[Effect, Placement]]
    """Effects that read."""
    moved: Sequence[tuple[int, float, Effect, Placement]]
    """Number of a parameter, a step along it, the effect it is of, and that a step further."""

    def __call__(
        self, axis: Axis
    ) -> tuple[Complex[np.ndarray, "entry line"], Mapping[int, Complex[np.ndarray, "entry line"]]]:
        """ln(reading / motion), and its derivatives by number of the parameter."""
        before = {
            effect.name + placement.where: self._log(axis, effect, placement)
            for effect, placement in self.placements
        }
        slopes = {
            number: (self._log(axis, effect, placement) - before[effect.name + placement.where]) / step
            for number, step, effect, placement in self.moved
        }
        return np.asarray(sum(before.values())), slopes

    def _log(self, axis: Axis, effect: Effect, placement: Placement) -> Complex[np.ndarray, "entry line"]:
        found = np.zeros((len(self.responses), len(axis)), dtype=complex)
        assert effect.read is not None
        own = self.responses[:, 0] == placement.context.point(placement.where).id
        if own.any():
            read = replace(placement.of_systems(self.systems[own]), response=self.responses[own])
            found[own] = effect.read(read, axis)
        return found
