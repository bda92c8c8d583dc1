"""Peaks, peak picking and the circle: exact properties of one mode, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from flexmodal.ema import Choices, Peak, choose_peaks, estimate, fit_circle, pick_peak
from flexmodal.ema.methods.noise import scatter
from flexmodal.errors import InvalidRequest

from .truth import Truth, measured, real_modes

AXIS = np.linspace(40, 65, 200)


def test_circle_of_one_mode_is_exact(one_mode: Truth) -> None:
    data = measured(one_mode, AXIS)
    fit = fit_circle(data, choose_peaks(data)[0])
    assert not isinstance(fit, str)
    omega = 2 * np.pi * 51.0
    assert fit.mode.frequency == pytest.approx(51.0, rel=1e-9)
    assert fit.mode.damping_ratio == pytest.approx(0.04, rel=1e-8)
    assert 2 * fit.radius == pytest.approx(1.3 / (2 * 0.04 * omega), rel=1e-9)  # |A'|/(2ζω_n)
    np.testing.assert_allclose(fit.mode.residue, one_mode.residue[0], rtol=1e-8)
    np.testing.assert_allclose(fit.pair_damping, 0.04, rtol=1e-6)
    assert fit.half_power_damping == pytest.approx(0.04, rel=1e-3)  # straight lines between the lines
    assert fit.traverse_damping == pytest.approx(0.04, rel=0.05)  # averaged over an eighth of the arc


def test_traverse_rate_at_resonance_is_that_of_the_thesis() -> None:
    """dθ/d(ω²) of θ = arg Y, by finite differences, is 1/(2ζω_n²) at ω_n and nearly its maximum."""
    natural, damping = 2 * np.pi * 51.0, 0.04
    omega = np.linspace(0.98, 1.02, 20001) * natural
    phase = np.angle(1j * omega / (natural**2 - omega**2 + 2j * damping * natural * omega))
    rate = -np.gradient(phase, omega**2)
    assert rate[10000] == pytest.approx(1 / (2 * damping * natural**2), rel=1e-6)
    assert np.max(rate) == pytest.approx(rate[10000], rel=2 * damping**2)


def test_phase_of_a_complex_residue_comes_from_the_place_on_the_circle() -> None:
    truth = real_modes([51.0], [0.02], np.array([[1.0 * np.exp(0.5j)]]))
    data = measured(truth, AXIS)
    fit = fit_circle(data, choose_peaks(data)[0])
    assert not isinstance(fit, str)
    # The conjugate pole adds some ζ times the phase's sine to a complex mode, which no circle knows of.
    assert np.angle(fit.mode.residue[0] / truth.residue[0, 0]) == pytest.approx(0, abs=0.01)


def test_circle_keeps_forced_numbers(one_mode: Truth) -> None:
    data = measured(one_mode, AXIS, level=0.01)
    found = estimate(data, "circle", Choices(damping={51.0: 0.05}))
    assert found.modes[0].damping_ratio == 0.05
    assert found.modes[0].damping_error == 0


def test_circle_says_why_not(one_mode: Truth) -> None:
    data = measured(one_mode, np.linspace(40, 65, 12))
    said = fit_circle(data, choose_peaks(data, at=[51.0])[0])
    assert isinstance(said, str)
    assert "lines on the arc" in said
    noise = measured(one_mode, AXIS, level=30.0)
    assert isinstance(fit_circle(noise, Peak(51.0, 45.0, 60.0, 4.0)), str)


def test_half_power_of_one_mode(one_mode: Truth) -> None:
    data = measured(one_mode, AXIS)
    mode = pick_peak(data, choose_peaks(data)[0])
    assert not isinstance(mode, str)
    # A parabola of 1/|Y|² and straight flanks neglect terms of order ζ² and of the line spacing.
    assert mode.frequency == pytest.approx(51.0, rel=1e-4)
    assert mode.damping_ratio == pytest.approx(0.04, rel=5e-3)
    np.testing.assert_allclose(mode.residue, one_mode.residue[0], rtol=1e-2)


def test_half_power_on_one_side_only(one_mode: Truth) -> None:
    data = measured(one_mode, np.linspace(50.2, 65, 120))
    mode = pick_peak(data, choose_peaks(data, at=[51.0])[0])
    assert not isinstance(mode, str)
    assert "one half-power point" in mode.remarks[0]
    assert mode.damping_ratio == pytest.approx(
        0.04, rel=0.05
    )  # the parabola's top is less sure than two sides


def test_peaks_are_found_in_noise_and_none_in_noise_alone(four_modes: Truth) -> None:
    for seed in range(5):
        data = measured(four_modes, np.linspace(2, 120, 400), level=0.01, seed=seed)
        peaks = choose_peaks(data)
        assert len(peaks) == 4
        # A peak of the indicator lies within half its width of the mode.
        assert all(
            abs(p.frequency - f) < p.width / 2 for p, f in zip(peaks, four_modes.frequency, strict=True)
        )
        assert choose_peaks(data) == peaks  # repeats exactly
    rng = np.random.default_rng(3)
    value = rng.normal(size=(400, 2)) + 1j * rng.normal(size=(400, 2))
    from flexmodal.ema import Measured

    nothing = Measured(np.linspace(2, 120, 400), value)
    assert choose_peaks(nothing) == ()
    found = estimate(nothing)
    assert len(found) == 0
    assert "no peak" in found.verdict


def test_a_person_overrides_the_choice(four_modes: Truth) -> None:
    data = measured(four_modes, np.linspace(2, 120, 400))
    assert [p.frequency for p in choose_peaks(data, at=[20.0, 9.0])] == [9.0, 20.0]
    assert all(p.by_hand for p in choose_peaks(data, at=[20.0]))
    left = [p.frequency for p in choose_peaks(data, forbid=[(45.0, 65.0)])]
    assert len(left) == 2
    assert not any(45 <= f <= 65 for f in left)
    held = [p for p in choose_peaks(data, hold_frequency=[51.5]) if p.holds_frequency]
    assert [p.frequency for p in held] == [51.5]
    with pytest.raises(InvalidRequest, match="tenth"):
        choose_peaks(data, damping={30.0: 0.1})


def test_noise_is_estimated_without_being_told(four_modes: Truth) -> None:
    data = measured(four_modes, np.linspace(2, 120, 2000), level=0.01)
    # The median over 41 lines of exponentially distributed numbers scatters by about 1.44/√41 = 23 %,
    # correlated over the third differences; the mean over all lines by far less.
    assert np.mean(scatter(data.value)) == pytest.approx(np.mean(data.variance), rel=0.15)


def test_pooling_over_frfs(four_modes: Truth) -> None:
    data = measured(four_modes, np.linspace(2, 120, 600), level=0.002)
    for method, allowance in (("peaks", 0.05), ("circle", 0.03)):
        found = estimate(data, method)
        assert len(found) == 4
        assert found.residue.shape == (5, 4)
        # The neighbours' pull, some damping times their share of the signal, is not in the stated error.
        np.testing.assert_allclose(found.frequency[[0, 3]], [8.0, 94.0], rtol=0.02)
        np.testing.assert_allclose(found.damping_ratio[0], 0.06, rtol=allowance)
