"""No clear peak is dropped in silence: each has a mode or a reason, whatever the method and the band."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import read_campaign
from flexmodal.ema import Choices, EstimatedModes, Measured, estimate, fit, records_of
from flexmodal.ema.methods.fillers import without_fillers
from flexmodal.ema.methods.least_squares import LeastSquaresProblem, solve_least_squares
from flexmodal.frf.form import convert

from .truth import measured, real_modes

REAL = Path(__file__).parents[1] / "data" / "real"
QUICK = Choices(vary=False)


def peaks_by_scipy(found: EstimatedModes, height: float) -> np.ndarray:
    """Peaks of the sum of squared mobilities, each FRF by its own median, after a median of three lines."""
    from scipy.signal import find_peaks, medfilt

    data = found.measured
    power = np.abs(convert(data.value, data.frequency, data.form, "mobility")) ** 2
    level = 10 * np.log10(np.sum(power / np.median(power, axis=0), axis=1))
    tops = find_peaks(level, prominence=height)[0]
    steady = find_peaks(medfilt(np.pad(level, 2, mode="edge"), 3)[2:-2], prominence=height)[0]
    lines = [top for top in tops if len(steady) and np.min(np.abs(steady - top)) <= 3]
    return np.asarray(data.frequency[lines])


def silent(found: EstimatedModes, height: float = 10.0) -> list[float]:
    """Clear peaks without a mode and without a reason."""
    told = [mode.frequency for mode in found] + [frequency for frequency, _ in found.refused]
    near = [max(0.02 * f, 2 * found.measured.spacing) for f in told]
    return [
        float(peak)
        for peak in peaks_by_scipy(found, height)
        if not any(abs(f - peak) <= reach for f, reach in zip(told, near, strict=True))
    ]


@pytest.mark.some(3)
@pytest.mark.parametrize("method", ["least-squares", "lscf", "peaks", "circle"])
@pytest.mark.parametrize(
    ("folder", "band"),
    [
        ("free_free_beam", (10.0, 990.0)),
        ("laboratory_hammer", (10.0, 490.0)),
        ("mssp_plate_sweep", (60.0, 500.0)),
        pytest.param("free_free_beam", (100.0, 700.0), marks=pytest.mark.slow),
        pytest.param("laboratory_hammer", (190.0, 235.0), marks=pytest.mark.slow),
        pytest.param("mssp_plate_sweep", (60.0, 300.0), marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("per", ["frf", "posture"])
def test_real_peaks_have_a_mode_or_a_reason(
    folder: str, band: tuple[float, float], method: str, per: str
) -> None:
    campaign = replace(read_campaign(REAL / folder), band=band)
    for one in fit(campaign, method, per=per, choices=QUICK):
        assert silent(one.modes) == []


@pytest.mark.slow
def test_the_plate_has_its_modes_in_any_band() -> None:
    """Ripples made peaks that crowded the third and the fifth mode out, without a word."""
    campaign = read_campaign(REAL / "mssp_plate_sweep")
    for band, count in (((60.0, 500.0), 6), ((60.0, 300.0), 4), ((100.0, 400.0), 4)):
        (one,) = fit(replace(campaign, band=band), choices=QUICK)
        clear = [f for f in (77.0, 126.0, 214.5, 263.5, 347.0, 449.0) if band[0] < f < band[1]]
        assert len(clear) == count
        for frequency in clear:
            assert np.min(np.abs(one.modes.frequency / frequency - 1)) < 0.02


def test_a_peak_below_the_band_of_others_is_found_alone() -> None:
    """At 34 Hz the laboratory's FRF rises by 50 dB on two lines; the fit of the whole band does not see
    it."""
    campaign = replace(read_campaign(REAL / "laboratory_hammer"), band=(10.0, 490.0))
    (one,) = fit(campaign, choices=QUICK)
    assert np.min(np.abs(one.modes.frequency - 34.06)) < 0.2
    mode = one.modes.modes[int(np.argmin(np.abs(one.modes.frequency - 34.06)))]
    assert any("leaves its peak unexplained" in remark for remark in mode.remarks)
    assert all(why for _, why in one.modes.refused)


def filled(level: float = 0.002, seed: int = 1) -> tuple[Measured, LeastSquaresProblem]:
    """Two modes and noise, begun with a third of 40 % where nothing is."""
    truth = real_modes([40.0, 70.0], [0.02, 0.03], np.array([[1.0, 0.8], [0.7, -0.9], [0.5, 1.0]]))
    data = measured(truth, np.linspace(5, 100, 400), level=level, seed=seed)
    start = np.array([[40.0, 0.02], [55.0, 0.4], [70.0, 0.03]])
    return data, LeastSquaresProblem(data, start, np.ones((3, 2), dtype=bool), vary=False, keep=True)


def test_a_filler_is_refused_with_the_reason() -> None:
    refused = 0
    for seed in range(5):
        _, problem = filled(seed=seed)
        found = solve_least_squares(problem)
        heavy = [mode for mode in found if mode.damping_ratio > 0.3]
        after = without_fillers(problem, found)
        assert all(mode.damping_ratio <= 0.3 for mode in after)
        assert len(after.refused) - len(found.refused) == len(heavy)
        refused += len(heavy)
        if heavy:
            assert any("lines held out" in why for _, why in after.refused)
            np.testing.assert_allclose(after.frequency, [40.0, 70.0], rtol=1e-3)
    assert refused >= 2


def test_a_heavy_mode_that_is_there_stays() -> None:
    truth = real_modes([40.0, 60.0], [0.02, 0.4], np.array([[0.3, 3.0], [0.2, -3.0], [-0.3, 4.0]]))
    data = measured(truth, np.linspace(5, 150, 500), level=0.002, seed=3)
    start = np.array([[40.0, 0.02], [60.0, 0.4]])
    problem = LeastSquaresProblem(data, start, np.ones((2, 2), dtype=bool), vary=False)
    after = without_fillers(problem, solve_least_squares(problem))
    assert after.refused == ()
    np.testing.assert_allclose(after.damping_ratio, [0.02, 0.4], rtol=0.05)


def test_forbidden_peaks_are_named() -> None:
    truth = real_modes([40.0, 70.0], [0.02, 0.03], np.array([[1.0, 0.8], [0.7, -0.9]]))
    data = measured(truth, np.linspace(5, 100, 400), level=0.002, seed=1)
    found = estimate(data, choices=Choices(vary=False, forbid=[(65.0, 75.0)]))
    assert [round(f) for f in found.frequency] == [40]
    assert any(65 <= f <= 75 and "forbidden" in why for f, why in found.refused)


def test_no_mode_is_there_twice() -> None:
    """Pieces of a band join without a double at the seam."""
    for folder, band in (("mssp_plate_sweep", (60.0, 500.0)), ("laboratory_hammer", (10.0, 490.0))):
        campaign = read_campaign(REAL / folder)
        records_of(campaign)
        (one,) = fit(replace(campaign, band=band), choices=QUICK)
        modes = one.modes.modes
        for left, right in pairwise(modes):
            apart = right.frequency - left.frequency
            assert apart > min(left.damping_ratio * left.frequency, right.damping_ratio * right.frequency)
