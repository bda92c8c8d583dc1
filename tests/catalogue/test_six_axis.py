"""The spatial arm: made up, so what its card and its URDF's head claim of it is what can be tested."""

import math

import numpy as np
import pytest

import flexmodal

ROBOT = flexmodal.load("six_axis")
POSTURES = sorted(ROBOT.postures)


@pytest.mark.parametrize("posture", POSTURES)
def test_modes_are_those_of_an_arm_of_this_size(posture):
    modes = ROBOT.modes(posture)
    assert len(modes.frequency) == 6
    assert not modes.overdamped.any()
    assert 8 < modes.frequency.min() < 16
    assert 80 < modes.frequency.max() < 125
    assert (modes.damping_ratio > 0.01).all()
    assert (modes.damping_ratio < 0.06).all()


@pytest.mark.parametrize("posture", POSTURES)
def test_postures_keep_inside_the_limits(posture):
    for name, angle in ROBOT.postures[posture].items():
        joint = ROBOT.urdf.joint_by_name[name]
        assert joint.lower < angle < joint.upper


@pytest.mark.parametrize("posture", POSTURES)
def test_the_tool_keeps_off_the_floor_and_the_column(posture):
    x, y, z = ROBOT.measures(posture).tool
    assert z > 0.15
    assert math.hypot(x, y) > 0.5


def test_reach_and_masses_of_the_head():
    origin = {joint.name: np.array(joint.xyz) for joint in ROBOT.urdf.joints}
    forearm = origin["q4"] + origin["q5"]
    assert np.linalg.norm(origin["q3"]) + np.linalg.norm(forearm) == pytest.approx(1.75, abs=0.005)
    reach = origin["q2"][0] + np.linalg.norm(origin["q3"]) + np.linalg.norm(forearm) + origin["q6"][0]
    assert reach == pytest.approx(2.05, abs=0.005)
    mass = {link.name: link.mass for link in ROBOT.urdf.links if link.mass}
    assert mass.pop("base") == 90
    assert sum(mass.values()) == pytest.approx(200, abs=1)


BOX = {
    "link_1": (0.45, 0.4, 0.4),
    "link_2": (0.2, 0.16, 1.0),
    "link_3": (0.44, 0.26, 0.28),
    "link_5": (0.2, 0.13, 0.13),
    "link_6": (0.24, 0.16, 0.2),
}
CYLINDER = {"base": (2, 0.22, 0.3), "link_4": (0, 0.085, 0.66)}


@pytest.mark.parametrize("name", [*BOX, *CYLINDER])
def test_inertias_are_those_of_the_bodies_in_the_head(name):
    link = ROBOT.urdf.link_by_name[name]
    if name in BOX:
        square = np.square(BOX[name])
        expected = link.mass * (square.sum() - square) / 12
    else:
        axis, radius, length = CYLINDER[name]
        expected = np.full(3, link.mass * (3 * radius**2 + length**2) / 12)
        expected[axis] = link.mass * radius**2 / 2
    np.testing.assert_allclose(np.diag(link.inertia), expected, rtol=0.005)  # three figures are kept
    assert np.count_nonzero(link.inertia - np.diag(np.diag(link.inertia))) == 0


def test_every_joint_is_seen_and_struck():
    """In each posture each joint moves the points somewhere, so that a campaign can tell its stiffness."""
    frequency = np.array([0.0])
    for posture in POSTURES:
        rows = [f"{point}:+{axis}" for point in ROBOT.points for axis in "xyz"]
        static = ROBOT.frf(posture, frequency, response=rows, reference=rows).value[0].real
        assert np.linalg.matrix_rank(static, tol=1e-6 * np.linalg.norm(static)) == 6
        assert math.isfinite(np.linalg.norm(static))
