"""Measured modes as a fit sees them: one entry for each posture and mode, with its errors and shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.campaign import Campaign, CampaignPosture

ABOVE = 1.5
"""Times the highest natural frequency at which a band without an upper end is taken to end."""

Place = tuple[int, int]
"""Point id, and direction 1, 2, 3."""


@dataclass(frozen=True, eq=False)
class MeasuredShape:
    """Residues of one mode at several places, for one hammer position."""

    reference: tuple[int, int]
    """Point id and direction."""
    places: Int[np.ndarray, "place 2"]
    """Point ids and directions 1, 2, 3."""
    residue: Complex[np.ndarray, " place"]
    """Of the receptance [m/(s·N)]."""
    error: Float[np.ndarray, " place"]
    """Relative standard error."""


@dataclass(frozen=True, eq=False)
class MeasuredMode:
    """One mode of one posture."""

    posture: int
    """Number in `ModeObservations.postures`."""
    number: int
    """As the measurement counts."""
    frequency: float
    """Natural frequency [Hz]."""
    frequency_error: float
    """Relative standard error."""
    damping_ratio: float
    """NaN where it is missing."""
    damping_error: float
    """Relative standard error."""
    shapes: tuple[MeasuredShape, ...] = ()


@dataclass(frozen=True, eq=False)
class Antiresonance:
    """A dip of one receptance."""

    posture: int
    """Number in `ModeObservations.postures`."""
    response: tuple[int, int]
    reference: tuple[int, int]
    frequency: float
    """[Hz]"""
    error: float
    """Relative standard error."""


@dataclass(frozen=True, eq=False)
class ModeObservations:
    """The modes of a campaign, and antiresonances where they are wanted too."""

    campaign: Campaign
    postures: tuple[CampaignPosture, ...]
    modes: tuple[MeasuredMode, ...]
    antiresonances: tuple[Antiresonance, ...] = ()

    def __len__(self) -> int:
        """How many modes and antiresonances."""
        return len(self.modes) + len(self.antiresonances)

    @cached_property
    def band(self) -> tuple[float, float]:
        """Where peaks were looked for; without an upper end up to somewhat above the highest mode [Hz]."""
        low, high = self.campaign.band
        if not np.isfinite(high):
            assert self.campaign.modes is not None
            high = ABOVE * float(np.nanmax(self.campaign.modes.natural_frequency))
        return low, high

    @cached_property
    def responses(self) -> tuple[Place, ...]:
        """Every place that some shape has; the first point, upwards, where there are no shapes."""
        found = {(int(p), int(d)) for m in self.modes for s in m.shapes for p, d in s.places}
        return tuple(sorted(found)) or ((self.campaign.points[0].id, 3),)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """`responses`, then every other place where the hammer fell."""
        struck = {shape.reference for mode in self.modes for shape in mode.shapes}
        return (*self.responses, *sorted(struck - set(self.responses)))

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Modes as the measurement counts."""
        return tuple(sorted({mode.number for mode in self.modes}))

    @cached_property
    def here(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the modes of each posture."""
        found: list[list[int]] = [[] for _ in self.postures]
        for k, mode in enumerate(self.modes):
            found[mode.posture].append(k)
        return tuple(tuple(one) for one in found)

    def rows(self, places: Int[np.ndarray, "place 2"]) -> list[int]:
        """Where places stand among `responses`."""
        return [self.responses.index((int(p), int(d))) for p, d in places]

    def keeping(self, keep: np.ndarray) -> ModeObservations:
        """Some of the entries, modes first; postures keep their numbers."""
        modes = tuple(m for m, k in zip(self.modes, keep[: len(self.modes)], strict=True) if k)
        zeros = tuple(z for z, k in zip(self.antiresonances, keep[len(self.modes) :], strict=True) if k)
        return replace(self, modes=modes, antiresonances=zeros)
