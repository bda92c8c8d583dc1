"""What nobody set up exactly, as variance of what was measured.

Angles of a posture, places and directions of hammer and sensor, and gains are off by so much (`[tolerance]`
of a campaign). To first order each changes ln H by its derivative, and adds the square of that to the
relative variance of every line (JCGM 100, Guide to the expression of uncertainty in measurement, 5.1).
Errors of neighbouring lines are one error and not many; that is left to the autocorrelation of residuals, by
which evidence is discounted.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.campaign import Axes, CampaignPoint, Tolerance
from flexmodal.identification.frf_fit import fit
from flexmodal.identification.model import RobotModel, predict
from flexmodal.identification.observations import Observations, unlimited
from flexmodal.identification.sensitivities import moved
from flexmodal.identification.setting_up import Beside, SetUp, set_up
from flexmodal.model import Robot
from flexmodal.structure import ParameterSpace, robot_space

MOST = 1.0
"""Relative variance that one cause adds at most: beyond, at antiresonances, first order says nothing."""
_STEP = 0.1
"""Of the differences, in standard deviations."""


LOOKED_AT = 80
"""Lines by which it is seen what was not set up as it is said."""
FLOORS, STEPS = (0.2, 0.05, 0.02), 6
"""Model errors of the fit before, and its steps at each: it only has to come near."""


def as_set_up(
    observations: Observations,
    robot: Robot,
    space: ParameterSpace,
    held: Bool[np.ndarray, " observation"] | None = None,
    *,
    far: bool = True,
    in_sample: bool = False,
) -> SetUp:
    """The observations as they were most likely set up, with the variance of what is open still.

    Args:
        observations: of a campaign, as it says that it was set up.
        robot: as its card says.
        space: its parameters, which are fitted along.
        held: what is held out, by which nothing is moved; nothing if None.
        far: see `set_up`.
        in_sample: see `set_up_beside`.

    Returns:
        The same observations where everything is exact.
    """
    if observations.campaign.tolerance.is_exact:
        return SetUp(observations)
    away = np.zeros(len(observations), dtype=bool) if held is None else held
    wide = with_tolerance(observations, robot)
    lines = _looked_at(observations)
    model = RobotModel(robot, space)
    tuned = fit(model, wide.keeping(~away), floors=FLOORS, steps=STEPS, lines=lines, apart=False)
    beside = Beside(model, tuned.x)
    return set_up_beside(beside, observations, wide, robot, away, far=far, in_sample=in_sample)


def set_up_beside(
    beside: Beside,
    observations: Observations,
    wide: Observations,
    robot: Robot,
    held: Bool[np.ndarray, " observation"],
    *,
    far: bool = True,
    in_sample: bool = False,
) -> SetUp:
    """How it was most likely set up by a model that was fitted.

    Args:
        beside: what was fitted.
        observations: as they are said to have been set up; variances of noise alone.
        wide: the same with the variance of the tolerances.
        robot: as its card says.
        held: what is held out, by which nothing is moved.
        far: see `set_up`.
        in_sample: whether the variance is that of what a right model leaves that is fitted to these
            observations, which is noise: what was off was moved, and what is open nonetheless does not show.
            Of what is held out the angles of the postures are open, as the campaign says, and what else is
            after all. Without it what is open still counts everywhere, and of what is held out all that the
            campaign says.
    """
    lines = _looked_at(observations)
    seen, plain = wide.keeping(~held), observations.keeping(~held)
    own = beside if beside.factor is None else replace(beside, factor=beside.factor[~held])
    found = set_up(own, plain, lines, seen.variance - plain.variance, far=far)
    now, given, left = moved(observations, found.settings), observations.campaign.tolerance, found.left
    assert left is not None
    variance = now.variance if in_sample else with_tolerance(now, robot, left).variance
    if held.any():
        apart = replace(left, posture=given.posture) if in_sample else given
        variance = np.where(held[:, None], with_tolerance(now, robot, apart).variance, variance)
    return replace(found, observations=replace(now, variance=variance))


def _looked_at(observations: Observations) -> Int[np.ndarray, " looked"]:
    return np.arange(0, len(observations.axis), max(1, len(observations.axis) // LOOKED_AT))


def with_tolerance(observations: Observations, robot: Robot, given: Tolerance | None = None) -> Observations:
    """The observations with the variance of what was not set up exactly.

    Args:
        observations: of a campaign.
        robot: as its card says; its FRFs give the derivatives.
        given: how well it was set up; as the campaign says if None.

    Returns:
        The same observations where everything is exact.
    """
    given = observations.campaign.tolerance if given is None else given
    if given.is_exact:
        return observations
    variance = observations.variance + 2 * given.gain**2
    model = RobotModel(robot, robot_space(robot))
    x = np.zeros(len(model.space))
    endless = unlimited(observations)
    plain = predict(model, x, endless)
    for share, other, size in _shifted(endless, robot, given):
        change = np.log(_ratio(predict(model, x, other), plain)) / size
        variance = variance + np.minimum(share[:, None] * np.abs(change) ** 2, MOST)
    if given.direction:
        for other in _turned(endless):
            across = np.where(plain == 0, 0.0, predict(model, x, other) / np.where(plain == 0, 1.0, plain))
            variance = variance + np.minimum(np.abs(given.direction * across) ** 2, MOST)
    return replace(observations, variance=variance)


def _ratio(
    value: Complex[np.ndarray, "observation line"], plain: Complex[np.ndarray, "observation line"]
) -> Complex[np.ndarray, "observation line"]:
    """Value / plain; 1 where there is nothing to divide by."""
    there = (plain != 0) & (value != 0)
    return np.where(there, value / np.where(there, plain, 1.0), 1.0)


def _shifted(
    observations: Observations, robot: Robot, given: Tolerance
) -> Iterator[tuple[Float[np.ndarray, " observation"], Observations, float]]:
    """Observations with one thing off, a part of its deviation; the share each counts with, and that part.

    An error of a point that bears both hammer and sensor is two independent ones, half of the square of what
    both make together.
    """
    campaign = observations.campaign
    every = np.ones(len(observations))
    joints = robot.moving if given.posture else ()
    for joint in joints:
        step = _STEP * given.posture
        off = tuple(
            replace(one, q={**one.q, joint: one.q.get(joint, 0.0) + step}) for one in observations.postures
        )
        yield every, replace(observations, postures=off), _STEP
    for point in campaign.points if given.position else ():
        struck, seen = (place[:, 0] == point.id for place in (observations.reference, observations.response))
        if not (struck | seen).any():
            continue
        for axis in range(3):
            xyz = np.array(point.xyz) + _STEP * given.position * np.eye(3)[axis]
            moved = replace(point, xyz=(float(xyz[0]), float(xyz[1]), float(xyz[2])))
            points = tuple(moved if one is point else one for one in campaign.points)
            share = np.where(struck & seen, 0.5, (struck | seen) * 1.0)
            yield share, replace(observations, campaign=replace(campaign, points=points)), _STEP


def _turned(observations: Observations) -> Iterator[Observations]:
    """Sensor, then hammer, along either of two directions across its own.

    Those are directions 1, 2, 3 of points beside the campaign's that bear the axes across.
    """
    campaign, points = observations.campaign, observations.campaign.points
    taken = {point.id for point in points}
    free = (number for number in itertools.count(1) if number not in taken)
    longest = max(len(point.name) for point in points)
    number_of = {point.id: next(free) for point in points}
    for turn in (0, 1):
        beside = [
            replace(one, id=number_of[one.id], name=one.name.ljust(longest) + "′", axes=_across(one)[turn])
            for one in points
        ]
        both = replace(campaign, points=(*points, *beside), frfs=None, blows=(), modes=None)
        for name in ("response", "reference"):
            place = getattr(observations, name).copy()
            place[:, 0] = [number_of[int(point)] for point in place[:, 0]]
            yield replace(observations, campaign=both, **{name: place})


def _across(point: CampaignPoint) -> tuple[Axes, Axes]:
    """For each direction of a point two unit vectors across it and each other, in the frame of its axes."""
    both: tuple[list[tuple[float, float, float]], list[tuple[float, float, float]]] = ([], [])
    for way in point.rows():
        other = np.eye(3)[(int(np.argmax(np.abs(way))) + 1) % 3]
        first = other - (other @ way) * way
        first /= np.linalg.norm(first)
        for rows, found in zip(both, (first, np.cross(way, first)), strict=True):
            rows.append((float(found[0]), float(found[1]), float(found[2])))
    return (both[0][0], both[0][1], both[0][2]), (both[1][0], both[1][1], both[1][2])
