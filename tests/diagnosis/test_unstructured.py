"""A mode with no structure: found where it is planted, the mean of the others where nothing was fitted."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.search.unstructured import unstructured_mode
from flexmodal.diagnosis.selection.frf_comparison import cluster_costs, compare_models
from flexmodal.diagnosis.setup import prepare
from flexmodal.identification.uncertainty import clusters
from flexmodal.rig import simulate

FREQUENCY, RATIO = 40.0, 0.02


def mode(omega, frequency):
    at = 2 * np.pi * frequency
    return 1 / (at**2 - omega**2 + 2j * RATIO * at * omega)


@pytest.fixture(scope="module")
def setup():
    """Three postures of a robot with nothing hidden, one of them held out."""
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=2, references=2, trials=4, seed=5, record_length=2.0,
        band=(2.0, 150.0),
    )  # fmt: skip
    return prepare(made.campaign, made.robot, None, None, None, 0, lambda doing, part: None)


@pytest.fixture(scope="module")
def planted(setup):
    """The re-tuned robot less a mode that each posture has a little elsewhere: what a missing mode leaves."""
    root = Hypothesis(setup.context, setup.base)
    fitted = fitted_closely(setup, root, np.zeros(len(setup.base)))
    observations = setup.observations
    omega = 2 * np.pi * observations.axis.frequency
    frequencies = FREQUENCY * (1 + 0.1 * observations.posture)
    size = np.median(np.abs(observations.value), axis=1) * (2 * np.pi * FREQUENCY) ** 2 * 0.2
    missing = size[:, None] * np.array([mode(omega, one) for one in frequencies])
    predicted = observations.value - missing
    costs = cluster_costs(observations, predicted, fitted.fitted.weighing.floor)
    return replace(fitted, predicted=predicted, costs=costs), missing


def test_finds_the_mode_that_is_missing(setup, planted):
    before, missing = planted
    found = unstructured_mode(setup, before)
    assert found.key == (UNSTRUCTURED, "")
    fitted = ~setup.held
    away = np.linalg.norm(found.predicted - before.predicted - missing, axis=1)
    assert np.all((away / np.linalg.norm(missing, axis=1))[fitted] < 0.02)
    seen = np.unique(clusters(setup.observations)[fitted])
    assert np.all(found.costs[seen] < 0.01 * before.costs[seen])
    observations = setup.observations
    table = np.hstack([observations.posture[:, None], observations.response, observations.reference])[fitted]
    postures = len(np.unique(table[:, 0]))
    assert found.parameters - before.parameters == 2 * postures + len(np.unique(table, axis=0))


def test_foretells_the_mean_for_a_posture_held_out(setup, planted):
    before, _ = planted
    found = unstructured_mode(setup, before)
    held = np.flatnonzero(setup.held)
    assert held.size
    added = np.abs((found.predicted - before.predicted)[held[0]])
    others = np.unique(setup.observations.posture[~setup.held])
    middle = FREQUENCY * np.exp(np.mean(np.log1p(0.1 * others)))
    assert setup.observations.axis.frequency[np.argmax(added)] == pytest.approx(middle, rel=0.02)


def test_is_no_better_than_nothing_where_nothing_is_missing(setup):
    before = fitted_closely(setup, Hypothesis(setup.context, setup.base), np.zeros(len(setup.base)))
    found = unstructured_mode(setup, before)
    assert found.occam > before.occam
    comparison = compare_models([before, found], setup.observations)
    assert comparison.gain(1) < 8.0
