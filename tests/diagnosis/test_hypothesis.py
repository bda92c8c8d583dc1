"""A hypothesis keeps nothing that could belong to other observations."""

import gc
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import predict
from flexmodal.identification.frf_fit import FrfMisfit, Weighting
from flexmodal.structure import robot_space
from flexmodal.structure.frame import Frames


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
    np.testing.assert_allclose(predict(hypothesis, x, observed), before, rtol=1e-10)


@pytest.mark.slow
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


@pytest.mark.parametrize("variants", [("response",), ("blow",), ("response", "blow")])
def test_systems_apart_by_sensor_or_blow_have_their_own_rows_and_the_same_receptances(
    context, observed, variants
):
    """An effect that does nothing, but says that it depends on them, beside one turned and one bent."""
    still = Effect("still", "does nothing", lambda context: ("x",), lambda c, w: (), lambda c, w: [{}])
    bent, turned = (catalogue()[name] for name in ("link_flexibility", "sensor_misalignment"))
    plain = Hypothesis(context, robot_space(context.robot))
    plain = plain.and_also(Placed(bent, "link_2")).and_also(Placed(turned, turned.places(context)[0]))
    apart = plain.and_also(Placed(replace(still, variants=variants), "x"))
    x = np.full(len(plain.space), 0.01)
    groups = (model.groups(x, observed, slopes=True) for model in (plain, apart))
    for one, other in zip(*groups, strict=True):
        assert len(other.structures) > len(one.structures)
        own, every = other.part, one.part
        assert ("response" in variants) == (own.entries.rows[0] < every.entries.rows[0])
        assert ("blow" in variants) == (own.entries.rows[1] < every.entries.rows[1])
        np.testing.assert_array_equal(own.read[own.entry], observed.response[own.observations])
    np.testing.assert_allclose(predict(apart, x, observed), predict(plain, x, observed), rtol=1e-9)
    weighing = Weighting(0.05, np.arange(0, len(observed.axis), 7))
    found = [FrfMisfit(model, observed, weighing).equations(x) for model in (apart, plain)]
    np.testing.assert_allclose(
        found[0].curvature, found[1].curvature, rtol=1e-6, atol=1e-6 * np.abs(found[1].curvature).max()
    )


def test_frames_are_kept_up_to_a_size_those_used_last_longest(context, observed):
    hypothesis = Hypothesis(context, robot_space(context.robot))
    predict(hypothesis, np.zeros(len(hypothesis.space)), observed)
    frame, made = next(iter(context.frames.kept.values())), []
    frames = Frames(most=2.5 * frame.size)
    for key in (1, 2, 1, 3, 1, 2):
        assert frames.get(key, lambda key=key: made.append(key) or frame) is frame
    assert made == [1, 2, 3, 2]
    small = Frames(most=0.0)
    for key in (1, 2):
        small.get(key, lambda: frame)
    assert list(small.kept) == [2], "the last one is kept however large"
