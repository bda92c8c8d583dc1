"""Mishaps: each takes a campaign with its blows and gives the one that would have come out instead.

They are done to the time records; the FRFs are estimated anew from these, so that both tell the same story,
but for the mishap that consists in their not doing so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from flexmodal.campaign import Campaign, estimate_frfs
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.rig.laboratory import channels, labels

Spoil = Callable[[Campaign, np.random.Generator], tuple[Campaign, str]]


@dataclass(frozen=True)
class Mishap:
    """One thing that went wrong."""

    kind: str
    """One of `MISHAPS`."""
    where: str
    """What it was done to, in words."""


MISHAPS: Mapping[str, Spoil] = MappingProxyType(
    {
        "sign": labels.sign,
        "axes swapped": labels.axes,
        "points swapped": labels.points,
        "hammer positions swapped": labels.hammers,
        "scale": labels.gravity,
        "sensitivity": labels.sensitivity,
        "postures exchanged": labels.postures,
        "joint sign": labels.joint_sign,
        "axes in another frame": labels.frames,
        "degrees for radians": labels.degrees,
        "double hit": channels.double_hit,
        "AC coupling": channels.coupled_response,
        "AC coupled force": channels.coupled_force,
        "overload": channels.overload,
        "drift": channels.drift,
        "FRFs against blows": channels.other_frfs,
    }
)
"""By name: the campaign that comes out of it, and what it was done to."""
LAST = "FRFs against blows"


def with_mishaps(campaign: Campaign, kinds: Sequence[str], seed: int) -> tuple[Campaign, tuple[Mishap, ...]]:
    """Let things go wrong, one after the other.

    Args:
        campaign: with its blows.
        kinds: of `MISHAPS`.
        seed: of places and sizes.

    Returns:
        What would have been measured, and what was done; a mishap that has no place in this campaign (two
        axes where one is measured) is left out.

    Raises:
        InvalidRequest: an unknown mishap, or a campaign without blows.
    """
    unknown = [kind for kind in kinds if kind not in MISHAPS]
    if unknown:
        raise InvalidRequest(
            [Fault("call", "kinds", repr(kind), f"some of {', '.join(MISHAPS)}") for kind in unknown]
        )
    if not campaign.blows:
        raise InvalidRequest(Fault("call", "campaign", "no blows", "a campaign with its time records"))
    random, done = np.random.default_rng([seed, 61]), []
    for kind in sorted(kinds, key=lambda one: one == LAST):
        spoilt, where = MISHAPS[kind](campaign, random)
        if where:
            campaign = spoilt if kind == LAST else _estimated(spoilt)
            done.append(Mishap(kind, where))
    return campaign, tuple(done)


def draw_mishaps(count: int, seed: int) -> tuple[str, ...]:
    """So many different mishaps.

    Args:
        count: how many.
        seed: of the choice.
    """
    random = np.random.default_rng([seed, 62])
    return tuple(str(one) for one in random.choice(list(MISHAPS), size=count, replace=False))


def _estimated(campaign: Campaign) -> Campaign:
    """With the FRFs of its blows."""
    return replace(campaign, frfs=estimate_frfs(replace(campaign, frfs=None), estimator="H1"))
