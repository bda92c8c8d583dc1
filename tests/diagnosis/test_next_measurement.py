"""The next measurement: its information by closed forms, and the best of a campaign's own places."""

import numpy as np
import pytest

from flexmodal.diagnosis.next_measurement.choose import NOISE, Sure, next_among_records
from flexmodal.diagnosis.next_measurement.information import Predicted, information
from flexmodal.diagnosis.next_measurement.setups import postures_to_try
from flexmodal.identification import uncertainty


def predicted(logs, slope=0.0, variance=0.0):
    """One parameter that moves ln α of every line alike."""
    value = np.exp(np.atleast_2d(np.asarray(logs, dtype=complex)))
    return Predicted(value, np.full((1, *value.shape), slope, dtype=complex), np.array([[variance]]))


def test_without_unsure_parameters_it_is_half_the_squared_distance_over_the_noise():
    apart = np.array([0.1 + 0.05j, -0.02j])
    found = information(predicted(apart), predicted([0.0, 0.0]), NOISE)
    size = np.exp(np.minimum(apart.real, 0.0))  # the smaller of the two, of one point: twice its noise
    assert size.tolist() == [1.0, 1.0]
    assert found[0] == pytest.approx(0.5 * np.sum(np.abs(apart) ** 2) / NOISE**2, rel=1e-12)


def test_what_an_unsure_parameter_could_make_of_it_is_no_information():
    apart, card = np.full(4, 0.2), np.zeros(4)
    sure = information(predicted(apart), predicted(card), NOISE)[0]
    loose = information(predicted(apart, slope=1.0, variance=100.0), predicted(card), NOISE)[0]
    assert loose < 1e-3 * sure
    # a difference that the parameter cannot make is left
    apart = np.array([0.2, -0.2, 0.2, -0.2])
    kept = information(predicted(apart, slope=1.0, variance=100.0), predicted(card), NOISE)[0]
    assert kept == pytest.approx(information(predicted(apart), predicted(card), NOISE)[0], rel=0.1)


def test_a_point_that_stands_still_brings_nothing():
    still = Predicted(np.zeros((1, 3), dtype=complex), np.zeros((1, 1, 3), dtype=complex), np.eye(1))
    assert information(still, still, NOISE).tolist() == [0.0]


def test_two_models_are_told_apart_in_a_posture_that_was_tried(observed, hinged):
    root, before, hypothesis, after = hinged
    one, other = (
        Sure(model, fit.x, uncertainty(model.space, fit.normal, observed).covariance)
        for model, fit in ((hypothesis, after), (root, before))
    )
    found = next_among_records(observed, [one, other], seed=3)
    assert found.separates == ("link_flexibility@link_2", "none")
    assert found.posture in [dict(q) for q in postures_to_try(root.context, 3)]
    assert found.gain > 10  # a mode more or less: odds of 20000 to 1
    assert found.force_peak in (observed.peak(0), observed.peak(1))
    assert next_among_records(observed, [one, one], seed=3).gain < 1e-20  # rounding
