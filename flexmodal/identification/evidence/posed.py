"""A model that has a structure in each posture, as a model of the modes and antiresonances measured there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.antiresonance import nearest_dip
from flexmodal.identification.evidence.likelihood.forecast import Forecast, forecasts_of
from flexmodal.identification.evidence.likelihood.residuals import Part
from flexmodal.identification.evidence.measured_modes import ModeObservations, Place
from flexmodal.identification.spot import Spot, places_of
from flexmodal.model import Robot
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.structure.structure import Axis, Structure

ANTIRESONANCE = "antiresonance"


@runtime_checkable
class PosedModel(Protocol):
    """Anything that gives a structure in a posture from the coordinates of a parameter space."""

    @property
    def space(self) -> ParameterSpace:
        """What it depends on."""
        ...

    @property
    def robot(self) -> Robot:
        """Whose chain it has."""
        ...

    def structure_at(
        self,
        x: Float[np.ndarray, " parameter"],
        q: Mapping[str, float],
        responses: Sequence[Spot],
        references: Sequence[Spot],
    ) -> Structure:
        """In one posture, seen at these places.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            q: values of the joints [rad, m].
            responses: where sensors sit.
            references: where the hammer strikes.
        """
        ...


@dataclass(frozen=True, eq=False)
class PosedModes:
    """The modes of a model in the postures of a measurement (a `ModeModel`), and its antiresonances."""

    model: PosedModel
    measured: ModeObservations

    @property
    def space(self) -> ParameterSpace:
        """What they depend on."""
        return self.model.space

    @property
    def key(self) -> tuple[str, str]:
        """The robot, nowhere."""
        return self.model.robot.name, ""

    def forecasts(
        self, x: Float[np.ndarray, " parameter"], places: Sequence[Place], *, slopes: bool
    ) -> list[Forecast]:
        """Modes of every posture, seen at these places; none where none was measured.

        Args:
            x: coordinates.
            places: points and directions.
            slopes: with derivatives.

        Raises:
            InvalidSystem: a mass matrix that is not positive definite.
        """
        names, spots = self.space.names if slopes else (), places_of(self.measured.campaign, places)
        found = [Forecast.none(len(places), len(names)) for _ in self.measured.postures]
        measured = [k for k, here in enumerate(self.measured.here) if here]
        structures = [self.model.structure_at(x, self.measured.postures[k].q, spots, ()) for k in measured]
        if structures:
            for k, one in zip(measured, forecasts_of(structures, names, len(names)), strict=True):
                found[k] = one
        return found

    def zeros(self, x: Float[np.ndarray, " parameter"], *, slopes: bool) -> Iterator[Part]:
        """How far the nearest dips of the model are from the measured ones; none where there is none near.

        Args:
            x: coordinates.
            slopes: with derivatives.

        Raises:
            SingularResponse: an undamped mode at a line.
        """
        names, campaign = self.space.names if slopes else (), self.measured.campaign
        for number, zero in enumerate(self.measured.antiresonances, start=len(self.measured.modes)):
            spots = [places_of(campaign, [place]) for place in (zero.response, zero.reference)]
            structure = self.model.structure_at(x, self.measured.postures[zero.posture].q, *spots)
            found = nearest_dip(structure, Axis(np.zeros(1), zero.frequency), (0, 0), zero.frequency, names)
            if found is not None:
                place, slope = found
                away = np.array([np.log(place / zero.frequency)])
                yield Part(number, ANTIRESONANCE, away, (slope / place)[None], np.array([zero.error**2]), 1.0)
