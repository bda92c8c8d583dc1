"""Derivatives corrected from step to step: those of a linear model, and fits that end where others end."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.time_domain.secant import CORRECTED, Secants, fitted_by_secants
from flexmodal.identification import RobotModel, fit, observe
from flexmodal.identification.frf_fit import FrfMisfit, Weighting
from flexmodal.identification.model import evaluated
from flexmodal.rig import simulate
from flexmodal.structure import robot_space


class Counted:
    """A robot that predicts like a model without a structure, and counts how often it is asked."""

    def __init__(self, robot):
        self.inner = RobotModel(robot, robot_space(robot))
        self.values = self.derivatives = 0

    @property
    def space(self):
        return self.inner.space

    def receptances(self, x, observations, lines, *, slopes):
        self.values += 1
        self.derivatives += slopes
        count = len(observations.axis.take(lines))
        value = np.zeros((len(observations), count), dtype=complex)
        found = np.zeros((len(x) if slopes else 0, *value.shape), dtype=complex)
        for rows, some, changes in evaluated(self.inner, x, observations, lines, slopes=slopes):
            value[rows] = some
            if slopes:
                found[:, rows] = changes
        return value, found


@pytest.fixture(scope="module")
def campaign():
    robot = flexmodal.load("fanuc_s360")
    made = simulate(
        robot, postures=2, points=2, references=1, trials=1, averages=2, seed=3, band=(2.0, 100.0),
        record_length=2.0,
    )  # fmt: skip
    return robot, observe(made.campaign)


LINES = np.arange(0, 190, 5)


def test_the_change_along_a_step_is_met(campaign):
    robot, observations = campaign
    model = Counted(robot)
    some, start = Secants(model), np.zeros(len(model.space))
    value, _ = some.receptances(start, observations, LINES, slopes=False)
    same, exact = some.receptances(start, observations, LINES, slopes=True)
    np.testing.assert_array_equal(value, same)
    step = 0.02 * np.sin(np.arange(len(start)) + 1.0)
    there, _ = some.receptances(step, observations, LINES, slopes=False)
    _, corrected = some.receptances(step, observations, LINES, slopes=True)
    assert model.derivatives == 1
    seen = np.log(there / value)
    np.testing.assert_allclose(np.tensordot(step, corrected / there, 1), seen, rtol=0, atol=1e-9)
    aside = np.zeros(len(start))
    aside[:2] = step[1], -step[0]  # along no part of the step nothing changed
    relative = np.tensordot(aside, corrected / there, 1)
    np.testing.assert_allclose(relative, np.tensordot(aside, exact / value, 1), rtol=0, atol=1e-9)


def test_they_are_found_anew_after_some_steps(campaign):
    robot, observations = campaign
    model = Counted(robot)
    some, x = Secants(model), np.zeros(len(model.space))
    for _ in range(CORRECTED + 2):
        some.receptances(x, observations, LINES, slopes=False)
        some.receptances(x, observations, LINES, slopes=True)
        x = x + 0.001
    assert model.derivatives == 2


def test_where_nothing_was_tried_they_are_found(campaign):
    robot, observations = campaign
    model = Counted(robot)
    some, x = Secants(model), np.zeros(len(model.space))
    some.receptances(x, observations, LINES, slopes=True)
    some.receptances(x + 0.01, observations, LINES, slopes=True)
    assert model.derivatives == 2


@pytest.mark.parametrize("floor", [0.2, 0.01])
def test_a_fit_ends_where_one_with_derivatives_ends(floor, campaign):
    robot, observations = campaign
    model = Counted(robot)
    start = 0.05 * np.cos(np.arange(len(model.space)))
    misfit = FrfMisfit(model, observations, Weighting(floor, LINES))
    near = fitted_by_secants(misfit, start, steps=100, settled=1e-6)
    asked = model.derivatives
    full = fit(model, observations, start, floors=(floor,), lines=LINES, steps=60, settled=1e-6, apart=False)
    assert near.cost == pytest.approx(full.cost, rel=1e-2)
    assert asked <= near.steps / 2 + 2
    assert near.misfit is misfit


def test_no_more_steps_than_asked(campaign):
    robot, observations = campaign
    model = Counted(robot)
    start = 0.3 * np.cos(np.arange(len(model.space)))
    misfit = FrfMisfit(model, observations, Weighting(0.05, LINES))
    near = fitted_by_secants(misfit, start, steps=3, settled=1e-6)
    assert near.steps == 3
