"""LSCF on real measurements beside sdypy-EMA's, neither refined; and a measurement that is past help."""

from __future__ import annotations

import csv
import importlib
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import read_campaign
from flexmodal.ema import Choices, Measured, estimate
from flexmodal.ema.of_campaign import records_of

REAL = Path(__file__).parents[1] / "data" / "real"


def peers(dataset: str) -> dict[int, tuple[float, float]]:
    """sdypy-EMA's frequency and damping by mode, at the lowest order that is given."""
    with (REAL / "reference_results.csv").open(newline="") as file:
        rows = [r for r in csv.DictReader(file) if r["dataset"] == dataset and r["peer"].startswith("sdypy")]
    found: dict[int, tuple[float, float]] = {}
    for row in rows:
        found.setdefault(int(row["mode"]), (float(row["natural_frequency_hz"]), float(row["damping_ratio"])))
    return found


def raw(folder: str, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    records = records_of(read_campaign(REAL / folder))
    data = Measured(records.frequency, records.value.T, records.form).within(low, high)
    found = estimate(data, "lscf", Choices(refine=False))
    return found.frequency, found.damping_ratio


def test_the_beam_like_for_like() -> None:
    theirs = peers("pyuff_accelerance_points")
    frequency, damping = raw("free_free_beam", 10.0, 990.0)
    assert len(frequency) == len(theirs) == 6
    np.testing.assert_allclose(frequency, [f for f, _ in theirs.values()], rtol=2e-4)
    # Half-power bands of a twentieth to a quarter of a line: damping is read off between two lines.
    np.testing.assert_allclose(damping, [z for _, z in theirs.values()], rtol=0.2)


def test_the_plate_like_for_like() -> None:
    theirs = peers("mssp_plate_sweep")
    frequency, damping = raw("mssp_plate_sweep", 60.0, 500.0)
    for number in (2, 3, 4, 5):  # the first hardly stands out, the sixth is one mode or two
        place = int(np.argmin(np.abs(frequency - theirs[number][0])))
        assert frequency[place] == pytest.approx(theirs[number][0], rel=0.005)
    fifth = int(np.argmin(np.abs(frequency - theirs[5][0])))
    assert damping[fifth] == pytest.approx(theirs[5][1], rel=0.1)  # the lighter damping of the ripples


@pytest.mark.parametrize(("mode", "lighter"), [(2, 0.25), pytest.param(4, 0.08, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_ripples_make_lscf_find_less_damping_than_there_is(
    monkeypatch: pytest.MonkeyPatch, mode: int, lighter: float
) -> None:
    """The plate's third and fifth mode, with dampings that are known: least squares holds them."""
    monkeypatch.syspath_prepend(str(REAL.parents[2] / "benchmarks"))
    bench = importlib.import_module("ema_ripple")
    frequency, true = bench.TRUE[mode]
    axis, smooth, _ = bench.ripples()

    def lscf(value: np.ndarray) -> float:
        data = Measured(axis, value[:, None], "inertance").within(*bench.BAND)
        found = estimate(data, "lscf", Choices(refine=False))
        return float(found.damping_ratio[np.argmin(np.abs(found.frequency - frequency))])

    assert lscf(bench.known(axis, smooth)) == pytest.approx(true, rel=1e-3)
    held = 0
    for number in range(6):
        _, value = bench.rippled(number)
        assert lscf(value) < (1 - lighter) * true
        found = bench.least_squares(axis, value, mode)
        low, high = found.damping_interval()
        held += low <= true <= high
        assert found.damping_ratio == pytest.approx(true, rel=0.3 if mode == 2 else 0.07)
    assert held >= 5


def test_a_hopeless_measurement_is_called_one() -> None:
    from scipy.io import loadmat

    table = loadmat(REAL / "vibrationtesting_lab_frf" / "case2.mat")
    data = Measured(table["Freq_domain"].ravel(), table["Hf_chan_2"].astype(complex), "receptance")
    found = estimate(data, choices=Choices(band=(187.0, 199.0), at=[192.6]))
    assert not found.is_sound
    assert abs(found.modes[0].frequency / 192.6 - 1) < 0.005
    assert any("damping" in remark for mode in found for remark in mode.remarks)
