"""The automatic choice of modes: on campaigns of the rig, beside noise, close together, driven away."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from flexmodal.ema import Choices, Measured, choose_peaks, estimate, mode_indicator

from .truth import Truth, measured, real_modes

PATH = Path(__file__).parents[2] / "benchmarks" / "ema_selection.py"
AXIS = np.linspace(2, 120, 400)


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    spec = importlib.util.spec_from_file_location("ema_selection", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["ema_selection"] = module
    spec.loader.exec_module(module)
    return module


def test_an_upright_arm_whose_first_link_hardly_moves(bench: ModuleType) -> None:
    """Its FRFs are noise, and two of the five modes are half a hertz apart."""
    result = bench.campaign("fanuc_s360", "local_absorber", ["configuration_4"], 1)
    for method in ("least-squares", "lscf"):
        (count,) = bench.counts(result, method)
        assert (count.true, count.found, count.false) == (5, 5, 0)


def with_silent_points(truth: Truth, seed: int, *, known: bool) -> Measured:
    """Five FRFs with 1 % noise, and five of points that do not move, of a hundredth of the size."""
    data = measured(truth, AXIS, level=0.01, seed=seed)
    rng = np.random.default_rng([1, seed])
    size = 1e-2 * np.max(np.abs(data.value))
    noise = size * (rng.normal(size=data.value.shape) + 1j * rng.normal(size=data.value.shape))
    variance = None
    if known:
        variance = np.concatenate([data.variance, np.full(noise.shape, 2 * size**2)], axis=1)
    return Measured(AXIS, np.concatenate([data.value, noise], axis=1), "mobility", variance)


@pytest.mark.parametrize("known", [True, False], ids=["noise known", "noise unknown"])
def test_points_that_do_not_move_hide_nothing(four_modes: Truth, known: bool) -> None:
    for seed in range(5):
        data = with_silent_points(four_modes, seed, known=known)
        peaks = choose_peaks(data)
        assert len(peaks) == 4
        for peak, frequency in zip(peaks, four_modes.frequency, strict=True):
            assert peak.frequency == pytest.approx(frequency, rel=0.01)
        assert choose_peaks(data) == peaks
        indicator = mode_indicator(data)
        # What they add to the indicator is one a line and FRF, the noise in units of itself.
        assert indicator[np.argmin(np.abs(AXIS - 51))] > 20 * np.median(indicator)


def test_close_modes_are_two(four_modes: Truth) -> None:
    """Half a half-power bandwidth apart they make one peak; poles that stay tell them apart."""
    truth = real_modes([50.0, 52.0], [0.03, 0.03], np.array([[1.0, 0.8], [0.7, -0.9]]))
    for seed in range(5):
        found = estimate(measured(truth, np.arange(5.0, 100.1, 0.25), level=0.01, seed=seed))
        np.testing.assert_allclose(found.frequency, truth.frequency, rtol=2e-3)  # spread 1e-4 each
        np.testing.assert_allclose(found.damping_ratio, truth.damping, rtol=0.05)


def test_nothing_is_found_in_noise() -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        value = rng.normal(size=(400, 6)) + 1j * rng.normal(size=(400, 6))
        assert choose_peaks(Measured(AXIS, value)) == ()


@pytest.mark.slow
def test_a_mode_that_the_whole_band_drives_away_is_fitted_alone() -> None:
    """Heavy modes at and below the first line leave no room for a light one in a fit of the band."""
    amplitude = np.array([[40.0, 60.0, 50.0, 0.4], [30.0, -50.0, 40.0, -0.6], [20.0, 30.0, -45.0, 0.5]])
    truth = real_modes([1.2, 3.6, 6.5, 38.0], [0.5, 0.45, 0.7, 0.02], amplitude)
    light = []
    for seed in range(5):
        found = estimate(measured(truth, np.arange(2.0, 100.1, 0.25), "inertance", level=0.002, seed=seed))
        light += [mode for mode in found if abs(mode.frequency / 38.0 - 1) < 0.01]
    assert len(light) == 5
    assert all(mode.damping_ratio == pytest.approx(0.02, rel=0.25) for mode in light)


@pytest.mark.slow
def test_what_a_band_of_its_own_leaves_out_does_not_bend_its_mode() -> None:
    """With stiffness and mass lines alone all eight dampings were 0.7 % off, beyond their intervals."""
    amplitude = np.array([[40.0, 60.0, 50.0, 0.4], [30.0, -50.0, 40.0, -0.6], [20.0, 30.0, -45.0, 0.5]])
    truth = real_modes([1.2, 3.6, 6.5, 38.0], [0.5, 0.45, 0.7, 0.02], amplitude)
    held = []
    for seed in range(8):
        data = measured(truth, np.arange(2.0, 100.1, 0.25), "inertance", level=0.0005, seed=seed)
        (mode,) = [mode for mode in estimate(data) if abs(mode.frequency / 38.0 - 1) < 0.01]
        assert any("fitted from" in remark for remark in mode.remarks)
        assert mode.damping_ratio == pytest.approx(0.02, rel=0.004)
        for interval, true in ((mode.frequency_interval(), 38.0), (mode.damping_interval(), 0.02)):
            held.append(interval[0] <= true <= interval[1])
    assert np.mean(held) > 0.8  # of 16 at 95 % fewer than 13 once in a thousand


def test_a_person_still_has_the_last_word(four_modes: Truth) -> None:
    data = with_silent_points(four_modes, 0, known=True)
    assert len(choose_peaks(data, at=[20.0])) == 1
    assert len(choose_peaks(data, forbid=[(45.0, 65.0)])) == 2
    found = estimate(data, "lscf", Choices(at=[51.0, 58.0, 94.0]))
    assert len(found) == 3
