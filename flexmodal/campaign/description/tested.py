"""What was tested: postures, points and trials, without the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from flexmodal.campaign.trial import Trial
from flexmodal.text.frozen import FrozenDict

BAND = "two frequencies in Hz, the lower first, at most 1e9"
"""What the band of a campaign may be."""
NO_ROBOT = "none"
"""What stands for the robot where no file names one."""
OUTPUT_ONLY = "responses without a force: output-only data"
"""What is found where nothing says what the structure was struck with."""
OUTPUT_SPECTRA = "spectra of responses without FRFs: output-only data"
"""The same of spectra."""
FORCE_TOO = (
    "a force beside them; output-only data are not supported: without the force there is no receptance. "
    "Programs for operational modal analysis, such as pyOMA2, find modes in them"
)
"""What would have to be there."""
AxisFrame = Literal["world", "link"]
Axes = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class CampaignPosture:
    """A posture in which the robot was tested."""

    id: int
    """Load case number of the records; above 0."""
    name: str
    q: Mapping[str, float]
    """Angles of commanded joints [rad, or m]; a joint left out is 0."""
    locked: tuple[str, ...] = ()
    """Flexible joints that were locked from link to link while it stood there."""
    masses: Mapping[str, float] = field(default_factory=FrozenDict)
    """Masses that were bolted on meanwhile, by the name of the point [kg]."""


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
    axes: Axes | None = None
    """Unit vectors that directions 1, 2, 3 stand for, a row each; those of the frame itself if None."""
    frame: AxisFrame = "world"
    """What the axes are fixed to: the world, or the link, with which they turn from posture to posture."""

    @property
    def own_axes(self) -> bool:
        """Whether its directions are others than the world's."""
        return self.axes is not None or self.frame == "link"

    def rows(self) -> Float[np.ndarray, "3 3"]:
        """Unit vectors along directions 1, 2, 3 in the frame they are fixed to, of length 1 exactly."""
        if self.axes is None:
            return np.eye(3)
        given = np.array(self.axes, dtype=float)
        return np.asarray(given / np.linalg.norm(given, axis=1, keepdims=True))

    def way(
        self, direction: int, orientation: Float[np.ndarray, "*posture 3 3"]
    ) -> Float[np.ndarray, "*posture 3"]:
        """The unit vector in the world that a direction stands for.

        Args:
            direction: ±1, ±2 or ±3.
            orientation: axes of its link in the world, column by column, perhaps of several postures.
        """
        own = self.rows()[abs(direction) - 1] * np.sign(direction)
        return own if self.frame == "world" else np.asarray(orientation @ own)

    def axes_text(self) -> str:
        """What its directions are, in words."""
        if self.axes is None:
            return f"the axes of {self.link}" if self.frame == "link" else "the axes of the world"
        named = zip("xyz", self.rows(), strict=True)
        rows = ", ".join(
            f"{name} = ({', '.join(f'{part:.4g}' for part in row + 0.0)})" for name, row in named
        )
        return f"{rows} in the frame of {self.link if self.frame == 'link' else 'the world'}"


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
USUAL = Tolerance(posture=0.01, position=0.005, direction=0.03, gain=0.03)
"""Of a careful test by hand: half a degree, some millimetres, two degrees, some per cent."""


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

    @property
    def trace_lines(self) -> tuple[tuple[int, ...], ...]:
        """Ids of points that a picture joins one after the other."""


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
    trace_lines: tuple[tuple[int, ...], ...] = ()
    """Ids of points that a picture joins one after the other."""
