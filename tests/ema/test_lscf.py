"""LSCF: exact data, agreement with sdypy-EMA, the rules of the diagram, the window, whole campaigns."""

from __future__ import annotations

import contextlib
import io
import json

import numpy as np
import pytest

from flexmodal.campaign import FrfRecords
from flexmodal.ema import (
    Choices,
    Tolerances,
    as_json,
    estimate,
    fit,
    modes_of,
    stabilise,
    without_window,
)
from flexmodal.errors import InvalidRequest

from .truth import Truth, measured, noisy, real_modes

AXIS = np.linspace(1, 120, 239)


def test_exact_data_are_stable_from_a_low_order_on(four_modes: Truth) -> None:
    diagram = stabilise(measured(four_modes, AXIS), highest=24)
    chosen = diagram.choose()
    # The conjugate poles and the residual lie outside the band and are followed by polynomials only.
    np.testing.assert_allclose(diagram.frequency[chosen], four_modes.frequency, rtol=1e-5)
    np.testing.assert_allclose(diagram.damping_ratio[chosen], four_modes.damping, rtol=1e-3)
    assert all(len(column) >= 10 for column in diagram.columns())


def test_agrees_with_sdypy_ema() -> None:
    """Another program's LSCF, with real coefficients on half the circle, on the same noisy FRFs."""
    from sdypy import EMA

    amplitude = np.array([[1.0, 1.2, 0.8, 1.0], [1.0, -0.7, 0.9, 0.6]])
    truth = real_modes([30.0, 51.0, 58.0, 94.0], [0.01] * 4, amplitude)
    data = measured(truth, np.arange(0.0, 120.5, 0.5), "inertance", level=1e-4, seed=3)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        peer = EMA.Model(
            np.pad(data.value.T, ((0, 0), (1, 0))),
            np.append(0.0, data.frequency),
            lower=1,
            upper=120,
            pol_order_high=40,
            frf_form="accelerance",
        )
        peer.get_poles(method="lscf", show_progress=False)
    ours = estimate(data, "lscf", Choices(highest_order=30, refine=False))
    assert len(ours) == 4
    # Its own choice of poles looks 25 Hz around and takes neighbours; so the nearest of its highest order.
    poles = np.stack([np.array(peer.pole_freq[-1]), np.array(peer.pole_xi[-1])])
    poles = poles[:, (poles[0] > 0) & (poles[1] > 0)]
    nearest = poles[:, np.argmin(np.abs(poles[0][None] - truth.frequency[:, None]), axis=1)]
    # Noise of 1e-4 scatters frequencies by some 1e-5 and damping ratios by some 1e-3; the peer's fit of the
    # conjugate poles and residuals by real polynomials differs from ours by a little more.
    np.testing.assert_allclose(ours.frequency, nearest[0], rtol=2e-4)
    np.testing.assert_allclose(ours.damping_ratio, nearest[1], rtol=0.02)


def test_tolerances_and_hand_picks(four_modes: Truth) -> None:
    data = measured(four_modes, AXIS, level=0.003, seed=4)
    wide = stabilise(data, highest=20)
    tight = stabilise(data, highest=20, tolerances=Tolerances(frequency=1e-5, damping=1e-4))
    assert tight.stable.sum() < wide.stable.sum()
    one = modes_of(wide, Choices(at=[58.0], refine=False))
    assert len(one) == 1
    assert one.modes[0].frequency == pytest.approx(58.0, rel=2e-3)  # the poles of all orders lie that close
    with pytest.raises(InvalidRequest, match="stable pole"):
        modes_of(wide, Choices(at=[75.0]))
    with pytest.raises(InvalidRequest) as caught:
        Tolerances(frequency=0.0, damping=-1.0)
    assert len(caught.value.faults) == 2
    with pytest.raises(InvalidRequest, match="orders"):
        stabilise(data, highest=500)


def test_the_damping_of_an_exponential_window_comes_out(four_modes: Truth) -> None:
    """Multiplying an impulse response by exp(−dt) moves every pole by −d and leaves the residues."""
    decay = 3.0
    moved = four_modes.pole - decay
    windowed = Truth(np.abs(moved) / (2 * np.pi), -moved.real / np.abs(moved), four_modes.residue)
    found = estimate(measured(windowed, AXIS), choices=Choices(residuals="none"))
    mended = without_window(found, decay)
    np.testing.assert_allclose(mended.frequency, four_modes.frequency, rtol=1e-8)
    np.testing.assert_allclose(mended.damping_ratio, four_modes.damping, rtol=1e-7)
    np.testing.assert_allclose(mended.synthesise(), found.synthesise(), rtol=1e-9)  # of what was measured
    assert mended.misfit < 1e-8
    too_much = without_window(found, 1e3)
    assert all("more than all" in mode.remarks[-1] for mode in too_much)
    with pytest.raises(InvalidRequest, match="decay"):
        without_window(found, -1.0)


def _records(truth: Truth, postures: int, trials: int) -> FrfRecords:
    rng = np.random.default_rng(9)
    value, table = [], []
    for posture in range(1, postures + 1):
        clean = truth.frf(AXIS)[:, :3]
        for trial in range(1, trials + 1):
            draw, _ = noisy(clean, 0.01, rng)
            value += list(draw.T)
            table += [(posture, trial, point, 2) for point in (1, 2, 3)]
    where = np.array(table)
    axis = np.full(len(where), 3)
    return FrfRecords(
        coherence=None,
        frequency=AXIS, value=np.array(value), posture=where[:, 0], trial=where[:, 1], form="mobility",
        response=np.stack([where[:, 2], axis], axis=1), reference=np.stack([where[:, 3], axis], axis=1),
    )  # fmt: skip


@pytest.mark.parametrize("per", ["frf", "posture"])
def test_a_campaign_gives_json_rows(four_modes: Truth, per: str) -> None:
    records = _records(four_modes, 2, 3)
    fits = fit(records, per=per, choices=Choices(at=[8.0, 51.0, 58.0, 94.0]))
    assert len(fits) == (6 if per == "frf" else 2)
    answer = json.loads(json.dumps(as_json(fits), allow_nan=False))
    assert len(answer["modes"]) == 24
    for row in answer["modes"]:
        truth = four_modes.frequency[row["mode"] - 1]
        assert row["response"][0] in (1, 2, 3)
        assert row["reference"] == [2, 3]
        # Six standard errors: never beyond among 24 numbers, unless the errors are wrong.
        assert abs(row["frequency"] - truth) < 6 * row["uncertainty"]["frequency"]


def test_trials_apart_and_bad_requests(four_modes: Truth) -> None:
    records = _records(four_modes, 1, 2)
    fits = fit(records, "circle", trials="separate")
    assert len(fits) == 6
    assert {place.trial for one in fits for place in one.places} == {1, 2}
    for wrong in ({"method": "odd"}, {"per": "odd"}, {"trials": "odd"}):
        with pytest.raises(InvalidRequest, match="odd"):
            fit(records, **wrong)
    records = records.take([])
    with pytest.raises(InvalidRequest, match="none"):
        fit(records)
