"""Steps of a descent that would be too long."""

import numpy as np
import pytest

from flexmodal.identification.descent import LONGEST, short_step

CURVATURE = np.array([[400.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1e-6]])


def test_a_short_one_is_newton_s():
    gradient = np.array([20.0, -0.4, 1e-7])
    step = short_step(CURVATURE, gradient)
    np.testing.assert_allclose(CURVATURE @ step, -gradient, rtol=0, atol=1e-12)


def test_what_hardly_matters_is_held_back_and_the_rest_goes_on():
    gradient = np.array([200.0, -0.4, 1e-3])  # a thousand along the last coordinate, by Newton's method
    newton, step = -np.linalg.solve(CURVATURE, gradient), short_step(CURVATURE, gradient)
    assert abs(newton[2]) > 100 * LONGEST
    assert np.max(np.abs(step)) <= LONGEST
    assert abs(step[2]) > 0.9 * LONGEST
    np.testing.assert_allclose(step[:2], newton[:2], rtol=0.01)


@pytest.mark.parametrize("seed", range(20))
def test_it_is_short_and_goes_down(seed):
    random = np.random.default_rng(seed)
    root = random.normal(size=(8, 6)) * np.geomspace(1, 1e-7, 6)
    curvature, gradient = root.T @ root + 1e-14 * np.eye(6), random.normal(size=6)
    step = short_step(curvature, gradient)
    assert np.max(np.abs(step)) <= LONGEST * (1 + 1e-9)
    assert gradient @ step < 0
