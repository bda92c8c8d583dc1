"""A hypothesis keeps nothing that could belong to other observations."""

import gc
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import predict
from flexmodal.identification.frf_fit import FrfMisfit, Weighting
from flexmodal.structure import robot_space


def test_observations_at_an_address_used_before_are_seen_as_they_are(context, observed):
    """Other observations, made when those before them are gone, may stand where they stood in memory."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    x = np.zeros(len(hypothesis.space))
    whole = predict(hypothesis, x, observed)
    rng = np.random.default_rng(0)

    def half():
        mask = np.zeros(len(observed), dtype=bool)
        mask[rng.permutation(len(observed))[: len(observed) // 2]] = True
        return mask, observed.keeping(mask)

    mask, some = half()
    np.testing.assert_allclose(predict(hypothesis, x, some), whole[mask], rtol=1e-10)
    before = id(some)
    for _ in range(2000):
        del some
        gc.collect(0)
        mask, some = half()
        if id(some) == before:
            break
    np.testing.assert_allclose(predict(hypothesis, x, some), whole[mask], rtol=1e-10)


def test_other_postures_under_the_same_numbers_are_others(context, observed):
    hypothesis = Hypothesis(context, robot_space(context.robot))
    x = np.zeros(len(hypothesis.space))
    before = predict(hypothesis, x, observed)
    turned = replace(context, postures=tuple(reversed(context.postures)))
    other = predict(Hypothesis(turned, hypothesis.base), x, observed)
    assert np.abs(np.log(other / before)).max() > 0.1
    np.testing.assert_array_equal(predict(hypothesis, x, observed), before)


def test_derivatives_after_a_look_are_those_without_one(context, observed):
    """A fit asks for derivatives where it has just looked at the cost: of motions, of springs, of sensors."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    for name in ("link_flexibility", "local_absorber", "sensor_gain", "structural_damping"):
        effect = catalogue()[name]
        hypothesis = hypothesis.and_also(Placed(effect, effect.places(context)[0]))
    weighing = Weighting(0.05, np.arange(0, len(observed.axis), 7))
    x, other = (np.full(len(hypothesis.space), value) for value in (0.01, 0.03))
    misfit, fresh = (FrfMisfit(hypothesis, observed, weighing) for _ in range(2))
    misfit.cost(other)
    cost = misfit.cost(x)
    found, expected = misfit.equations(x), fresh.equations(x)
    assert cost == found.cost == expected.cost
    np.testing.assert_array_equal(found.gradient, expected.gradient)
    apart = fresh.equations(x, apart=True)
    size = np.sqrt(np.outer(*2 * [np.diag(apart.curvature)]))
    np.testing.assert_allclose(found.curvature, apart.curvature, atol=1e-9 * size.max())
    step = 1e-5 * np.eye(len(x))
    slope = [(fresh.cost(x + one) - fresh.cost(x - one)) / 4e-5 for one in step]  # half the cost
    np.testing.assert_allclose(found.gradient, slope, rtol=1e-3, atol=1e-4 * np.abs(slope).max())
