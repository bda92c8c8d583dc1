"""Labels and scales that are wrong: senses, axes, places, sensitivities, angles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.campaign import Blow, Campaign, place_text
from flexmodal.rig.laboratory.draws import channels, posture_or_all, some_channel
from flexmodal.text.words import listing

GRAVITY = 9.80665


def sign(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One channel upside down, in one posture or in all.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    place, posture = some_channel(campaign, random), posture_or_all(campaign, random)
    return _scaled(campaign, place, posture, -1.0), f"{place_text(place)}{_said(posture)}"


def axes(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Two axes of a sensor exchanged; nothing where one is measured.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    every = channels(campaign)
    several = [p for p, d in every if sum(q == p for q, _ in every) > 1]
    if not several:
        return campaign, ""
    point = int(random.choice(several))
    one, other = (int(d) for d in random.choice([d for p, d in every if p == point], 2, replace=False))
    posture = posture_or_all(campaign, random)
    swap = {(point, one): (point, other), (point, other): (point, one)}
    return _relabelled(
        campaign, swap, posture
    ), f"{place_text((point, one))} and {place_text((point, other))}"


def points(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Two points exchanged in one posture or in all; nothing where there is one.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    ids = sorted({p for p, _ in channels(campaign)})
    if len(ids) < 2:
        return campaign, ""
    one, other = (int(p) for p in random.choice(ids, 2, replace=False))
    posture = posture_or_all(campaign, random)
    swap = {(a, d): (b, d) for a, b in ((one, other), (other, one)) for d in (1, 2, 3)}
    return _relabelled(campaign, swap, posture), f"points {one} and {other}{_said(posture)}"


def hammers(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Two hammer positions exchanged in one posture or in all; nothing where there is one.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    places = list(dict.fromkeys(blow.reference for blow in campaign.blows))
    if len(places) < 2:
        return campaign, ""
    swap = {places[0]: places[1], places[1]: places[0]}
    posture = posture_or_all(campaign, random)
    blows = tuple(
        replace(blow, reference=swap.get(blow.reference, blow.reference))
        if posture in (None, blow.posture)
        else blow
        for blow in campaign.blows
    )
    where = f"{place_text(places[0])} and {place_text(places[1])}{_said(posture)}"
    return replace(campaign, blows=blows), where


def gravity(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Every acceleration in g.

    Args:
        campaign: as it should be.
        random: not needed.
    """
    return _scaled(campaign, None, None, 1 / GRAVITY), "every response"


def sensitivity(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One channel with the sensitivity of another sensor: 10 for 100 mV/g, or the other way round.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    place, factor = some_channel(campaign, random), float(random.choice([0.1, 10.0]))
    return _scaled(campaign, place, None, factor), place_text(place)


def postures(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Two postures bear each other's angles; nothing where there is one.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    if len(campaign.postures) < 2:
        return campaign, ""
    one, other = (int(k) for k in random.choice(len(campaign.postures), 2, replace=False))
    listed = list(campaign.postures)
    first, second = listed[one], listed[other]
    listed[one], listed[other] = replace(first, q=second.q), replace(second, q=first.q)
    return replace(campaign, postures=tuple(listed)), f"{first.name} and {second.name}"


def frames(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Axes of one point, or as often of all, said to be fixed to the other of world and link.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    used = {p for blow in campaign.blows for p, _ in (blow.reference, *blow.channels)}
    points = [point for point in campaign.points if point.id in used]
    wrong = points if random.random() < 0.5 else [points[int(random.integers(len(points)))]]
    ids = {point.id for point in wrong}
    listed = tuple(
        replace(one, frame="world" if one.frame == "link" else "link") if one.id in ids else one
        for one in campaign.points
    )
    return replace(campaign, points=listed), listing(point.name for point in wrong)


def joint_sign(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One joint counted the other way, in all postures.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    joints = sorted({name for one in campaign.postures for name in one.q})
    least = {name: np.median([abs(one.q.get(name, 0.0)) for one in campaign.postures]) for name in joints}
    large = [name for name in joints if least[name] > 0.2]
    if not large:
        return campaign, ""
    joint = str(random.choice(large))
    return _angles(campaign, lambda q: {**q, joint: -q.get(joint, 0.0)}), joint


def degrees(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Angles typed in degrees.

    Args:
        campaign: as it should be.
        random: not needed.
    """
    return _angles(campaign, lambda q: {name: math.degrees(one) for name, one in q.items()}), "all postures"


def _angles(campaign: Campaign, change: Callable[[dict[str, float]], dict[str, float]]) -> Campaign:
    listed = tuple(replace(one, q=change(dict(one.q))) for one in campaign.postures)
    return replace(campaign, postures=listed)


def _said(posture: int | None) -> str:
    return "" if posture is None else f" in posture {posture}"


def _scaled(
    campaign: Campaign, place: tuple[int, int] | None, posture: int | None, factor: float
) -> Campaign:
    def change(blow: Blow) -> Blow:
        if posture not in (None, blow.posture):
            return blow
        factors = np.array([factor if place in (None, one) else 1.0 for one in blow.channels])
        return replace(blow, response=blow.response * factors[:, None])

    return replace(campaign, blows=tuple(change(blow) for blow in campaign.blows))


def _relabelled(
    campaign: Campaign, swap: dict[tuple[int, int], tuple[int, int]], posture: int | None
) -> Campaign:
    def change(blow: Blow) -> Blow:
        if posture not in (None, blow.posture):
            return blow
        return replace(blow, channels=tuple(swap.get(one, one) for one in blow.channels))

    return replace(campaign, blows=tuple(change(blow) for blow in campaign.blows))
