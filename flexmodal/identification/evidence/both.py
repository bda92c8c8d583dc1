"""FRFs and modes of one campaign together: their sums of squares add.

Modes that somebody estimated from these very FRFs are no second measurement: taken together, the data would
count twice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from flexmodal.errors import Fault
from flexmodal.identification.descent import Normal, prior_cost
from flexmodal.identification.evidence.evidence import Evidence, Fitted, Key, Misfit, few
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.evidence.modal import ModalEvidence
from flexmodal.identification.gap import Gap
from flexmodal.identification.uncertainty import Uncertainty, clustered
from flexmodal.structure.parameter import ParameterSpace


@dataclass(frozen=True, eq=False)
class SumMisfit:
    """The sum of two misfits, with one prior."""

    parts: tuple[Misfit, Misfit]
    space: ParameterSpace

    def cost(self, x: Float[np.ndarray, " parameter"]) -> float:
        """See `Misfit`."""
        return sum(part.cost(x) for part in self.parts) - prior_cost(self.space, x)

    def equations(self, x: Float[np.ndarray, " parameter"], *, apart: bool = False) -> Normal:
        """See `Misfit`; observations of the first part come first."""
        one, other = (part.equations(x, apart=apart) for part in self.parts)
        blocks = None
        if one.blocks is not None and other.blocks is not None:
            blocks = np.concatenate([one.blocks, other.blocks])
        return Normal(
            one.cost + other.data_cost,
            one.data_cost + other.data_cost,
            one.gradient + other.gradient - self.space.precision * x,
            one.curvature + other.curvature,
            np.concatenate([one.scores, other.scores]),
            np.concatenate([one.squared, other.squared]),
            blocks,
        )

    def same_pairs(self, other: Misfit) -> bool:
        """Whether both parts have."""
        return isinstance(other, SumMisfit) and all(
            one.same_pairs(another) for one, another in zip(self.parts, other.parts, strict=True)
        )


@dataclass(frozen=True, eq=False)
class Both(Evidence):
    """FRFs and modes; observations are those of the FRFs, then the modes."""

    frfs: FrfEvidence
    modes: ModalEvidence

    most = 60

    @property
    def parts(self) -> tuple[FrfEvidence, ModalEvidence]:
        """The two."""
        return self.frfs, self.modes

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        return self.frfs.space

    @property
    def what(self) -> str:
        """The data in words."""
        return f"{self.frfs.what} and {self.modes.what}"

    @property
    def count(self) -> int:
        """Of both."""
        return self.frfs.count + self.modes.count

    def faults(self) -> list[Fault]:
        """FRFs that are nothing but noise, or fewer numbers than parameters in both together."""
        source = str(self.frfs.observations.campaign.path or "campaign")
        return self.frfs.noise_faults() or few(
            source, self.count, len(self.space), "usable values in FRFs and modes"
        )

    def floors(self, *, quick: bool = False, warm: bool = False) -> Sequence[float]:
        """Of natural frequencies; the FRFs' are lowered along, see `misfit`."""
        return self.modes.floors(quick=quick, warm=warm)

    def misfit(
        self, x: Float[np.ndarray, " parameter"], floor: float, *, near: bool = True, quick: bool = False
    ) -> SumMisfit:
        """Of both; the FRFs' model error is the one as far down their own list."""
        place, steps = self.modes.floors().index(floor), self.frfs.floors()
        parts = (
            self.frfs.misfit(x, steps[min(place, len(steps) - 1)], quick=quick),
            self.modes.misfit(x, floor, near=near),
        )
        return SumMisfit(parts, self.space)

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """The sum."""
        return self.frfs.information() + self.modes.information()

    def clusters(self) -> Int[np.ndarray, " observation"]:
        """Those of each; none has both."""
        first, then = (part.clusters() for part in self.parts)
        return np.concatenate([first, then + first.max(initial=-1) + 1])

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """By clusters."""
        return clustered(self.space, fitted.normal, self.clusters())

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, " observation"]:
        """Of each observation what its part predicts."""
        found = np.empty(len(self.frfs.observations) + len(self.modes.observations), dtype=object)
        for k, row in enumerate(row for part in self.parts for row in part.predicted(x)):
            found[k] = row
        return found

    def gap(self, predicted: Shaped[np.ndarray, " observation"]) -> Gap:
        """Of the FRFs, where there are any, as the file formats define it."""
        frfs, modes = self._split(predicted)
        return self.frfs.gap(frfs) if len(frfs) else self.modes.gap(modes)

    def over_noise(self, predicted: Shaped[np.ndarray, " observation"]) -> float:
        """The larger of the two: both have to be met."""
        pairs = zip(self.parts, self._split(predicted), strict=True)
        return max(part.over_noise(own) for part, own in pairs if len(own))

    def shared_misfit(self, predicted: Shaped[np.ndarray, " observation"]) -> float | None:
        """Of the FRFs."""
        frfs, _ = self._split(predicted)
        return self.frfs.shared_misfit(frfs) if len(frfs) else None

    def folds(self) -> Mapping[Key, Bool[np.ndarray, " observation"]]:
        """Postures with their FRFs and modes, and points that carried the sensor."""
        frfs, modes = (part.folds() for part in self.parts)
        none = np.zeros(len(self.frfs.observations), bool), np.zeros(len(self.modes.observations), bool)
        return {
            key: np.concatenate([frfs.get(key, none[0]), modes.get(key, none[1])])
            for key in dict.fromkeys([*frfs, *modes])
        }

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> Both:
        """See `Evidence`."""
        count = len(self.frfs.observations)
        return replace(self, frfs=self.frfs.keeping(keep[:count]), modes=self.modes.keeping(keep[count:]))

    def _split(self, predicted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count = len(self.frfs.observations)
        frfs, modes = (list(rows) for rows in (predicted[:count], predicted[count:]))
        lines = self.frfs.observations.value.shape[1]
        return np.array(frfs).reshape(-1, lines), np.array(modes).reshape(-1, 3)
