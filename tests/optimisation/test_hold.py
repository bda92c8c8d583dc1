import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidPoint, InvalidRequest
from flexmodal.model import Robot
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective

from ..model.writing import body, joint, save
from .optimality import difference, directions

STATIC = ReceptanceObjective(directions("tool:+z"), np.array([0.0]))


def problem(robot: Robot, target: tuple[float, ...], point: str | None = None) -> PostureProblem:
    objective = ReceptanceObjective(directions(f"{robot.tool}:+z"), np.array([0.0]))
    return PostureProblem(robot, objective, Hold.at(robot, target, point))


def test_two_or_three_coordinates_of_a_planar_chain(arm):
    two, three = Hold.at(arm, (-2.0, 2.0)), Hold.at(arm, (-2.0, 0.0, 2.0))
    posed = arm.at("f2_final")
    np.testing.assert_allclose(two.error(posed), three.error(posed), atol=1e-15)
    x, _, z = posed.position("tool")
    np.testing.assert_allclose(two.error(posed), [x + 2, z - 2], atol=1e-15)


def test_out_of_the_plane(arm):
    with pytest.raises(InvalidRequest, match=r"0\.1 m out of the plane"):
        Hold.at(arm, (-2.0, 0.1, 2.0))


@pytest.mark.parametrize("target", [(), (1.0,), (1.0, 2.0, 3.0, 4.0)])
def test_wrong_number_of_coordinates(arm, ur5, target):
    with pytest.raises(InvalidRequest, match="2 or 3 coordinates"):
        Hold.at(arm, target)
    with pytest.raises(InvalidRequest, match="3 coordinates"):
        Hold.at(ur5, (*target, 1.0, 1.0)[:2])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(arm, value):
    with pytest.raises(InvalidRequest, match="finite"):
        Hold.at(arm, (value, 1.0))


def test_unknown_point(arm):
    with pytest.raises(InvalidPoint, match="did you mean joint_"):
        Hold.at(arm, (1.0, 1.0), "joint5")


def test_another_point_can_be_held(arm):
    held = problem(arm, (2.0, 1.0), "joint_5")
    values = held.retract(np.full(6, 0.3))
    np.testing.assert_allclose(held.posed(values).position("joint_5")[[0, 2]], [2, 1], atol=1e-9)


@pytest.mark.parametrize("name", ["six_link", "fanuc_s360", "ur5"])
def test_jacobian_of_the_error(robots, name):
    robot = robots[name]
    held = problem(robot, (0.5, 0.4) if robot.is_planar else (0.5, 0.1, 0.4))
    values = np.full(len(held.names), 0.4)
    error, jacobian = held.held(values)
    assert error.shape == ((2,) if robot.is_planar else (3,))
    expected = difference(lambda v: held.held(v)[0], values, 1e-3)
    np.testing.assert_allclose(jacobian, expected, atol=1e-11)  # rounding: 1e-16 × 6 m / 1e-3


@pytest.mark.parametrize(
    ("name", "target"), [("six_link", (-2.0, 2.0)), ("tight", (2.0, 3.0)), ("ur5", (0.4, 0.2, 0.3))]
)
def test_retraction(request, name, target):
    """Onto the target within 1e-9 m (it stops at 1e-10), inside the limits, from anywhere it can at all."""
    robot = request.getfixturevalue({"six_link": "arm"}.get(name, name))
    held, generator = problem(robot, target), np.random.default_rng(41)
    arrived = 0
    for _ in range(40):
        start = held.random_vector(generator)
        assert np.all((held.lower <= start) & (start <= held.upper))
        values = held.retract(start)
        if values is None:
            continue
        arrived += 1
        assert np.linalg.norm(held.held(values)[0]) <= 1e-9
        assert np.all((held.lower <= values) & (values <= held.upper))
        np.testing.assert_array_equal(held.retract(values), values)
    assert arrived >= (20 if name == "tight" else 36)


def test_retraction_leaves_joints_at_their_limits(tight):
    held = problem(tight, (2.0, 3.0))
    values = np.array([1.0, 0.1, 0.1, 0.2, -0.3, 0.1])
    values[2] = held.upper[2]
    found = held.retract(values)
    assert found[2] == held.upper[2]
    assert np.linalg.norm(held.held(found)[0]) <= 1e-9


def test_out_of_reach_is_none(arm):
    assert problem(arm, (6.5, 1.0)).retract(np.full(6, 0.2)) is None


def test_no_hold(arm):
    free = PostureProblem(arm, STATIC)
    error, jacobian = free.held(np.zeros(6))
    assert (error.shape, jacobian.shape) == ((0,), (0, 6))
    np.testing.assert_array_equal(free.retract(np.full(6, 99.0)), free.upper)


def test_a_held_point_that_nothing_moves(arm):
    assert problem(arm, (0.0, 1.0), "base").retract(np.zeros(6)) is None


def test_random_vectors_of_continuous_and_wide_joints(tmp_path):
    """One turn at most, inside the limits, about 0 where it can be."""
    parts, parent = [], "base"
    for number, kind in enumerate(("continuous", "revolute", "revolute", "prismatic")):
        limits = [(-9.0, 9.0), (-9.0, 9.0), (2.0, 12.0), (-0.5, 1.5)][number]
        parts.append(body(f"a{number}", 1.0, (0.5, 0, 0), (0.1, 0.1, 0.1, 0, 0, 0)))
        parts.append(joint(f"q{number}", kind, parent, f"a{number}", (1, 0, 0), (0, 1, 1), limits=limits))
        parent = f"a{number}"
    path = save(tmp_path / "r.urdf", *parts, joint("mount", "fixed", parent, "tool", (1, 0, 0)))
    free = PostureProblem(flexmodal.load(path, stiffness=1.0), STATIC)
    drawn = np.array([free.random_vector(np.random.default_rng(seed)) for seed in range(300)])
    expected = [(-np.pi, np.pi), (-np.pi, np.pi), (2.0, 2.0 + 2 * np.pi), (-0.5, 1.5)]
    for column, (low, high) in zip(drawn.T, expected, strict=True):
        # 300 even draws leave at most a few per cent of the range empty at each end
        assert low <= column.min() <= low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) <= column.max() <= high
