"""A card with a coupling and loss factors: every route to a receptance sees them."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.cards import CouplingCard, FrozenDict
from flexmodal.errors import InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.model.batch import gradient_batch, receptance_batch
from flexmodal.model.gradient import receptance_and_gradient
from flexmodal.model.sensitivity import sensitivity

LINES = np.array([0.0, 2.0, 7.7, 38.0, 51.3, 140.0])
POSE = {"q1": 0.9, "q2": -0.7, "q3": 0.2}


def robot(loss=0.06, frequency=20.0, coupling=4e4):
    plain = load("fanuc_s360")
    joints = {
        name: replace(joint, loss_factor=0.0 if joint.pseudo else loss * (1 + place))
        for place, (name, joint) in enumerate(plain.joints.items())
    }
    tied = {"q1+q2": CouplingCard(("q1", "q2"), coupling)} if coupling else {}
    return replace(plain, joints=FrozenDict(joints), couplings=FrozenDict(tied), loss_frequency=frequency)


def on_paper(robot, posture, lines):
    """Z put together entry by entry; bagley and torvik's spring written out."""
    posed = robot.at(posture)
    names = list(robot.joints)
    row = posed.jacobian("location_1")[2]
    found = []
    for line in lines:
        omega = 2 * np.pi * line
        z = -(omega**2) * posed.system.mass + 1j * omega * np.diag([j.damping for j in robot.joints.values()])
        for place, joint in enumerate(robot.joints.values()):
            beta = 2 / np.pi * np.arctan(joint.loss_factor)
            grown = (1j * max(line, 1e-3 * robot.loss_frequency) / robot.loss_frequency) ** beta
            z[place, place] += joint.stiffness * grown / np.cos(np.pi / 2 * beta)
        for tied in robot.couplings.values():
            one, other = (names.index(name) for name in tied.joints)
            z[one, other] += tied.stiffness
            z[other, one] += tied.stiffness
        found.append(row @ np.linalg.solve(z, row))
    return np.array(found)


def test_receptance_on_paper():
    own = robot()
    value = own.frf(POSE, LINES, response="location_1:+z").value[:, 0, 0]
    np.testing.assert_allclose(value, on_paper(own, POSE, LINES), rtol=1e-10)
    plain = load("fanuc_s360").frf(POSE, LINES, response="location_1:+z").value[:, 0, 0]
    assert np.all(np.abs(np.log(value / plain)) > 1e-3)


@pytest.mark.parametrize(
    "given", [{}, {"coupling": 0.0}, pytest.param({"loss": 0.0}, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("way", ["auto", "LAPACK", "numpy", "compiled", "compiled any n"])
def test_batches_agree_with_one_by_one(given, way):
    own = robot(**given)
    poses = [{**POSE, "q1": 0.9 + 0.01 * step} for step in range(70)]
    batch = receptance_batch(own, poses, ["location_1:+z"], LINES, way=way)
    for place in (0, 69):
        one = own.frf(poses[place], LINES, response="location_1:+z").value[:, 0, 0]
        np.testing.assert_allclose(batch.value[place, :, 0], one, rtol=1e-9)


def test_the_recursion_refuses_what_it_cannot_take():
    for given in ({}, {"coupling": 0.0}, {"loss": 0.0}):
        with pytest.raises(InvalidRequest, match="diagonal K and B and no addition"):
            receptance_batch(robot(**given), [POSE], ["location_1:+z"], LINES, way="recursion")


@pytest.mark.parametrize("given", [{}, {"loss": 0.0}])
def test_gradients_by_differences(given):
    own = robot(**given)
    up = (PointDirection("location_1", "z"),)
    _, slopes = receptance_and_gradient(own.at(POSE), up, LINES)
    batch = gradient_batch(own, [POSE], ["location_1:+z"], LINES)
    np.testing.assert_allclose(batch.slope[0, :, 0], slopes[:, 0, 0], rtol=1e-9, atol=1e-20)
    step = 1e-6
    for place, name in enumerate(own.moving):
        if name not in POSE:
            continue
        ends = [
            own.frf({**POSE, name: POSE[name] + sign * step}, LINES, response=up).value[:, 0, 0]
            for sign in (1, -1)
        ]
        numeric = (ends[0] - ends[1]) / (2 * step)
        scale = np.abs(slopes[:, 0, 0]).max(axis=1)
        np.testing.assert_allclose(slopes[:, 0, 0, place] / scale, numeric / scale, atol=1e-6)


GIVEN = {
    "causal loss and coupling": {},
    "constant loss": {"frequency": None, "coupling": 0.0},
    "coupling": {"loss": 0.0},
}


@pytest.mark.parametrize("given", GIVEN.values(), ids=GIVEN)
@pytest.mark.parametrize("way", ["numpy", "compiled"])
def test_batched_gradients_by_pinocchio(given, way):
    """Values and slopes against Pinocchio and LAPACK."""
    own = robot(**given)
    pairs = ["location_1:+z", ("location_2:+x", "location_1:+z")]
    ends = [tuple(PointDirection.parse(d) for d in pair) for pair in ((pairs[0],) * 2, pairs[1])]
    directions = list(dict.fromkeys(d for pair in ends for d in pair))
    places = [tuple(directions.index(d) for d in pair) for pair in ends]
    poses = [{**POSE, "q1": 0.9 + 0.05 * step} for step in range(5)]
    found = gradient_batch(own, poses, pairs, LINES, way=way)
    for place, pose in enumerate(poses):
        value, slope = receptance_and_gradient(own.at(pose), directions, LINES)
        value, slope = (np.stack([part[:, u, v] for u, v in places], 1) for part in (value, slope))
        scale = np.abs(slope).max(axis=2, keepdims=True)
        np.testing.assert_allclose(found.value[place], value, rtol=1e-10)
        np.testing.assert_allclose(found.slope[place] / scale, slope / scale, rtol=0, atol=1e-10)


def test_sensitivity_along_the_frequency():
    own = robot()
    posed, line = own.at(POSE), np.array([7.7, 38.0])
    found = sensitivity(posed, "location_1:+z", "location_1:+z", line)
    step = 1e-4
    ends = [posed.frf(line + sign * step, response="location_1:+z").value[:, 0, 0] for sign in (1, -1)]
    np.testing.assert_allclose(found.frequency, (ends[0] - ends[1]) / (2 * step), rtol=1e-6)


def test_modes_are_where_the_peaks_are():
    """Damping ratios grow by about half the loss factor where the joint that has it does the work."""
    own = robot(loss=0.01, coupling=0.0)
    modes, plain = own.modes(POSE), load("fanuc_s360").modes(POSE)
    more = modes.damping_ratio - plain.damping_ratio
    assert np.all((more > 0) & (more < 0.02))  # half of 0.04, the largest
    axis = np.linspace(5, 10, 5001)
    peak = axis[np.argmax(np.abs(own.frf(POSE, axis, response="location_1:+z").value[:, 0, 0]))]
    damped = np.abs(modes.pole[0].imag) / (2 * np.pi)
    assert abs(damped - peak) < 0.1  # one mode far from the others; the top is a little below it
