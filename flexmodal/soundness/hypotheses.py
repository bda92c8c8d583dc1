"""The errors that are looked for: sign, axes, places, scale, angles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Int

from flexmodal.identification import Observations
from flexmodal.soundness.finding import FindingKind
from flexmodal.soundness.readings import Framed, other_frame, with_angles
from flexmodal.soundness.suspicion import EVERYWHERE, Hypothesis, scopes

GRAVITY = 9.80665
TURN = 2 * math.pi + 0.1
"""Angles beyond are none that a joint is set to [rad]."""
FACTORS: Mapping[float, str] = {
    GRAVITY: "too small some ten times, as in g for m/s², or with the mV/g of another sensor",
    1 / GRAVITY: "too large some ten times, as by 9.81 once too often, or with the mV/g of another sensor",
    1000.0: "a thousand times too small: mV for V",
    0.001: "a thousand times too large: V for mV",
}
"""What records are multiplied by, and what that would mean."""


def record_hypotheses(observations: Observations) -> list[Hypothesis]:
    """Signs, swaps and scales, those about more records first.

    Args:
        observations: what was measured.
    """
    found: list[Hypothesis] = []
    channels = [tuple(map(int, one)) for one in np.unique(observations.response, axis=0)]
    hammers = [tuple(map(int, one)) for one in np.unique(observations.reference, axis=0)]
    every = np.flatnonzero(observations.used.any(axis=1))
    for factor, meaning in FACTORS.items():
        found.append(Hypothesis("scale", f"every record: {meaning}", every, factor=factor))
    for scope, inside in scopes(observations):
        for point, direction in channels:
            here = inside & np.all(observations.response == (point, direction), axis=1)
            name = observations.direction(np.array([point, direction]))
            found.append(Hypothesis("sign", f"{name} in {scope}", np.flatnonzero(here), factor=-1.0))
            for factor, meaning in FACTORS.items():
                where = f"{name} in {scope}: {meaning}"
                found.append(Hypothesis("scale", where, np.flatnonzero(here), factor=factor))
        for place in hammers:
            here = inside & np.all(observations.reference == place, axis=1)
            name = observations.direction(np.array(place))
            where = f"the hammer at {name} in {scope}"
            found.append(Hypothesis("sign", where, np.flatnonzero(here), factor=-1.0))
        found += _swaps(observations, scope, inside, channels, hammers)
    return found


def _swaps(
    observations: Observations,
    scope: str,
    inside: Bool[np.ndarray, " observation"],
    channels: list[tuple[int, ...]],
    hammers: list[tuple[int, ...]],
) -> Iterator[Hypothesis]:
    """Axes at a point, points, and hammer positions taken for each other."""
    name = observations.direction
    points = list(dict.fromkeys(point for point, _ in channels))
    for point in points:
        for one, other in combinations([d for p, d in channels if p == point], 2):
            where = f"{name([point, one])} and {name([point, other])} in {scope}"
            swap = {(point, one): (point, other), (point, other): (point, one)}
            yield from _swapped(observations, "axes swapped", where, inside, swap, hammer=False)
    for one, other in combinations(points, 2):
        shared = {d for p, d in channels if p == one} & {d for p, d in channels if p == other}
        names = [observations.campaign.point(p).name for p in (one, other)]
        swap = {(one, d): (other, d) for d in shared} | {(other, d): (one, d) for d in shared}
        where = f"{names[0]} and {names[1]} in {scope}"
        yield from _swapped(observations, "points swapped", where, inside, swap, hammer=False)
    for first, second in combinations(hammers, 2):
        where = f"{name(first)} and {name(second)} in {scope}"
        swap = {first: second, second: first}  # type: ignore[dict-item]
        yield from _swapped(observations, "hammer positions swapped", where, inside, swap, hammer=True)


def _swapped(
    observations: Observations,
    kind: FindingKind,
    where: str,
    inside: Bool[np.ndarray, " observation"],
    swap: Mapping[tuple[int, int], tuple[int, int]],
    *,
    hammer: bool,
) -> Iterator[Hypothesis]:
    """One hypothesis, if every record that it is about has its counterpart."""
    keys = {_key(observations, row): row for row in range(len(observations))}
    rows: list[int] = []
    others: list[int] = []
    for row in np.flatnonzero(inside).tolist():
        posture, response, reference, level = _key(observations, row)
        place = reference if hammer else response
        if place not in swap:
            continue
        key = (posture, response, swap[place], level) if hammer else (posture, swap[place], reference, level)
        if key in keys:
            rows.append(row)
            others.append(keys[key])
    if rows:
        compared: Int[np.ndarray, " some"] = np.array(others)
        yield Hypothesis(kind, where, np.array(rows), compared=compared)


def _key(observations: Observations, row: int) -> tuple[int, tuple[int, int], tuple[int, int], int]:
    response, reference = (
        (int(place[row, 0]), int(place[row, 1])) for place in (observations.response, observations.reference)
    )
    return int(observations.posture[row]), response, reference, int(observations.level[row])


def angle_hypotheses(observations: Observations) -> list[Hypothesis]:
    """Angles of other postures, signs of joints, degrees for radians.

    Args:
        observations: what was measured.
    """
    postures, count = observations.postures, len(observations.postures)
    found = []
    there = observations.used.any(axis=1)
    rows = [np.flatnonzero(there & (observations.posture == number)) for number in range(count)]
    every = np.flatnonzero(there)
    for one, other in combinations(range(count), 2):
        where = f"{postures[one].name} and {postures[other].name}"
        both = np.concatenate([rows[one], rows[other]])
        steps = np.repeat([other - one, one - other], [len(rows[one]), len(rows[other])]) % count
        found.append(Hypothesis("postures exchanged", where, both, offset=steps))
    for joint in dict.fromkeys(name for posture in postures for name in posture.q):
        found.append(Hypothesis("joint sign", f"{joint} in {EVERYWHERE}", every, turned=joint))
        for number, posture in enumerate(postures):
            if posture.q.get(joint):
                where = f"{joint} in posture {posture.name}"
                found.append(Hypothesis("joint sign", where, rows[number], turned=joint))
    found.append(Hypothesis("degrees for radians", "all postures", every, in_degrees=True))
    for number, posture in enumerate(postures):
        where = f"posture {posture.name}"
        found.append(Hypothesis("degrees for radians", where, rows[number], in_degrees=True))
    return found


def frame_hypotheses(observations: Observations) -> list[Hypothesis]:
    """Axes that turn with the link and are stated in the world, or the other way round.

    Of all points together, of each, and where a point was both struck and sensed of its sensor or its hammer
    alone.

    Args:
        observations: what was measured.
    """
    campaign = observations.campaign
    there: Bool[np.ndarray, " observation"] = np.asarray(observations.used.any(axis=1))
    seen = dict.fromkeys(observations.response[there, 0].tolist())
    struck = dict.fromkeys(observations.reference[there, 0].tolist())
    points = [one for one in campaign.points if one.id in {*seen, *struck}]
    found = []
    if len(points) > 1 and len({one.frame for one in points}) == 1:
        axes = "the world" if points[0].frame == "link" else "their links"
        every: list[Framed] = [(one, "sensor") for one in seen]
        every += [(one, "hammer") for one in struck]
        found.append(_framed(observations, f"every point: the axes are those of {axes}", every, there))
    for point in points:
        axes = "the world" if other_frame(point) == "world" else point.link
        parts: list[Framed] = [(point.id, "sensor")] if point.id in seen else []
        parts += [(point.id, "hammer")] if point.id in struck else []
        where = f"{point.name}: the axes are those of {axes}"
        found.append(_framed(observations, where, parts, there))
        for part in parts if len(parts) > 1 else []:
            where = f"the {part[1]} at {point.name}: the axes are those of {axes}"
            found.append(_framed(observations, where, [part], there))
    return found


def _framed(
    observations: Observations, where: str, framed: list[Framed], there: Bool[np.ndarray, " observation"]
) -> Hypothesis:
    """One hypothesis, about the records of these sensors and hammers."""
    places = {"sensor": observations.response[:, 0], "hammer": observations.reference[:, 0]}
    here = np.any([places[what] == point for point, what in framed], axis=0) & there
    return Hypothesis("axes in another frame", where, np.flatnonzero(here), framed=tuple(framed))


def in_radians(observations: Observations) -> Observations | None:
    """With angles taken for degrees where most postures have one of more than a turn; None elsewhere.

    Args:
        observations: what was measured.
    """
    stated = [dict(one.q) for one in observations.postures]
    beyond = [any(abs(value) > TURN for value in q.values()) for q in stated]
    if not sum(beyond) > len(beyond) / 2:
        return None
    angles = [{joint: math.radians(value) for joint, value in q.items()} for q in stated]
    return with_angles(observations, angles)
