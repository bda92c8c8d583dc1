"""How what a campaign states may have been meant: angles of its postures, frames of its axes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Complex

from flexmodal.campaign import CampaignPoint
from flexmodal.identification import Observations

Framed = tuple[int, Literal["sensor", "hammer"]]
"""A point's id, and what of its the axes are fixed to the other frame."""


@dataclass(frozen=True)
class Reading:
    """How the posture and the directions of a record are read."""

    offset: int = 0
    """The angles stand so many postures further on."""
    turned: frozenset[str] = frozenset()
    """Joints that count the other way."""
    in_degrees: bool = False
    """Whether the angles are degrees."""
    framed: frozenset[Framed] = frozenset()
    """Sensors and hammers whose axes are the link's where the world's are stated, or the other way round."""

    def of(self, stated: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
        """The angles of every posture [rad, m].

        Args:
            stated: as they stand in the campaign.
        """
        count, scale = len(stated), math.pi / 180 if self.in_degrees else 1.0
        return [
            {
                joint: scale * (-value if joint in self.turned else value)
                for joint, value in stated[(number + self.offset) % count].items()
            }
            for number in range(count)
        ]

    def applied(self, observations: Observations) -> Observations:
        """The same records in the postures, and along the directions, that they are so read to be of.

        Args:
            observations: as the campaign states them.
        """
        angles = self.of([dict(one.q) for one in observations.postures])
        return with_angles(with_frames(observations, self.framed), angles)


STATED = Reading()


class Models(dict[Reading, Complex[np.ndarray, "observation line"]]):
    """Receptances of every observation by how it is read, each made when it is asked for [m/N]."""

    def __init__(self, make: Callable[[Reading], Complex[np.ndarray, "observation line"]]) -> None:
        super().__init__()
        self.make = make

    def __missing__(self, reading: Reading) -> Complex[np.ndarray, "observation line"]:
        """Make it, once."""
        self[reading] = self.make(reading)
        return self[reading]


def with_angles(observations: Observations, angles: Sequence[Mapping[str, float]]) -> Observations:
    """The same records in other postures.

    Args:
        observations: whose postures are changed.
        angles: of each posture [rad, m].
    """
    pairs = zip(observations.postures, angles, strict=True)
    return replace(observations, postures=tuple(replace(one, q=dict(q)) for one, q in pairs))


def with_frames(observations: Observations, framed: frozenset[Framed]) -> Observations:
    """The same records with axes of some sensors and hammers fixed to the link instead of the world, or back.

    Such a sensor or hammer has a point of its own, beside the campaign's, at the same place.

    Args:
        observations: whose points are changed.
        framed: which.
    """
    if not framed:
        return observations
    campaign = observations.campaign
    taken = {point.id for point in campaign.points}
    longest = max(len(point.name) for point in campaign.points)
    free = (number for number in itertools.count(1) if number not in taken)
    beside: dict[int, CampaignPoint] = {}
    places = {"sensor": observations.response.copy(), "hammer": observations.reference.copy()}
    for number, what in sorted(framed):
        if number not in beside:
            point = campaign.point(number)
            beside[number] = replace(
                point, id=next(free), name=point.name.ljust(longest) + "′", frame=other_frame(point)
            )
        place = places[what][:, 0]
        place[place == number] = beside[number].id
    points = (*campaign.points, *beside.values())
    return replace(
        observations,
        campaign=replace(campaign, points=points, frfs=None, blows=(), modes=None),
        response=places["sensor"],
        reference=places["hammer"],
    )


def other_frame(point: CampaignPoint) -> Literal["world", "link"]:
    """What its axes are not said to be fixed to.

    Args:
        point: of a campaign.
    """
    return "world" if point.frame == "link" else "link"
