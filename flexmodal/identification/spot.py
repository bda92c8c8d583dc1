"""Where a structure is struck or seen: a place on a link, and a direction in the world or in that link."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Campaign, CampaignPoint
from flexmodal.structure.assembly import Assembly


class Spot(NamedTuple):
    """Where something is struck or seen."""

    link: str
    place: Float[np.ndarray, "3"]
    """In its frame [m]."""
    way: Float[np.ndarray, "3"]
    """Unit vector."""
    in_link: bool = False
    """Whether that is in the frame of the link, with which it turns, and not in the world."""


def in_world(
    spots: Iterable[Spot], assembly: Assembly
) -> list[tuple[str, Float[np.ndarray, "3"], Float[np.ndarray, "*posture 3"]]]:
    """Link, place and direction in the world, as `Assembly.rows` takes them.

    Args:
        spots: where.
        assembly: of one posture or several; a direction in a link turns with them.
    """
    return [
        (one.link, one.place, assembly.axes(one.link) @ one.way if one.in_link else one.way) for one in spots
    ]


def spot_of(point: CampaignPoint, direction: int) -> Spot:
    """A direction ±1 ±2 ±3 at a point, along the point's own axes.

    Args:
        point: of the campaign.
        direction: ±1 ±2 ±3 for ±x ±y ±z.
    """
    way = point.rows()[abs(direction) - 1] * np.sign(direction)
    return Spot(point.link, np.array(point.xyz), way, point.frame == "link")


def places_of(campaign: Campaign, given: Iterable[Sequence[int]]) -> list[Spot]:
    """Where point ids and directions are.

    Args:
        campaign: with the points.
        given: pairs of the id of a point and a direction.
    """
    return [spot_of(campaign.point(int(number)), int(direction)) for number, direction in given]
