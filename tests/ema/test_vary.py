"""What choices of the analyst do to the uncertainty: it grows where they matter and nowhere else."""

from __future__ import annotations

import json

import numpy as np
import pytest

from flexmodal.campaign import FrfRecords
from flexmodal.ema import Choices, Measured, ModeEstimate, as_json, estimate, fit
from flexmodal.ema.methods.least_squares import build_least_squares, solve_many
from flexmodal.ema.methods.select import choose_peaks

from .truth import Truth, measured, noisy, real_modes

REPEATS = 60


def held(mode: ModeEstimate, true: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Whether frequency, damping and |A| lie in the whole interval, and in that by noise alone."""
    away = np.abs([mode.frequency, mode.damping_ratio, abs(mode.residue[0])] - np.array(true))
    return away <= mode.reach(), away <= 1.96 * mode.by_noise


@pytest.mark.slow
def test_a_neighbour_pulls_a_circle_further_than_noise_says() -> None:
    truth = real_modes([30.0, 50.0, 80.0], [0.03] * 3, np.array([[1.0, 1.0, 1.0]]))
    true = (50.0, 0.03, abs(truth.residue[0, 1]))
    axis, hits = np.arange(5.0, 100.1, 0.25), []
    for seed in range(REPEATS):
        data = measured(truth, axis, level=0.003, seed=seed)
        hits.append(held(estimate(data, "circle", Choices(at=[30.0, 50.0, 80.0])).modes[1], true))
    whole, noise = np.mean(hits, axis=0)
    assert noise[2] < 0.2  # the residue is off by some per cent, its noise is a tenth of that
    assert np.all(whole >= 0.9)


@pytest.mark.slow
def test_residual_terms_matter_where_a_mode_lies_beyond_the_band() -> None:
    truth = real_modes([51.0, 66.0], [0.04, 0.03], np.array([[1.0, 1.5]]))
    true = (51.0, 0.04, abs(truth.residue[0, 0]))
    axis = np.arange(40.0, 60.1, 0.25)
    hits = []
    for seed in range(REPEATS):
        data = measured(truth, axis, level=0.005, seed=seed)
        found = estimate(data, choices=Choices(at=[51.0], residuals="real"))
        hits.append(held(found.modes[0], true))
    whole, noise = np.mean(hits, axis=0)
    assert noise[2] < 0.5
    assert np.all(whole >= 0.9)


@pytest.mark.slow
def test_a_strong_neighbour_beyond_the_band_takes_more_than_two_residual_terms() -> None:
    """U and L of any phase do not stand for a mode 6 Hz above the last line; a term more of each does."""
    truth = real_modes([51.0, 66.0], [0.04, 0.03], np.array([[1.0, 1.5]]))
    hits = []
    for seed in range(REPEATS):
        data = measured(truth, np.arange(40.0, 60.1, 0.25), level=0.005, seed=seed)
        found = estimate(data, choices=Choices(at=[51.0]))
        hits.append(held(found.modes[0], (51.0, 0.04, 1.0)))
    whole, noise = np.mean(hits, axis=0)
    assert np.all(noise[:2] < 0.1)
    assert np.all(whole[:2] >= 0.9)


def test_a_choice_that_does_not_fit_does_not_count() -> None:
    """Residual terms in phase with the force leave many times the noise here: nobody would stand by them."""
    truth = real_modes([51.0], [0.04], np.array([[1.3]]))
    off = Truth(truth.frequency, truth.damping, truth.residue, upper=5e-5j)
    axis = np.linspace(40, 62, 160)
    data = measured(off, axis, level=0.002, seed=3)
    mode = estimate(data, choices=Choices(at=[51.0])).modes[0]
    real = estimate(data, choices=Choices(at=[51.0], residuals="real", vary=False)).modes[0]
    assert abs(real.damping_ratio - mode.damping_ratio) > 10 * mode.damping_error
    assert abs(mode.damping_ratio - 0.04) < mode.reach()[1]


def test_forced_numbers_have_no_uncertainty_and_unvaried_ones_none_by_choice(four_modes: Truth) -> None:
    data = measured(four_modes, np.linspace(2, 120, 400), level=0.01)
    at = [8.0, 51.0, 58.0, 94.0]
    found = estimate(data, choices=Choices(at=at, damping={58.0: 0.045}, hold_frequency=(94.0,)))
    assert found.modes[2].damping_error == 0
    assert found.modes[3].frequency_error == 0
    for method in ("least-squares", "circle", "peaks"):
        plain = estimate(data, method, Choices(at=at, vary=False))
        assert all(np.all(mode.by_choices == 0) for mode in plain)
        assert all(mode.frequency_error == mode.by_noise[0] for mode in plain)


def test_the_parts_of_the_uncertainty_add_up_in_quadrature(four_modes: Truth) -> None:
    axis = np.linspace(2, 120, 300)
    value = noisy(four_modes.frf(axis)[:, :3], 0.01, np.random.default_rng(2))[0].T
    ones, place = np.ones(3, dtype=int), np.array([[1, 3], [2, 3], [3, 3]])
    records = FrfRecords(
        coherence=None,
        frequency=axis, value=value, posture=ones, trial=ones, response=place, reference=place[[0, 0, 0]],
        form="mobility",
    )  # fmt: skip
    rows = as_json(fit(records, choices=Choices(weighting="logarithmic")))["modes"]
    assert rows
    assert any(row["uncertainty"]["choices"]["residue"] > 0 for row in rows)
    for row in json.loads(json.dumps(rows, allow_nan=False)):
        stated = row["uncertainty"]
        for name in ("frequency", "damping_ratio", "residue"):
            both = np.hypot(stated["noise"][name], stated["choices"][name])
            assert stated[name] == pytest.approx(both, rel=1e-12)
            low, high = stated[f"{name}_95"]
            assert high - low >= 2 * 1.95 * both  # Student's factor is never below the normal one


def test_noise_that_is_larger_round_the_resonance_is_stated_there() -> None:
    """Unknown noise, five times as large within 3 Hz of the peak: one figure for the band would not cover."""
    truth = real_modes([51.0], [0.04], np.array([[1.3]]))
    axis = np.linspace(30, 72, 340)
    clean, rng = truth.frf(axis), np.random.default_rng(8)
    sigma = 0.004 * np.max(np.abs(clean)) * np.where(np.abs(axis - 51) < 3, 5.0, 1.0)[:, None]
    draws = []
    for _ in range(200):
        noise = rng.normal(size=(2, *clean.shape)) / np.sqrt(2)
        draws.append(Measured(axis, clean + sigma * (noise[0] + 1j * noise[1]), "mobility"))
    peaks = choose_peaks(draws[0], at=[51.0])
    found = solve_many([build_least_squares(draw, peaks, residuals="real") for draw in draws])
    true = (51.0, 0.04, abs(truth.residue[0, 0]))
    share = np.mean([held(one.modes[0], true)[0] for one in found], axis=0)
    assert np.all((share >= 0.90) & (share <= 0.99)), share
