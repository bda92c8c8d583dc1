"""What an effect may look at: the believed robot, and where and how it was struck; no measured value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.campaign import CampaignPoint, CampaignPosture, named_direction
from flexmodal.diagnosis.time_domain.pulse import Pulse, pulses
from flexmodal.identification import Observations
from flexmodal.identification.spot import in_world, spot_of
from flexmodal.model import Robot
from flexmodal.structure.arm import Arm, Arms, far_end, moved_bodies, plane_normal
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.fixtures import arm_in
from flexmodal.structure.frame import Frames

Place = tuple[int, int]
"""Point id, and direction 1, 2, 3."""


@dataclass(frozen=True, eq=False)
class Context:
    """The believed robot and the layout of a test."""

    robot: Robot
    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    responses: tuple[Place, ...]
    """Where motion was measured."""
    references: tuple[Place, ...]
    """Where the hammer struck."""
    band: tuple[float, float]
    """First and last line [Hz]."""
    pulses: tuple[Pulse, ...] = ()
    """The hammer's pulse in each kind of blow."""
    peaks: Mapping[int, float] | None = None
    """Typical force peak [N] of each kind of blow that was measured, by its number in `pulses`."""
    every_line: bool = True
    """Whether the whole band was measured, or some modes in it only."""
    is_rough: bool = False
    """Whether links that bend have as few hinges as may be, for coarse looks."""

    @classmethod
    def of(cls, robot: Robot, observations: Observations) -> Context:
        """Of measured FRFs.

        Args:
            robot: as it is believed to be.
            observations: of its campaign.
        """
        frequency = observations.axis.frequency
        return cls(
            robot=robot,
            postures=observations.postures,
            points=tuple(observations.campaign.points),
            responses=_places(observations.response),
            references=_places(observations.reference),
            band=(float(frequency[0]), float(frequency[-1])),
            pulses=pulses(observations),
            peaks={int(n): observations.peak(int(n)) for n in np.unique(observations.level)},
        )

    @cached_property
    def rough(self) -> Context:
        """The same for coarse looks."""
        return self if self.is_rough else replace(self, is_rough=True)

    @property
    def middle(self) -> float:
        """Middle of the band on a logarithmic scale [Hz]."""
        return float(np.sqrt(self.band[0] * self.band[1]))

    @cached_property
    def frames(self) -> Frames:
        """Those used last, of whatever hypothesis, so that together they take no more room than one may."""
        return Frames()

    @cached_property
    def normal(self) -> np.ndarray | None:
        """Normal of a planar chain's plane; None for a spatial one."""
        return plane_normal(self.robot)

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Flexible joints that are no pseudo-joints."""
        return tuple(name for name, joint in self.robot.joints.items() if not joint.pseudo)

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Links with mass that a flexible joint moves."""
        return moved_bodies(self.robot)

    @cached_property
    def arm_mass(self) -> float:
        """Mass of everything that moves [kg]."""
        return float(sum(self.robot.urdf.link_by_name[link].mass or 0.0 for link in self.links))

    @cached_property
    def sensors(self) -> tuple[str, ...]:
        """Names of the points where something was measured."""
        return tuple(self.point(number).name for number in sorted({number for number, _ in self.responses}))

    @cached_property
    def levels(self) -> tuple[int, ...]:
        """Numbers of the kinds of blow that were measured."""
        return tuple(sorted(self.peaks or {}))

    @property
    def level_count(self) -> int:
        """How many kinds of blow differ in force."""
        return len({round(float(np.log(peak)), 1) for peak in (self.peaks or {}).values()})

    @cached_property
    def arms(self) -> tuple[Arm, ...]:
        """The robot in each of the postures."""
        return tuple(arm_in(self.robot, posture, self.points) for posture in self.postures)

    @cached_property
    def stacked(self) -> Arms:
        """The same, side by side."""
        return Arms.of(self.arms)

    def axes(self, link: str) -> Float[np.ndarray, "3 3"]:
        """Axes of a link in the first posture."""
        return self.arms[0].placed[link][:3, :3]

    @cached_property
    def _points(self) -> Mapping[int | str, CampaignPoint]:
        return {key: point for point in self.points for key in (point.id, point.name)}

    def point(self, key: int | str) -> CampaignPoint:
        """A point by its id or name."""
        return self._points[key]

    def direction(self, place: Place) -> str:
        """A point and a direction as text, such as tip:+z."""
        number, way = place
        return str(named_direction((number, way), {number: self.point(number).name}))

    def places(
        self, table: Int[np.ndarray, "place 2"], assembly: Assembly
    ) -> list[tuple[str, Float[np.ndarray, "3"], Float[np.ndarray, "*posture 3"]]]:
        """Link, place in its frame [m] and world direction of point ids and directions.

        Args:
            table: point ids and directions ±1 ±2 ±3.
            assembly: of the postures; a direction along the axes of a link turns with them.
        """
        return in_world([spot_of(self.point(number), way) for number, way in table.tolist()], assembly)

    def reach(self, link: str) -> Float[np.ndarray, "3"]:
        """From the origin of a link to its far end, in its frame [m]."""
        return far_end(self.robot, link)


def _places(table: np.ndarray) -> tuple[Place, ...]:
    return tuple((int(number), int(way)) for number, way in np.unique(table, axis=0))
