"""Sensors that change from posture to posture, told from what the other points say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmodal
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.changing import changing, nearest
from flexmodal.identification import observe, predict
from flexmodal.rig import simulate
from flexmodal.structure import robot_space

RANDOM = np.random.default_rng(3)


@pytest.mark.parametrize("channels", [(1, 2, 3), (1, 3), (2,)])
@pytest.mark.parametrize("mirrored", [False, True])
def test_axes_are_found_from_what_they_read(channels, mirrored):
    """However far they are turned; of channels that nobody read whatever is square to the others."""
    axes = Rotation.from_rotvec([0.4, -1.9, 0.8]).as_matrix() * (-1 if mirrored else 1)
    known = {}
    for channel in channels:
        r = np.triu(RANDOM.normal(size=(3, 3))) + 3 * np.eye(3)
        known[channel] = r, r @ axes[channel - 1]
    found = nearest(known)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-9)
    for channel in channels:
        np.testing.assert_allclose(found[channel - 1], axes[channel - 1], atol=1e-6)


def test_what_does_not_move_is_no_matter():
    """In the plane nothing is known of motions across it."""
    flat = np.diag([1.0, 2.0, 0.0])
    found = nearest({1: (flat, flat @ [0.8, 0.6, 0.0]), 2: (flat, flat @ [-0.6, 0.8, 0.0])})
    np.testing.assert_allclose(found[:2, :2], [[0.8, 0.6], [-0.6, 0.8]], atol=1e-6)


@pytest.fixture(scope="module")
def measured():
    robot = flexmodal.load("six_axis")
    made = simulate(
        robot, postures=3, points=3, references=2, trials=1, seed=4, noise=0.01, parameter_error=0.0,
        axes="xyz",
    )  # fmt: skip
    seen = observe(made.campaign)
    return Hypothesis(Context.of(robot, seen), robot_space(robot)), seen


def reads(root, seen, point, what):
    """What a sensor would read: of foretold motions along three axes, for a posture."""
    value, x = seen.value.copy(), np.zeros(len(root.space))
    moved = [
        predict(root, x, replace(seen, response=np.column_stack([seen.response[:, 0], [axis] * len(seen)])))
        for axis in (1, 2, 3)
    ]
    for row in np.flatnonzero(seen.response[:, 0] == point):
        noise = seen.value[row] / moved[seen.response[row, 1] - 1][row]
        every = np.array([one[row] for one in moved])
        value[row] = what(int(seen.posture[row]), every)[seen.response[row, 1] - 1] * noise
    return replace(seen, value=value)


TURNS = Rotation.from_rotvec([[0.3, -0.2, 0.4], [-0.5, 0.1, 0.2], [0.0, 0.4, -0.3]]).as_matrix()
LATE = np.exp(-2j * np.pi * 1e-3)


@pytest.mark.parametrize(
    ("what", "effect"),
    [
        (lambda posture, moved: moved, "sensor_gain"),  # as recorded, a factor of one
        (lambda posture, moved: np.einsum("ab,bl->al", TURNS[posture], moved), "sensor_misalignment"),
        (
            lambda posture, moved: np.einsum("ab,bl->al", -TURNS[posture], moved),
            "sensor_misalignment",
        ),  # mirrored
        (lambda posture, moved: 1.4 * moved, "sensor_gain"),
        (lambda posture, moved: (-0.7, 1.4, 0.8)[posture] * moved, "sensor_gain"),
        (lambda posture, moved: (1 + 0.3 * posture) * moved[[1, 0, 2]], None),
        (lambda posture, moved: moved * LATE ** ((1 + posture) * np.arange(moved.shape[1])), "time_delay"),
        (lambda posture, moved: moved * LATE ** (np.arange(moved.shape[1]) ** 2 / 50), None),
    ],
)
def test_what_a_sensor_does_in_each_posture_has_a_name(measured, what, effect):
    root, seen = measured
    point = int(seen.response[0, 0])
    given = reads(root, seen, point, what)
    assert changing(given, root, np.zeros(len(root.space)), point) == effect


def test_a_point_that_nobody_looked_at_says_nothing(measured):
    root, seen = measured
    assert changing(seen, root, np.zeros(len(root.space)), 999) is None
