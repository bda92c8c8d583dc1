"""A hypothesis keeps nothing that could belong to other observations."""

import gc
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.identification import predict
from flexmodal.structure import robot_space


def test_observations_at_an_address_used_before_are_seen_as_they_are(context, observed):
    """Other observations, made and dropped in turn, often stand where those before them stood in memory."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    x = np.zeros(len(hypothesis.space))
    whole = predict(hypothesis, x, observed)
    rng, addresses = np.random.default_rng(0), []
    for _ in range(30):
        keep = rng.permutation(len(observed))[: len(observed) // 2]
        mask = np.zeros(len(observed), dtype=bool)
        mask[keep] = True
        some = observed.keeping(mask)
        addresses.append(id(some))
        np.testing.assert_allclose(predict(hypothesis, x, some), whole[mask], rtol=1e-10)
        del some
        gc.collect()
    assert len(set(addresses)) < len(addresses), "no address came back: the test shows nothing"


def test_other_postures_under_the_same_numbers_are_others(context, observed):
    hypothesis = Hypothesis(context, robot_space(context.robot))
    x = np.zeros(len(hypothesis.space))
    before = predict(hypothesis, x, observed)
    turned = replace(context, postures=tuple(reversed(context.postures)))
    other = predict(Hypothesis(turned, hypothesis.base), x, observed)
    assert np.abs(np.log(other / before)).max() > 0.1
    np.testing.assert_array_equal(predict(hypothesis, x, observed), before)
