"""The evidence of a model that is fitted to all of a sum of squares of which a part counts."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs, fitted_model
from flexmodal.diagnosis.selection.frf_starts import with_last
from flexmodal.identification import fit
from flexmodal.identification.frf_fit import FrfFit, normal_equations
from flexmodal.structure import robot_space

PRECISION = np.array([4.0, 1.0, 0.25])


@pytest.fixture
def line():
    """A sum of squares |y − Jx|² and the least of its sum with the prior, half of the lines in it."""
    rng = np.random.default_rng(7)
    jacobian, y = rng.normal(size=(12, 3)), 5 * rng.normal(size=12)
    share = 2.0
    x = np.linalg.solve(jacobian.T @ jacobian + share * np.diag(PRECISION), jacobian.T @ y)
    hypothesis = Mock(spec=Hypothesis, space=SimpleNamespace(precision=PRECISION))
    model = Mock(
        spec=FittedFrfs,
        hypothesis=hypothesis,
        x=x,
        occam=1.0,
        predicted=np.zeros((1, 8)),
        fitted=Mock(
            spec=FrfFit,
            normal=SimpleNamespace(curvature=jacobian.T @ jacobian / share),
            weighing=SimpleNamespace(lines=np.arange(4)),
        ),
    )
    return model, jacobian, y


@pytest.mark.parametrize("temper", [1e-5, 0.01, 0.3, 0.5, 1.0])
def test_the_least_of_a_part_of_the_sum_and_the_prior(line, temper):
    """Against the least itself, which is known where the model is linear."""
    model, jacobian, y = line

    def value(x):
        return temper * np.sum((y - jacobian @ x) ** 2) + PRECISION @ x**2

    least = np.linalg.solve(temper * jacobian.T @ jacobian + np.diag(PRECISION), temper * jacobian.T @ y)
    found = FittedFrfs.nearer(model, temper)
    assert found == pytest.approx(value(model.x) - value(least), rel=1e-9, abs=1e-9)
    assert found >= 0.0
    assert (found < 1e-9) is (temper == 0.5)


def test_a_parameter_that_nobody_doubts_adds_nothing(line):
    model, *_ = line
    model.x[0], model.hypothesis.space.precision = 0.0, np.array([np.inf, 1.0, 0.25])
    assert np.isfinite(FittedFrfs.nearer(model, 0.1))


def test_a_model_that_does_not_exist_has_no_other_least(line):
    model, *_ = line
    model.occam = np.inf
    assert FittedFrfs.nearer(model, 0.1) == 0.0


def test_a_model_with_another_effect_last_is_the_same_model(context, observed):
    """Its normal equations are those of the parameters in their new order, not of the old model at them."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    for name, where in (("added_mass", context.links[-1]), ("servo_compliance", context.joints[0])):
        hypothesis = hypothesis.and_also(Placed(catalogue()[name], where))
    fitted = fit(hypothesis, observed, floors=(0.2,), steps=2, stride=8)
    model = fitted_model(hypothesis, fitted, observed)
    turned = with_last(model, model.hypothesis.keys[0])
    assert turned.hypothesis.keys == model.hypothesis.keys[::-1]
    assert not np.array_equal(turned.x, model.x)
    again = normal_equations(turned.hypothesis, turned.x, observed, fitted.weighing, apart=fitted.apart)
    for name in ("gradient", "curvature", "scores"):
        own, size = getattr(turned.fitted.normal, name), np.abs(getattr(again, name)).max()
        np.testing.assert_allclose(own, getattr(again, name), rtol=1e-6, atol=1e-8 * size)
    for temper in (0.01, 1.0):
        assert turned.nearer(temper) == pytest.approx(model.nearer(temper), rel=1e-9)
