"""Nuisance parameters of a set-up: derivatives, what was injected found again, nothing moved for nothing."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Tolerance
from flexmodal.identification import fit, observe, predict
from flexmodal.identification.gap import gap
from flexmodal.identification.model import RobotModel
from flexmodal.identification.sensitivities import Sensitivities, moved, nuisances_of
from flexmodal.identification.set_up_step import PLAUSIBLE
from flexmodal.identification.setting_up import far_words
from flexmodal.identification.tolerance import as_set_up
from flexmodal.rig import Hide, simulate
from flexmodal.structure import robot_space

GIVEN = Tolerance(posture=0.01, position=0.004, direction=0.02, gain=0.03)


@pytest.fixture(scope="module")
def made():
    """A planar arm in three postures, its card exact but for 4 %, the test set up as recorded."""
    result = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=3, references=2, trials=2, averages=2, seed=7,
        record_length=2.0, band=(2.0, 120.0), parameter_error=0.04, time=False,
    )  # fmt: skip
    return observe(replace(result.campaign, tolerance=GIVEN)), result.robot


def spoilt(seen, size):
    """Recorded wrongly by draws of `size` standard deviations; what would put each right."""
    random = np.random.default_rng(1)
    true = {one: float(size * one.deviation * random.normal()) for one in nuisances_of(seen)}
    return moved(seen, [(one, -value) for one, value in true.items()]), true


def fitted(seen, robot):
    """Coordinates of the robot, from every fourth line."""
    model = RobotModel(robot, robot_space(robot))
    lines = np.arange(0, len(seen.axis), 4)
    return fit(model, seen, np.zeros(len(model.space)), lines=lines, floors=(0.2, 0.05, 0.02), steps=12).x


def test_each_derivative_is_that_of_the_model(made):
    """Against moving that one thing alone, as `moved` does it, and predicting anew."""
    seen, robot = made
    model = RobotModel(robot, robot_space(robot))
    x, lines = np.zeros(len(model.space)), np.arange(5, len(seen.axis), 20)
    plain = predict(model, x, seen, lines)
    found = Sensitivities.of(model, x, seen, lines)
    ones = np.ones((len(seen), len(lines)))
    rows = found.weighed(ones).reshape(len(found.nuisances), *ones.shape)
    kinds = set()
    for one, row in zip(found.nuisances, rows, strict=True):
        step = 1e-3 * one.deviation
        other = moved(seen, [(one, step)])
        r = [np.log(value / data.value[:, lines]) for value, data in (
            (predict(model, x, other, lines), other), (plain, seen),
        )]  # fmt: skip
        change = (r[0] - r[1]) / step
        change = change.real + 1j * (np.angle(np.exp(1j * step * change.imag)) / step)
        small = (
            np.abs(row) * one.deviation < 0.2
        )  # beyond, the difference of a tenth of it is not first order
        scale = np.abs(row[small]).max(initial=0.0)
        assert np.median(np.abs(row - change)[small]) <= 0.02 * scale + 2e-3  # cos τ of a turn
        kinds |= {one.kind} if scale > 0 else set()
    assert kinds == {"posture", "position", "direction", "sensor gain", "hammer gain"}


def test_what_was_set_up_as_recorded_stays(made):
    seen, robot = made
    found = as_set_up(seen, robot, robot_space(robot))
    assert found.found == ()
    np.testing.assert_array_equal(found.observations.value, seen.value)
    assert np.all(found.observations.variance > seen.variance)  # not all of it can be seen


def test_without_tolerances_nothing_is_looked_at(made):
    seen, robot = made
    exact = replace(seen, campaign=replace(seen.campaign, tolerance=Tolerance()))
    found = as_set_up(exact, robot, robot_space(robot))
    assert found.observations is exact


def test_what_was_off_is_found_and_parameters_are_those_of_a_careful_test(made):
    seen, robot = made
    off, true = spoilt(seen, 1.0)
    found = as_set_up(off, robot, robot_space(robot))
    assert len(found.found) >= 8
    within = [(one.value - true[one.nuisance]) / one.deviation for one in found.found]
    assert np.median(np.abs(within)) < 1.5  # some cannot be told apart: a first joint from all directions
    careful, careless, righted = (fitted(one, robot) for one in (seen, off, found.observations))
    away = [np.sqrt(np.mean((one - careful) ** 2)) for one in (careless, righted)]
    assert away[1] < 0.5 * away[0]
    model = RobotModel(robot, robot_space(robot))
    left = [
        gap(one, predict(model, x, one)).value
        for x, one in ((careful, seen), (righted, found.observations), (careless, off))
    ]
    assert abs(left[1] - left[0]) < 0.2 * (left[2] - left[0])


@pytest.mark.slow
def test_what_lies_far_outside_is_told_or_left_to_an_effect(made):
    seen, robot = made
    gain = next(one for one in nuisances_of(seen) if one.kind == "sensor gain")
    last = seen.postures[2]
    angle = next(one for one in nuisances_of(seen) if one.where == last.id and one.what == "q2")
    off = moved(seen, [(gain, -0.3), (angle, -0.06)])
    found = as_set_up(off, robot, robot_space(robot))
    words = " ".join(far_words(found.found))
    assert gain.says.split(" at ")[1] in words
    assert f"angle of q2 in {last.name}" in words
    kept = as_set_up(off, robot, robot_space(robot), far=False)
    assert all(one.nuisance.kind == "posture" or not one.is_far for one in kept.found)
    turned = as_set_up(moved(seen, [(angle, -0.06)]), robot, robot_space(robot), far=False)
    assert [one.nuisance for one in turned.found if one.is_far] == [angle]  # it explains what is seen


@pytest.mark.slow
def test_angles_do_not_make_up_for_what_is_missing():
    """Of a foundation that gives: all in all they stay as near as their tolerances let expect."""
    result = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=3, references=2, trials=2, averages=2, seed=7,
        record_length=2.0, band=(2.0, 120.0), hide=[Hide("base_flexibility", "base", height=60.0)],
        parameter_error=0.02, time=False,
    )  # fmt: skip
    missing, robot = observe(replace(result.campaign, tolerance=GIVEN)), result.robot

    def squares(far):
        found = as_set_up(missing, robot, robot_space(robot), far=far).found
        return [(one.value / GIVEN.posture) ** 2 for one in found if one.nuisance.kind == "posture"]

    count = sum(one.kind == "posture" for one in nuisances_of(missing))
    most = count + PLAUSIBLE * np.sqrt(2 * count)
    assert sum(squares(far=True)) > 2 * most
    assert 0 < sum(squares(far=False)) <= most


@pytest.mark.slow
def test_what_is_held_out_moves_nothing(made):
    seen, robot = made
    off, _ = spoilt(seen, 1.0)
    held = off.posture == 1
    found = as_set_up(off, robot, robot_space(robot), held)
    number = off.postures[1].id
    assert not any(one.nuisance.kind == "posture" and one.nuisance.where == number for one in found.found)
    other = replace(off, value=np.where(held[:, None], 3 * off.value, off.value))
    again = as_set_up(other, robot, robot_space(robot), held)
    assert [one.value for one in again.found] == [one.value for one in found.found]
