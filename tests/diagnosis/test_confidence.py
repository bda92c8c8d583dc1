"""How sure an explanation is: by hand where the formula is simple, and what has to lower it."""

import numpy as np
import pytest

from flexmodal.diagnosis.selection.confidence import probabilities

NOTHING = np.zeros(2)


def of(costs, *, pieces=8.0, noise=1.0, odds=0.1, sizes=NOTHING, priors=NOTHING):
    """Probabilities of two models, the second of them named."""
    return probabilities(np.array(costs), sizes, priors, 1, pieces, noise, odds)


def test_by_hand():
    """Costs of 4 and 1 at the noise, ν = 8: (1/4)⁴ against 1 and a tenth."""
    first, second = of([4.0, 1.0])
    assert first == pytest.approx(4.0**-4 / (4.0**-4 + 1 + 0.1), rel=1e-12)
    assert second == pytest.approx(1 / (4.0**-4 + 1 + 0.1), rel=1e-12)


def test_it_is_never_surer_than_the_odds_of_something_else():
    assert of([1e300, 1e-9], pieces=1e3)[1] == pytest.approx(1 / 1.1)
    assert of([1e300, 1e-9], pieces=1e3, odds=0.01)[1] == pytest.approx(1 / 1.01)


def test_what_is_left_above_the_noise_is_somebody_elses():
    at, above, far = (of([50.0, cost])[1] for cost in (1.0, 1.5, 3.0))
    assert at > above > far
    assert above == pytest.approx(1.5**-4 / (50.0**-4 + 1.5**-4 + 0.1), rel=1e-12)


def test_few_frfs_make_nobody_sure():
    few, many = (of([1.3, 1.0], pieces=pieces)[1] for pieces in (3.0, 60.0))
    assert few < 0.6
    assert many > 0.9


def test_parameters_and_odd_values_of_them_cost():
    plain = of([2.0, 1.0])[1]
    assert of([2.0, 1.0], sizes=np.array([0.0, 3.0]))[0] > of([2.0, 1.0])[0]
    assert of([2.0, 1.0], priors=np.array([0.0, 4.0]))[1] < plain
    assert of([2.0, 1.0], priors=np.array([4.0, 4.0]))[1] == pytest.approx(plain, rel=1e-12)
