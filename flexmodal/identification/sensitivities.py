"""Nuisance parameters of a set-up, what each does to ln H, and observations with some of them moved.

One prediction serves a kind of parameter in all postures and at all points: an observation belongs to one
posture and has one sensor and one hammer point, so that shifting all alike tells what each alone does.
Sensors and hammer are told apart by points of their own, twins of the campaign's.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.campaign import Axes, Campaign, CampaignPoint
from flexmodal.identification.model import FrfModel, predict
from flexmodal.identification.observations import Observations, unlimited

Kind = Literal["posture", "position", "direction", "sensor gain", "hammer gain"]
_STEP = 0.1
"""Of the differences, in standard deviations."""
_MOST = 1.0
"""Largest change of ln H by one standard deviation that first order is trusted with."""


@dataclass(frozen=True)
class Nuisance:
    """One thing that was not set up exactly."""

    kind: Kind
    where: int
    """Id of the posture or point; 0 for the hammer's gain."""
    what: str
    """Joint, or direction x, y or z; empty for gains."""
    deviation: float
    """Its tolerance, one standard deviation [rad, m, 1]."""
    unit: str
    says: str
    """What it is, in words."""

    @property
    def axis(self) -> int:
        """0, 1 or 2 of a place or direction."""
        return "xyz".index(self.what)


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of ln H along every nuisance parameter of a set-up."""

    nuisances: tuple[Nuisance, ...]
    observations: Observations
    shared: dict[tuple[str, str], Complex[np.ndarray, "observation line"]]
    """By kind and what: of all postures, sensors or hammer points moved alike."""

    @classmethod
    def of(
        cls, model: FrfModel, x: np.ndarray, observations: Observations, lines: np.ndarray
    ) -> Sensitivities:
        """Of a model that was fitted.

        Args:
            model: of the robot.
            x: its coordinates.
            observations: whose campaign has tolerances.
            lines: numbers of those that are looked at.
        """
        endless = unlimited(observations)
        plain = {True: predict(model, x, endless, lines), False: predict(model, x, _doubled(endless), lines)}
        shared = {}
        for key, other, size in _shifted(model, endless):
            ratio = _ratio(predict(model, x, other, lines), plain[key[0] == "posture"])
            slope = np.log(ratio) / size
            shared[key] = np.where(np.abs(slope) * _deviation(observations.campaign, key) > _MOST, 0.0, slope)
        return cls(tuple(nuisances_of(observations)), observations, shared)

    @cached_property
    def deviations(self) -> Float[np.ndarray, " nuisance"]:
        """One standard deviation of each."""
        return np.array([one.deviation for one in self.nuisances])

    def weighed(self, root: Float[np.ndarray, "observation line"]) -> Complex[np.ndarray, "nuisance flat"]:
        """Every derivative times the roots of weights, one row each."""
        found = np.zeros((len(self.nuisances), *root.shape), dtype=complex)
        seen = self.observations
        for row, one in zip(found, self.nuisances, strict=True):
            if one.kind == "posture":
                here = _in_posture(seen, one.where)
                row[here] = self.shared["posture", one.what][here]
            elif one.kind in ("position", "direction"):
                for side, table in (("sensor", seen.response), ("hammer", seen.reference)):
                    here = table[:, 0] == one.where
                    row[here] += self.shared[f"{side} {one.kind}", one.what][here]
            else:  # a gain multiplies what was measured, and would have to multiply the model
                row[(seen.response[:, 0] == one.where) | (one.kind == "hammer gain")] = (
                    1.0  # the measured is divided by it
                )
        return (found * root).reshape(len(found), -1)


def nuisances_of(observations: Observations) -> Iterator[Nuisance]:
    """Everything that the tolerances of a campaign leave open and that was used.

    Args:
        observations: of the campaign.
    """
    campaign = observations.campaign
    given = campaign.tolerance
    sensed = set(observations.response[:, 0].tolist())
    used = sensed | set(observations.reference[:, 0].tolist())
    joints = {name: None for one in observations.postures for name in one.q}
    for posture in observations.postures if given.posture else ():
        for joint in joints:
            says = f"the angle of {joint} in {posture.name}"
            yield Nuisance("posture", posture.id, joint, given.posture, "rad", says)
    for point in campaign.points:
        if point.id not in used:
            continue
        for axis in "xyz" if given.position else "":
            says = f"the place of {point.name} along {axis} of {point.link}"
            yield Nuisance("position", point.id, axis, given.position, "m", says)
        for axis in "xyz" if given.direction else "":
            says = f"the direction at {point.name} about its {axis}"
            yield Nuisance("direction", point.id, axis, given.direction, "rad", says)
        if given.gain and point.id in sensed:
            yield Nuisance(
                "sensor gain", point.id, "", given.gain, "", f"the gain of the sensor at {point.name}"
            )
    if given.gain:
        yield Nuisance("hammer gain", 0, "", given.gain, "", "the gain of the hammer")


def moved(observations: Observations, settings: Sequence[tuple[Nuisance, float]]) -> Observations:
    """Observations as they are if nuisance parameters have these values.

    Args:
        observations: as they are said to have been set up.
        settings: parameters and values.
    """
    campaign = observations.campaign
    postures = {one.id: dict(one.q) for one in campaign.postures}
    points = {one.id: one for one in campaign.points}
    factor = np.ones(len(observations))
    for one, value in settings:
        if one.kind == "posture":
            q = postures[one.where]
            q[one.what] = q.get(one.what, 0.0) + value
        elif one.kind == "position":
            points[one.where] = _displaced(points[one.where], one.axis, value)
        elif one.kind == "direction":
            points[one.where] = _rotated(points[one.where], one.axis, value)
        elif one.kind == "sensor gain":
            factor[observations.response[:, 0] == one.where] *= np.exp(value)
        else:
            factor *= np.exp(value)
    told = tuple(replace(one, q=postures[one.id]) for one in campaign.postures)
    there = {one.id: one for one in told}
    records = replace(
        observations.records, value=observations.records.value / factor[observations.of_record][:, None]
    )
    return replace(
        observations,
        campaign=replace(campaign, postures=told, points=tuple(points[one.id] for one in campaign.points)),
        postures=tuple(there[one.id] for one in observations.postures),
        records=records,
        value=observations.value / factor[:, None],
    )


def _in_posture(observations: Observations, number: int) -> Bool[np.ndarray, " observation"]:
    return np.array([one.id == number for one in observations.postures])[observations.posture]


def _deviation(campaign: Campaign, key: tuple[str, str]) -> float:
    kind = key[0].rsplit(" ", 1)[-1]
    return float(getattr(campaign.tolerance, kind))


def _ratio(value: np.ndarray, plain: np.ndarray) -> np.ndarray:
    there = (plain != 0) & (value != 0)
    return np.where(there, value / np.where(there, plain, 1.0), 1.0)


def _shifted(
    model: FrfModel, observations: Observations
) -> Iterator[tuple[tuple[str, str], Observations, float]]:
    """Kind and what, observations with all of that kind moved, and by how much."""
    given = observations.campaign.tolerance
    joints = {name: None for one in observations.postures for name in one.q}
    for joint in joints if given.posture else ():
        step = _STEP * given.posture
        told = tuple(
            replace(one, q={**one.q, joint: one.q.get(joint, 0.0) + step}) for one in observations.postures
        )
        yield ("posture", joint), replace(observations, postures=told), step
    twins, number_of = _twins(observations.campaign)
    response = _renumbered(observations, number_of)
    for kind, change in (("position", _displaced), ("direction", _rotated)):
        step = _STEP * float(getattr(given, kind))
        for axis, name in enumerate("xyz" if step else ""):
            for side in ("sensor", "hammer"):
                own, other = observations.campaign.points, twins
                if side == "hammer":
                    own = tuple(change(one, axis, step) for one in own)
                else:
                    other = tuple(change(one, axis, step) for one in other)
                both = replace(observations.campaign, points=(*own, *other), frfs=None, blows=(), modes=None)
                yield (f"{side} {kind}", name), replace(observations, campaign=both, response=response), step


def _doubled(observations: Observations) -> Observations:
    """Seen by twins of the campaign's points, nothing moved.

    What sits on a sensor in a model does not sit on its twin, and is in none of both predictions so.
    """
    twins, number_of = _twins(observations.campaign)
    points = (*observations.campaign.points, *twins)
    both = replace(observations.campaign, points=points, frfs=None, blows=(), modes=None)
    return replace(observations, campaign=both, response=_renumbered(observations, number_of))


def _renumbered(observations: Observations, number_of: Mapping[int, int]) -> Int[np.ndarray, "observation 2"]:
    response = observations.response.copy()
    response[:, 0] = [number_of[int(number)] for number in response[:, 0]]
    return response


def _twins(campaign: Campaign) -> tuple[tuple[CampaignPoint, ...], dict[int, int]]:
    """Another point in each place, and their ids by those of the campaign's."""
    taken = {point.id for point in campaign.points}
    free = (number for number in itertools.count(1) if number not in taken)
    longest = max(len(point.name) for point in campaign.points)
    number_of = {point.id: next(free) for point in campaign.points}
    twins = tuple(
        replace(one, id=number_of[one.id], name=one.name.ljust(longest) + "′") for one in campaign.points
    )
    return twins, number_of


def _displaced(point: CampaignPoint, axis: int, way: float) -> CampaignPoint:
    xyz = np.array(point.xyz) + way * np.eye(3)[axis]
    return replace(point, xyz=(float(xyz[0]), float(xyz[1]), float(xyz[2])))


def _rotated(point: CampaignPoint, axis: int, angle: float) -> CampaignPoint:
    """A point whose directions are turned together about an axis of their frame."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[one, one] = turn[other, other] = np.cos(angle)
    turn[other, one], turn[one, other] = np.sin(angle), -np.sin(angle)
    rows = (point.rows() @ turn.T).tolist()
    axes: Axes = (tuple(rows[0]), tuple(rows[1]), tuple(rows[2]))
    return replace(point, axes=axes)
