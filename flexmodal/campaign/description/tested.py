"""What was tested: postures, points and trials, without the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from flexmodal.campaign.trial import Trial

BAND = "two frequencies in Hz, the lower first, at most 1e9"
"""What the band of a campaign may be."""


@dataclass(frozen=True)
class CampaignPosture:
    """A posture in which the robot was tested."""

    id: int
    """Load case number of the records; above 0."""
    name: str
    q: Mapping[str, float]
    """Angles of commanded joints [rad, or m]; a joint left out is 0."""


@dataclass(frozen=True)
class CampaignPoint:
    """A place where the hammer hit or a sensor sat."""

    id: int
    """Node number of the records; above 0."""
    name: str
    link: str
    """The URDF link that carries it."""
    xyz: tuple[float, float, float]
    """Its place in the frame of that link [m]."""


@dataclass(frozen=True)
class Tolerance:
    """How well a test was set up: one standard deviation each, 0 for what is exact."""

    posture: float = 0.0
    """Of each angle, or of each slide [rad, m]."""
    position: float = 0.0
    """Of hammer and sensor, along each direction [m]."""
    direction: float = 0.0
    """Of hammer and sensor, about each axis across [rad]."""
    gain: float = 0.0
    """Of each sensor and of the hammer, relative."""

    @property
    def is_exact(self) -> bool:
        """Whether nothing is uncertain."""
        return not (self.posture or self.position or self.direction or self.gain)


EXACT = Tolerance()


@runtime_checkable
class Described(Protocol):
    """Whatever says what was tested: a `campaign.toml` that was read, or a whole campaign."""

    @property
    def postures(self) -> tuple[CampaignPosture, ...]:
        """The postures."""

    @property
    def points(self) -> tuple[CampaignPoint, ...]:
        """Where the hammer hit and the sensors sat."""

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The trials."""

    @property
    def band(self) -> tuple[float, float] | None:
        """The lines to compare [Hz]."""


@dataclass(frozen=True)
class Tested:
    """What a `campaign.toml` says."""

    title: str
    robot: str
    band: tuple[float, float] | None
    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    trials: tuple[Trial, ...]
    separate_modes: bool = False
    """Whether `modes.csv` is a measurement of its own, not an estimate from the FRFs beside it."""
    tolerance: Tolerance = EXACT
