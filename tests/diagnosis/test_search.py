"""Coarse looks: which lines they see, and where effects set out."""

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.coarse import look_at
from flexmodal.diagnosis.search.lines import WORST, some_lines, worst_lines
from flexmodal.identification import predict
from flexmodal.structure import robot_space


def test_worst_lines_lie_where_a_model_is_off(observed):
    observations = observed
    off = slice(60, 75)
    predicted = observations.value.copy()
    predicted[:, off] *= 1.5
    lines = worst_lines(observations, predicted)
    assert 2 <= len(lines) <= WORST
    assert np.all((lines >= off.start) & (lines < off.stop))
    predicted[:, 20] *= 1.5
    assert np.isin(20, worst_lines(observations, predicted))


def test_a_model_that_is_off_nowhere_adds_none(observed):
    observations = observed
    assert not worst_lines(observations, observations.value).size
    plain = look_at(observations)
    assert np.array_equal(plain.lines, some_lines(observations, 48))
    assert np.array_equal(look_at(observations, [3, 7]).lines, np.union1d(plain.lines, [3, 7]))


@pytest.mark.parametrize("mass", [0.1, 0.5])
def test_some_start_of_an_absorber_is_nearer_than_none(context, observed, mass):
    """A light one too: what it does must show through what the start does wrong."""
    observations = observed
    absorber = catalogue()["local_absorber"]
    placed = Placed(absorber, "link_3")
    root = Hypothesis(context, robot_space(context.robot))
    hypothesis = root.and_also(placed)
    zero = np.zeros(len(root.space))
    true = {"mass": mass, "frequency": 47.0, "damping_ratio": 0.05, "along": 0.6}
    there = np.log(predict(hypothesis, hypothesis.start(placed, true, zero), observations))

    def far(value):
        return float(np.sum(np.abs(np.log(value) - there) ** 2))

    starts = absorber.starts(context, "link_3")
    costs = [far(predict(hypothesis, hypothesis.start(placed, one, zero), observations)) for one in starts]
    best = starts[int(np.argmin(costs))]
    assert min(costs) < far(predict(root, zero, observations))
    assert 0.8 < best["frequency"] / 47.0 < 1.25
    assert 0.1 < best["mass"] / mass < 10
