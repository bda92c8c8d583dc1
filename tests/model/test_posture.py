import math
from fractions import Fraction

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidPosture
from flexmodal.model import Posture
from flexmodal.model.batch import receptance_batch
from flexmodal.model.posture import middle


def faults(robot, pose):
    with pytest.raises(InvalidPosture) as caught:
        robot.at(pose)
    return caught.value.faults


def test_a_named_posture(fanuc):
    posture = fanuc.posture("configuration_2")
    assert posture.name == str(posture) == "configuration_2"
    assert posture.values == {"q1": math.radians(70), "q2": -math.radians(70), "q3": 0.0}
    assert fanuc.posture(posture) == posture


def test_joints_left_out_are_zero(fanuc):
    assert fanuc.posture({"q2": 0.5}).values == {"q1": 0.0, "q2": 0.5, "q3": 0.0}
    assert str(fanuc.posture({"q2": 0.5})) == "q1=0, q2=0.5, q3=0"


@pytest.mark.parametrize("value", [1, 0.5, np.float64(0.5), np.float32(0.5), np.int64(1), Fraction(1, 2)])
def test_any_real_number_will_do(fanuc, untyped, value):
    assert fanuc.posture({"q1": value}).values["q1"] == float(value)


@pytest.mark.parametrize(
    "value",
    [math.nan, math.inf, -math.inf, True, np.True_, "0.5", None, [0.5], 2**2000, 1j, np.array([0.5])],
    ids=lambda value: type(value).__name__,
)
def test_no_number(fanuc, untyped, value):
    (fault,) = faults(fanuc, {"q1": value})
    assert fault.key == "posture: q1"
    assert repr(value).startswith(fault.found.removesuffix("…"))


def test_unknown_name(fanuc):
    (fault,) = faults(fanuc, "configuration2")
    assert "did you mean configuration_" in fault.found
    assert "configuration_7" in fault.allowed
    (fault,) = faults(flexmodal.load("ur5", stiffness=1.0), "home")
    assert "no named postures" in fault.allowed


def test_unknown_and_pseudo_joints(fanuc):
    first, second, third = faults(fanuc, {"q11": 0.1, "rho": 0.0, "tool_mount": 0.0})
    assert "did you mean q1" in first.found
    assert "pseudo-joint rho" in second.found
    assert "tool_mount" in third.found
    assert {first.allowed, second.allowed, third.allowed} == {"q1, q2, q3"}


def test_limits(fanuc):
    (fault,) = faults(fanuc, {"q1": -0.1})
    assert (fault.found, fault.allowed) == ("-0.1", "0 to 3.14159, the joint's limits")
    # a limit printed with six decimals still counts as met, in a card and in a call alike
    assert fanuc.posture({"q1": 3.141593}).values["q1"] == 3.141593
    assert faults(fanuc, {"q1": 3.1416})


def test_zero_outside_the_limits_is_said():
    kinova = flexmodal.load("kinova", stiffness=1.0)
    found = faults(kinova, {})
    assert {fault.found for fault in found} == {"0 (left out, so 0)"}
    kinova.at(middle(kinova.commanded))


def test_all_at_once(fanuc):
    found = faults(fanuc, {"q1": math.nan, "q2": 5.0, "q3": -9.0, "q7": 0.0, "rho": 0.0})
    assert sorted(fault.key for fault in found) == [
        "posture",
        "posture",
        "posture: q1",
        "posture: q2",
        "posture: q3",
    ]


def test_a_posture_made_by_hand_is_checked_too(fanuc):
    assert faults(fanuc, Posture({"q1": 9.0}, "mine"))
    assert fanuc.at(Posture({"q1": 1.0}, "mine")).posture.name == "mine"


def test_the_checked_posture_cannot_be_changed(fanuc):
    posture = fanuc.posture({"q1": 1.0})
    with pytest.raises(TypeError):
        posture.values["q1"] = 2.0
    given = {"q1": 1.0}
    kept = fanuc.posture(given)
    given["q1"] = 2.0
    assert kept.values["q1"] == 1.0


@pytest.mark.parametrize("turns", [-3, -1, 1, 2, 1000])
def test_whole_turns_of_a_continuous_joint(turns, mixed_robot):
    """nq ≠ nv: a continuous joint is a cosine and a sine inside."""
    for robot, name in ((mixed_robot, "turn"), (flexmodal.load("kinova", stiffness=1e4), "j2s6s200_joint_4")):
        assert robot.moving[name].type == "continuous"
        assert robot.pinocchio.nq > robot.pinocchio.nv
        start = dict(middle(robot.commanded).values) | {name: 0.7}
        there = dict(start) | {name: 0.7 + turns * 2 * math.pi}
        expected, found = robot.at(start), robot.at(there)
        # the angle itself is rounded: 1e-16 of its size, so 1e-12 at a thousand turns
        bound = 1e-15 * (10 + 2 * math.pi * abs(turns))
        scale = expected.system.mass.max()
        np.testing.assert_allclose(found.system.mass, expected.system.mass, atol=4 * bound * scale)
        np.testing.assert_allclose(found.position(robot.tool), expected.position(robot.tool), atol=4 * bound)


def test_prismatic_joints_move_in_metres(mixed_robot):
    moved = mixed_robot.at({"slide": 0.5}).position("tool") - mixed_robot.at({}).position("tool")
    assert np.linalg.norm(moved) == pytest.approx(0.5, rel=1e-14)
    column = mixed_robot.at({}).full_jacobian("tool")[:, list(mixed_robot.moving).index("slide")]
    np.testing.assert_allclose(moved / 0.5, column[:3], atol=1e-15)
    np.testing.assert_array_equal(column[3:], 0)


@pytest.mark.parametrize("value", [1e5, -1e300, 2.0**53])
def test_a_joint_without_limits_does_not_turn_for_ever(value):
    """Sines of such angles are numbers without digits."""
    robot = flexmodal.load("kinova", stiffness=1e4, damping=1.0)
    name = next(name for name, joint in robot.commanded.items() if math.isinf(joint.upper))
    found = [fault for fault in faults(robot, {name: value}) if fault.key == f"posture: {name}"]
    assert [fault.allowed for fault in found] == ["-10000 to 10000"]
    rows = np.array([[0.5 * (max(j.lower, -1) + min(j.upper, 7)) for j in robot.commanded.values()]])
    rows[0, list(robot.commanded).index(name)] = value
    with pytest.raises(InvalidPosture):
        receptance_batch(robot, rows, [f"{robot.tool}:+z"], [1.0])
