"""The next measurement: its information by closed forms, and the best of a campaign's own places."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.next_measurement import predicted as predicting
from flexmodal.diagnosis.next_measurement.choose import next_among_records
from flexmodal.diagnosis.next_measurement.information import Predicted, doubt_left, information
from flexmodal.diagnosis.next_measurement.predicted import Sure, predicted_by, relative
from flexmodal.diagnosis.next_measurement.refit import not_made_up_for
from flexmodal.diagnosis.next_measurement.setups import Bench, postures_to_try
from flexmodal.errors import SingularResponse
from flexmodal.identification import uncertainty, unlimited

NOISE = 0.05


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


@pytest.mark.slow
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


def test_of_several_explanations_the_pair_that_is_hardest_to_tell_rules():
    """Two alike and one apart: nothing is gained on the pair; by hand from the two informations."""
    one, same, apart = predicted([0.0, 0.0]), predicted([0.0, 0.0]), predicted([0.1, 0.1])
    doubt, gain = doubt_left([one, same, apart], [0.5, 0.3, 0.2], NOISE)
    between = information(one, apart, NOISE)[0]
    by_hand = np.log(2 * 0.5 * 0.3 + 2 * (0.5 + 0.3) * 0.2 * np.exp(-between / 4))
    assert doubt[0] == pytest.approx(by_hand, rel=1e-12)
    assert gain[0] == 0.0
    assert doubt_left([one, apart, same], [0.5, 0.2, 0.3], NOISE)[1][0] == pytest.approx(between, rel=1e-12)


def test_a_peak_that_a_parameter_can_move_is_no_information():
    """Two oscillators 1 % apart, one unsure by 2 %: linear it looks like much, refitted it is not."""
    w = np.linspace(0.8, 1.2, 48)

    def at(x):
        h = 1 / ((1 + x[0]) ** 2 - w**2 + 0.002j * w)
        return h, np.array([-2 * (1 + x[0]) * h])

    wanted, covariance = at(np.array([0.01]))[0], np.array([[0.02**2]])
    left = not_made_up_for(wanted, at, np.zeros(1), covariance, 0.02)
    assert left == pytest.approx(
        0.5 * (0.01 / 0.02) ** 2, rel=0.01
    )  # what the prior says of the step, and no more
    value, slopes = at(np.zeros(1))
    linear = information(
        Predicted(wanted[None], np.zeros((1, 1, 48), dtype=complex), np.zeros((1, 1))),
        Predicted(value[None], slopes[:, None], covariance), 0.02,
    )[0]  # fmt: skip
    assert linear > 10 * left
    sure = not_made_up_for(wanted, at, np.zeros(1), 1e-12 * covariance, 0.02)
    assert sure > 100 * left


def test_everything_that_could_be_measured_is_there(observed, hinged):
    root = hinged[0]
    bench = Bench.of(observed, root.context)
    own = {point.name for point in observed.campaign.points}
    assert {point.name for point in bench.new} == set(root.context.robot.points) - own
    assert not set(bench.rows) & set(bench.other_rows)
    locked = [names for names, _ in bench.fixtures if names]
    assert locked == [(joint,) for joint in root.context.joints]
    assert {name for _, masses in bench.fixtures for name in masses} == {point.name for point in bench.points}
    levels = bench.levels(by_force=True)
    planned, there = bench.planned([(observed.postures[0], bench.rows[:2])], levels)
    assert len(planned) == 2 * len(levels)
    peaks = [planned.peak(number) for number in levels]
    assert peaks[-1] == pytest.approx(3 * max(peaks[:-1])) == bench.peak(levels[-1])
    assert there.pulses[-1].peak == pytest.approx(peaks[-1], rel=0.2)  # beside the pulses that were struck


@pytest.mark.filterwarnings("error")
def test_what_a_model_cannot_predict_tells_nothing():
    """A step of a refit may lead to a robot that has no finite receptance."""
    value = np.array([[0.0, np.nan, 2.0]], dtype=complex)
    slopes = np.array([[[1.0, 1.0, 3.0]]], dtype=complex)
    found = relative(value, slopes, Mock(spec=Sure, covariance=np.eye(1)))
    np.testing.assert_array_equal(found.value, [[0.0, 0.0, 2.0]])
    np.testing.assert_array_equal(found.slopes, [[[0.0, 0.0, 1.5]]])


def test_of_a_model_that_rings_up_records_without_an_end_are_planned(observed, hinged, monkeypatch):
    """It would have no receptance within those of the campaign."""
    hypothesis, fit = hinged[2:]
    one = Sure(hypothesis, fit.x, uncertainty(hypothesis.space, fit.normal, observed).covariance)
    bench = Bench.of(observed, hypothesis.context)
    planned, there = bench.planned([(hypothesis.context.postures[0], bench.rows[:2])], [0])
    asked, lines = [], slice(0, None, 40)

    def evaluated(model, x, planned, lines, *, slopes):
        asked.append(planned)
        if not planned.endless:
            raise SingularResponse("it rings up")
        return evaluated_before(model, x, planned, lines, slopes=slopes)

    evaluated_before = predicting.evaluated
    expected = predicted_by(one, there, unlimited(planned), lines)
    monkeypatch.setattr(predicting, "evaluated", evaluated)
    found = predicted_by(one, there, planned, lines)
    assert len(asked) == 2
    np.testing.assert_array_equal(found.value, expected.value)
    np.testing.assert_array_equal(found.slopes, expected.slopes)
