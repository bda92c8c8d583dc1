"""The evidence of a model that is fitted to all of a sum of squares of which a part counts."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.identification.frf_fit import FrfFit

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
