"""Measured modes, with the band and the places that a model of them has to look at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.modes.stand_in import band_of, places_of_modes, stand_in
from flexmodal.identification import Observations
from flexmodal.identification.evidence.measured_modes import ModeObservations


@dataclass(frozen=True, eq=False)
class MeasuredModes:
    """Measured modes with what a fit needs besides."""

    observed: ModeObservations

    @property
    def campaign(self) -> Campaign:
        """Where they come from."""
        return self.observed.campaign

    @cached_property
    def band(self) -> tuple[float, float]:
        """Where peaks were looked for [Hz]."""
        return band_of(self.campaign)

    @cached_property
    def places(self) -> tuple[tuple[int, int], ...]:
        """Responses of the shapes; the first point, upwards, where there are no shapes."""
        return places_of_modes(self.observed)[0] or ((self.campaign.points[0].id, 3),)

    @cached_property
    def stand_in(self) -> Observations:
        """For hypotheses: nothing measured."""
        references = places_of_modes(self.observed)[1]
        return stand_in(self.campaign, self.observed.postures, self.places, references)

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Modes as the measurement counts."""
        return tuple(sorted({mode.number for mode in self.observed.modes}))

    @cached_property
    def here(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the modes of each posture."""
        return tuple(self.observed.in_posture(k) for k in range(len(self.observed.postures)))

    def keeping(self, keep: Bool[np.ndarray, " mode"]) -> MeasuredModes:
        """Some of the modes."""
        return MeasuredModes(self.observed.keeping(keep))

    def rows(self, places: np.ndarray) -> list[int]:
        """Where places stand among `places`."""
        return [self.places.index((int(p), int(d))) for p, d in places]
