"""Ports with free functions as they were fitted and judged, and rounds of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.lawfree.model import PortedModel, Unknown
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.lawfree.screening import ALIKE
from flexmodal.identification import Observations

SMALLEST = 5e-4
"""Model error at least, with which the last fits are judged."""

Start = tuple[Float[np.ndarray, " parameter"], Unknown]
"""Coordinates of the parameters, and functions in their sizes."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """Ports with free functions, fitted together."""

    ports: tuple[Port, ...]
    misfit: float
    """Root of the reduced χ² on the postures fitted, in units of the noise of the averages; about 0.6 if
    perfect, since Huber's function and the smallest model error take their part."""
    apart: float | None
    """The same on the postures held out; None where there are none, or the functions differ by posture."""
    unknowns: int
    """Functions, and parameters of the ports' geometry."""
    profile: Profile
    state: State

    @property
    def port(self) -> Port:
        """The one that came last."""
        return self.ports[-1]

    @property
    def judged(self) -> float:
        """The larger of both misfits."""
        return self.misfit if self.apart is None else max(self.misfit, self.apart)


@dataclass(frozen=True, eq=False)
class Round:
    """Ports tried beside others that are there already."""

    sightings: tuple[Sighting, ...]
    """The best first."""

    @cached_property
    def alike(self) -> tuple[Sighting, ...]:
        """What cannot be told apart from the best, itself included; the simplest first."""
        found = [one for one in self.sightings if one.judged <= ALIKE * self.sightings[0].judged]
        return tuple(sorted(found, key=lambda one: (one.unknowns, one.judged)))

    @property
    def best(self) -> Sighting:
        """Of those that cannot be told apart the one with the fewest unknowns."""
        return self.alike[0]


def carried_over(before: Sighting, model: PortedModel, stride: int = 1) -> State:
    """Where a fit of some ports ended, as the beginning of one with one more.

    Args:
        before: the fit.
        model: with the same ports and one more, which may leave observations out.
        stride: the model has every so many of the lines.
    """
    z = model.in_cells(before.state.z, before.profile.model)
    return replace(before.state, z=z[..., ::stride], residual=before.state.residual[:, ::stride])


def noise_of(observations: Observations, lines: Int[np.ndarray, " line"]) -> float:
    """Typical noise of the averages: the model error at which fits are judged.

    Args:
        observations: measured receptances.
        lines: those that are looked at.
    """
    used = observations.used[:, lines]
    if not used.any():
        return SMALLEST
    return max(0.5 * float(np.sqrt(np.median(observations.variance[:, lines][used]))), SMALLEST)
