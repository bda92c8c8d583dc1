"""Which posture and which channel a mishap meets, at random."""

from __future__ import annotations

import numpy as np

from flexmodal.campaign import Campaign


def some_posture(campaign: Campaign, random: np.random.Generator) -> int:
    """The id of one of the postures.

    Args:
        campaign: with its postures.
        random: what is drawn from.
    """
    return campaign.postures[int(random.integers(len(campaign.postures)))].id


def posture_or_all(campaign: Campaign, random: np.random.Generator) -> int | None:
    """The id of a posture, or as often None for all of them.

    Args:
        campaign: with its postures.
        random: what is drawn from.
    """
    return None if random.random() < 0.5 else some_posture(campaign, random)


def channels(campaign: Campaign, posture: int | None = None) -> list[tuple[int, int]]:
    """Places whose response was recorded, in a posture or in any.

    Args:
        campaign: with its blows.
        posture: its id.
    """
    here = [blow for blow in campaign.blows if posture in (None, blow.posture)]
    return list(dict.fromkeys(place for blow in here for place in blow.channels))


def some_channel(
    campaign: Campaign, random: np.random.Generator, posture: int | None = None
) -> tuple[int, int]:
    """One of these places.

    Args:
        campaign: with its blows.
        random: what is drawn from.
        posture: its id.
    """
    every = channels(campaign, posture)
    return every[int(random.integers(len(every)))]
