"""Parameters of shape: derivatives, the card that holds them, and the truth found back."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import FrozenDict, ObstacleCard
from flexmodal.errors import InvalidRequest
from flexmodal.identification import RobotModel, identify
from flexmodal.identification.improved import write_improved
from flexmodal.identification.spot import Spot
from flexmodal.model.placements import link_placements
from flexmodal.rig import simulate
from flexmodal.structure import robot_space
from flexmodal.structure.structure import Axis, receptance

ALL = ["stiffness", "damping", "mass", "inertia", "mass_centre", "payload"]
AXIS = Axis(np.array([2.0, 8.0, 30.0, 55.0, 120.0]), 15.0)
UP, ALONG = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])


def kinds_of(name):
    return [*ALL, "position"] if name == "fanuc_s360" else ALL


def drawn(name, tool=None, seed=3):
    """A space with every kind, and a place in it off the card."""
    robot = flexmodal.load(name, tool=tool)
    space = robot_space(robot, kinds_of(name))
    x = np.random.default_rng(seed).normal(0, 0.05, len(space))
    x[[k for k, n in enumerate(space.names) if n.startswith("payload")]] = 0.4
    return robot, space, x


def places_of(robot):
    points = [(one.link, np.array(one.xyz)) for one in list(robot.points.values())[:3]]
    return [Spot(link, place, UP) for link, place in points] + [Spot(*points[0], ALONG)]


@pytest.mark.parametrize("name", ["fanuc_s360", "six_axis"])
def test_derivatives_are_those_of_central_differences(name):
    robot, space, x = drawn(name)
    model, places = RobotModel(robot, space), places_of(robot)
    q = dict(next(iter(robot.postures.values())))
    pairs = np.array([[k, 0] for k in range(len(places))])

    def value(x, names=()):
        return receptance(model.structure_at(x, q, places, places[:1]), AXIS, pairs, names)

    _, slopes = value(x, space.names)
    step = 1e-6
    for k, parameter in enumerate(space.names):
        shift = step * np.eye(len(space))[k]
        numeric = (value(x + shift)[0] - value(x - shift)[0]) / (2 * step)
        # rounding of the receptance, 1e-13 of it, over the step
        np.testing.assert_allclose(slopes[k], numeric, atol=1e-5 * np.abs(slopes[k]).max(), err_msg=parameter)
        assert np.abs(slopes[k]).max() > 0, parameter


@pytest.mark.parametrize(("name", "tool"), [("fanuc_s360", None), ("six_axis", None), ("six_axis", "link_6")])
def test_the_written_robot_is_the_model(name, tool, tmp_path):
    """URDF, card and Pinocchio on one side, the assembly of bodies on the other; a tool with mass, too."""
    robot, space, x = drawn(name, tool)
    new = flexmodal.load(write_improved(robot, space.values(x), tmp_path / "robot", source="a test"))
    for q in list(robot.postures.values())[:3]:
        made = RobotModel(robot, space).structure_at(x, dict(q), [], [])
        found = new.at(dict(q))
        scale = np.abs(made.mass).max()
        np.testing.assert_allclose(found.system.mass, made.mass, rtol=1e-9, atol=1e-9 * scale)
        points = list(robot.points)[:3]
        placed = RobotModel(robot, space).structure_at(x, dict(q), places_of(robot)[:3], [])
        rows = found.rows(found.directions([f"{point}:+z" for point in points]))
        np.testing.assert_allclose(rows, placed.response, atol=1e-9)


def test_a_moved_pivot_leaves_obstacles_where_they_are(fanuc, tmp_path):
    """The link beyond the pseudo-joint has a new frame; what it carries stays in place."""
    carried = ObstacleCard(sphere=0.1, xyz=(0.3, 0.02, 0.0), link="link_2_outer")
    table = ObstacleCard(box=(1.0, 1.0, 0.1), xyz=(0.0, 0.0, -1.0))
    robot = replace(fanuc, obstacles=FrozenDict({"spindle": carried, "table": table}))
    path = write_improved(robot, {"position.rho": 0.06}, tmp_path / "robot", source="a test")
    new = flexmodal.load(path)
    assert new.obstacles["table"] == table
    assert new.families == fanuc.families
    before, after = (
        link_placements(arm, {})["link_2_outer"] @ [*arm.obstacles["spindle"].xyz, 1.0]
        for arm in (robot, new)
    )
    np.testing.assert_allclose(after, before, atol=1e-12)
    assert new.obstacles["spindle"].xyz != carried.xyz


@pytest.mark.slow
def test_pseudo_joint_and_payload_are_found(fanuc, tmp_path):
    truth = {"position.rho": 0.06, f"payload.{fanuc.tool}": 0.25, "stiffness.rho": 2.1e5}
    real = flexmodal.load(write_improved(fanuc, truth, tmp_path / "robot", source="a test"))
    made = simulate(real, postures=4, points=4, references=2, trials=2, parameter_error=0.0, seed=3)
    campaign = replace(made.campaign, blows=())
    space = robot_space(fanuc, ["stiffness", "damping", "position", "payload"])
    # the places where the sensors sit are the same, in the frames of the card
    points = tuple(replace(p, xyz=fanuc.points[p.name].xyz) for p in campaign.points)
    outcome = identify(replace(campaign, points=points), fanuc, space=space)
    assert outcome.over_noise < 1.2
    found = {one.name: one for one in outcome.estimates}
    for name, value in truth.items():
        assert found[name].identified, name
        assert abs(found[name].value - value) < 4 * found[name].standard_error, name
    assert found["position.rho"].standard_error < 0.005


def test_a_kind_that_a_robot_has_none_of_is_refused():
    with pytest.raises(InvalidRequest, match="'position', of which there is none"):
        robot_space(flexmodal.load("six_axis"), ["stiffness", "position"])
    with pytest.raises(InvalidRequest, match="'colour'"):
        robot_space(flexmodal.load("six_axis"), ["colour"])
