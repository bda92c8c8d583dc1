"""Directions in the frame of a link: the same numbers as in the world, by another way of saying them."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, FrfRecords, Tolerance, Trial
from flexmodal.identification import RobotModel, identify, observe, predict
from flexmodal.identification.tolerance import with_tolerance
from flexmodal.model.placements import link_placements
from flexmodal.rig import simulate
from flexmodal.structure import robot_space

LINES = np.linspace(4.0, 60.0, 57)
ASLANT = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0].T


@pytest.fixture(scope="module")
def arm():
    return flexmodal.load("six_axis")


def orientation(robot, q, link):
    return link_placements(robot, q)[link][:3, :3]


def triaxial(robot, *, frame, rows=None):
    """A triaxial sensor and a hammer on two points, all directions: FRFs of the robot's own receptances.

    Along the world's axes by `Robot.frf`, then turned by hand to those of the sensor.
    """
    rows = np.eye(3) if rows is None else rows
    poses = list(robot.postures.values())[:2]
    places = list(robot.points.items())[-2:]
    records, labels = [], []
    for posture, q in enumerate(poses, start=1):
        names = [f"{name}:+{axis}" for name, _ in places for axis in "xyz"]
        value = robot.frf(dict(q), LINES, response=names, reference=names).value
        whole = np.zeros((6, 6))
        for k, (_, one) in enumerate(places):
            turn = orientation(robot, q, one.link).T if frame == "link" else np.eye(3)
            whole[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = rows @ turn
        turned = whole @ value @ whole.T
        for r in range(6):
            for s in range(3):  # the hammer on the first point alone
                records.append(turned[:, r, s])
                labels.append((posture, r // 3 + 1, r % 3 + 1, 1, s + 1))
    table = np.array(labels)
    frfs = FrfRecords(
        LINES, np.array(records), np.full((len(records), len(LINES)), 0.9999), table[:, 0],
        np.ones(len(table), dtype=int), table[:, 1:3], table[:, 3:5], "receptance",
        trials=(Trial(1, 100.0, 3, "soft"),),
    )  # fmt: skip
    axes = tuple(tuple(map(float, row)) for row in rows)
    points = tuple(
        CampaignPoint(n, name, one.link, tuple(one.xyz), axes, frame)
        for n, (name, one) in enumerate(places, start=1)
    )
    return Campaign(
        "triaxial", robot.name, (LINES[0], LINES[-1]),
        tuple(CampaignPosture(n, f"p{n}", dict(q)) for n, q in enumerate(poses, start=1)),
        points, (Trial(1, 100.0, 3, "soft"),), frfs,
    )  # fmt: skip


@pytest.mark.parametrize("frame", ["world", "link"])
def test_receptances_are_the_robots_turned_by_hand(arm, frame):
    """Two routes: `Robot.frf` along the world's axes and a rotation, and the model of an identification."""
    campaign = triaxial(arm, frame=frame, rows=ASLANT)
    seen = observe(campaign)
    model = RobotModel(arm, robot_space(arm))
    found = predict(model, np.zeros(len(model.space)), seen)
    size = np.abs(seen.value).max(axis=1, keepdims=True)
    # an entry may be a small difference of large ones: 1e-12 of the largest
    np.testing.assert_allclose(found / size, seen.value / size, atol=1e-9)


def test_it_turns_with_the_posture(arm):
    """The same labels, world and link, are different numbers where the link is turned."""
    world, link = (observe(triaxial(arm, frame=frame)).value for frame in ("world", "link"))
    assert np.median(np.abs(np.log(np.abs(link / world)))) > 0.2


@pytest.fixture(scope="module")
def struck():
    """A planar arm struck along the axes of its links, sensor and hammer."""
    return simulate(
        flexmodal.load("fanuc_s360"), postures=["configuration_1", "configuration_3", "configuration_7"],
        points=2, references=2, trials=2, averages=2, peaks=(100.0,), band=(2.0, 120.0), axes="z",
        frame="link", record_length=1.5, seed=6, time=False,
    )  # fmt: skip


def described_otherwise(campaign, robot):
    """The same data with the axes of each link stated in the world: a point for every posture it was in."""
    points, number_of = [], {}
    for posture in campaign.postures:
        for point in campaign.points:
            turn = orientation(robot, dict(posture.q), point.link).T
            rows = tuple(tuple(map(float, row)) for row in turn)
            number_of[posture.id, point.id] = len(points) + 1
            name = f"{point.name} in {posture.id}"
            points.append(CampaignPoint(len(points) + 1, name, point.link, point.xyz, rows, "world"))
    frfs = campaign.frfs

    def renumbered(places):
        found = places.copy()
        pairs = zip(frfs.posture.tolist(), places[:, 0].tolist(), strict=True)
        found[:, 0] = [number_of[pair] for pair in pairs]
        return found

    moved = replace(frfs, response=renumbered(frfs.response), reference=renumbered(frfs.reference))
    return replace(campaign, points=tuple(points), frfs=moved)


def test_in_the_link_or_in_the_world_the_same_is_identified(struck):
    robot, campaign = flexmodal.load("fanuc_s360"), struck.campaign
    assert all(point.frame == "link" for point in campaign.points)
    hold = {"hold_out": ["configuration_7"]}
    one, other = (identify(each, robot, **hold) for each in (campaign, described_otherwise(campaign, robot)))
    np.testing.assert_allclose(one.at, other.at, atol=1e-9)
    assert one.gap.after == pytest.approx(other.gap.after, rel=1e-9)
    true = np.array([np.log(struck.truth.factors[name]) for name in one.problem.space.names])
    error = np.abs(one.at - true)[[name.startswith("stiffness") for name in one.problem.space.names]]
    # stiffness over mass is what the FRFs tell; the card is 5 % off
    assert error.max() < 0.1
    believed = replace(campaign, points=tuple(replace(p, frame="world") for p in campaign.points))
    assert identify(believed, robot, **hold).gap.after > 3 * one.gap.after


def test_tolerance_of_direction_is_across_whatever_the_axes(arm):
    """The same sensor by two sets of axes, those of the second rolled by one: the same variance."""
    found = []
    for shift in (0, 1):
        campaign = triaxial(arm, frame="link", rows=np.roll(np.eye(3), shift, axis=0))
        seen = observe(replace(campaign, tolerance=Tolerance(direction=0.01)))
        more = with_tolerance(seen, arm).variance - seen.variance
        x, z = (np.array([1, (axis + shift) % 3 + 1]) for axis in (0, 2))
        here = np.all(seen.response == x, axis=1) & np.all(seen.reference == z, axis=1)
        found.append(more[here])
    assert found[0].shape == (2, len(LINES))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6)
