"""The learning beside the physics: a smooth function found again, and axes that meet at the resonances."""

import numpy as np
import pytest

from flexmodal.identification import RobotModel
from flexmodal.prediction.alignment import aligned, natural_frequencies, resampled
from flexmodal.prediction.process import Features, learn
from flexmodal.prediction.surface import Surface
from flexmodal.structure import robot_space


def coordinates(postures, sliding=()):
    features = Features.of(postures, sliding)
    return np.array([features.at(q) for q in postures])


def test_a_smooth_function_of_posture_is_found_again():
    random = np.random.default_rng(1)
    angles = random.uniform(-1, 1, 14)
    shape = np.array([[1.0, -2.0, 0.5], [0.3, 0.1, -0.4]])

    def rows(q):
        return np.stack([np.ones_like(q), np.sin(q)], axis=1) @ shape

    at = coordinates([{"q": float(q)} for q in (*angles, 0.25)])
    made = learn(rows(angles), at[:-1]).at(at[-1])
    np.testing.assert_allclose(made, rows(np.array([0.25]))[0], atol=0.03)


def test_what_is_the_same_everywhere_is_kept_and_noise_is_not():
    random = np.random.default_rng(2)
    at = coordinates([{"q": float(q)} for q in random.uniform(-1, 1, 9)])
    same = np.tile([1.0, -1.0, 2.0], (8, 1))
    np.testing.assert_allclose(learn(same, at[:-1]).at(at[-1]), same[0], rtol=0.02)
    noise = random.normal(size=(8, 200))
    made = learn(noise, at[:-1]).at(at[-1])
    assert np.sqrt(np.mean(made**2)) < 0.8  # of rows with a root mean square of 1
    np.testing.assert_array_equal(learn(np.zeros((8, 3)), at[:-1]).at(at[-1]), np.zeros(3))


def test_distances_are_those_between_points_on_circles():
    at = coordinates([{"a": 0.1, "b": 2.0}, {"a": 0.4 + 2 * np.pi}])
    expected = abs(np.exp(0.1j) - np.exp(0.4j)) ** 2 + abs(np.exp(2j) - 1) ** 2
    assert np.sum((at[0] - at[1]) ** 2) == pytest.approx(expected)
    slides = coordinates([{"z": 0.0}, {"z": 0.2}], ["z"])
    assert slides[1, 0] - slides[0, 0] == pytest.approx(2.0)


def test_axes_meet_at_the_resonances():
    here, there = np.array([5.0, 20.0, 60.0]), np.array([6.0, 18.0, 70.0, 90.0])
    np.testing.assert_allclose(aligned(here, here, there), there[:3])
    middle = aligned(np.array([10.0]), here, there)[0]  # half way in ln f between 5 and 20
    assert middle == pytest.approx(np.sqrt(6 * 18))
    assert aligned(np.array([2.5]), here, there)[0] == pytest.approx(3.0)
    assert aligned(np.array([120.0]), here, there)[0] == pytest.approx(140.0)
    axis = np.array([1.0, 2.0])
    np.testing.assert_array_equal(aligned(axis, np.zeros(0), there), axis)
    np.testing.assert_array_equal(aligned(axis, np.array([5.0, 5.0]), there), axis)


def test_a_resonance_that_moves_stays_where_it_is_on_the_aligned_axis():
    axis = np.linspace(1, 100, 400)

    def off(f, n, by):  # ln of a resonance over one by a part higher
        return np.log(((n * (1 + by)) ** 2 - f**2 + 0.1j * n * f) / (n**2 - f**2 + 0.1j * n * f))

    moved = off(axis, 40.0, 0.03)[None]
    here = resampled(moved, axis, aligned(axis, np.array([30.0]), np.array([40.0])))[0]
    np.testing.assert_allclose(here[40:250], off(axis, 30.0, 0.03)[40:250], atol=0.03)


def test_what_is_left_of_a_resonance_is_learnt_on_an_axis_of_its_own():
    """A resonance at 20 to 40 Hz, always 3 % higher than the model's: found again where nobody struck."""
    axis = np.linspace(1, 100, 800)

    def off(f, n, by=0.03):
        return np.log(((n * (1 + by)) ** 2 - f**2 + 0.1j * n * f) / (n**2 - f**2 + 0.1j * n * f))

    def pole(q):
        return 30 + 10 * np.sin(q)

    struck = np.linspace(-1.5, 1.5, 6)
    rows, places = [off(axis, pole(q))[None] for q in struck], [{"q": float(q)} for q in struck]
    laid = Surface.of(axis, rows, places, [np.array([pole(q)]) for q in struck])
    left = Surface.of(axis, rows, places)
    here, true = np.array([pole(0.7)]), off(axis, pole(0.7))[None]
    made = laid.at({"q": 0.7}, here)
    assert np.abs(made - true).mean() < 0.1 * np.abs(left.at({"q": 0.7}, here) - true).mean()
    some = np.array([axis[300], axis[301]])
    np.testing.assert_allclose(laid.at({"q": 0.7}, here, some), made[:, 300:302], atol=1e-9)


def test_natural_frequencies_are_the_robots_own(fanuc):
    model = RobotModel(fanuc, robot_space(fanuc))
    q = dict(fanuc.posture("configuration_3").values)
    modes = fanuc.at("configuration_3").modes()
    kept = np.sort(modes.frequency[modes.damping_ratio < 0.5])
    np.testing.assert_allclose(natural_frequencies(model, np.zeros(len(model.space)), q), kept, rtol=1e-6)
