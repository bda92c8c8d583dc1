"""Held-out gaps of a diagnosis' model stand beside what needs no model."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.selection.asked import asked_of
from flexmodal.diagnosis.selection.beside_nothing import beside_nothing
from flexmodal.diagnosis.setup import prepare
from flexmodal.identification import gap
from flexmodal.identification.baselines import log_mean
from flexmodal.rig import simulate


@pytest.fixture(scope="module")
def fitted():
    made = simulate(
        flexmodal.load("fanuc_s360"), seed=4, postures=4, points=3, references=1, trials=1,
        record_length=1.0, band=(2.0, 120.0),
    )  # fmt: skip
    setup = prepare(
        made.campaign, made.robot, None, asked_of(["added_mass"]), None, 0, lambda doing, part: None
    )
    return setup, fitted_closely(setup, Hypothesis(setup.context, setup.base), np.zeros(len(setup.base)))


def test_a_model_beats_what_knows_nothing_and_needs_the_right_angles(fitted):
    setup, model = fitted
    found = beside_nothing(setup, model)
    assert found.beats_mean
    assert found.beats_nearest
    assert found.tells_postures
    assert found.shuffled > 2 * found.fitted
    assert {one.posture for one in found.each} == {
        setup.observations.postures[k].name for k in np.unique(setup.observations.posture[setup.held])
    }


def test_the_mean_of_the_others_is_theirs(fitted):
    """By hand: at each place of the posture held out the mean over the three others."""
    setup, model = fitted
    seen = setup.observations
    value = np.array(seen.value)
    for row in np.flatnonzero(setup.held):
        same = ~setup.held & np.all(seen.response == seen.response[row], axis=1)
        value[row] = log_mean(seen.value[same])
    assert beside_nothing(setup, model).mean == pytest.approx(gap(seen, value, setup.held).value)


def test_without_postures_held_out_there_is_nothing_to_compare(fitted):
    setup, model = fitted
    assert beside_nothing(replace(setup, held=np.zeros_like(setup.held)), model) is None
