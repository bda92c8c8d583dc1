"""The 95 % intervals of every method hold the truth 90 to 99 % of 200 times, for each number.

They are the whole intervals as `flexmodal fit` states them, choices of the analyst included.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmodal.ema import (
    Choices,
    Measured,
    build_least_squares,
    choose_peaks,
    estimate,
)
from flexmodal.ema.methods.least_squares import solve_many
from flexmodal.ema.mode import ModeEstimate

from .truth import Truth, noisy, real_modes

REPEATS = 200


def _hits(modes: list[ModeEstimate], truth: Truth) -> list[bool]:
    hits = []
    for place, mode in enumerate(modes):
        low, high = mode.residue_interval()
        hits += [
            mode.frequency_interval()[0] <= truth.frequency[place] <= mode.frequency_interval()[1],
            mode.damping_interval()[0] <= truth.damping[place] <= mode.damping_interval()[1],
            bool(low[0] <= abs(truth.residue[0, place]) <= high[0]),
        ]
    return hits


def _draws(truth: Truth, axis: np.ndarray, seed: int, *, known: bool, count: int = REPEATS) -> list[Measured]:
    rng = np.random.default_rng(seed)
    value = truth.frf(axis)
    drawn = [noisy(value, 0.01, rng) for _ in range(count)]
    return [Measured(axis, v, "mobility", variance if known else None) for v, variance in drawn]


@pytest.mark.parametrize(
    ("weighting", "count", "most"),
    [("variance", REPEATS, 0.99), pytest.param("logarithmic", 3 * REPEATS, 0.995, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("known", [True, False], ids=["noise known", "noise unknown"])
@pytest.mark.slow
def test_least_squares(known: bool, weighting: str, count: int, most: float) -> None:
    truth = real_modes([20.0, 24.0, 40.0], [0.04, 0.03, 0.1], np.array([[1.0, 0.8 + 0.3j, 1.2]]))
    draws = _draws(truth, np.linspace(5, 60, 220), 5, known=known, count=count)
    peaks = choose_peaks(draws[0], at=list(truth.frequency))
    problems = [build_least_squares(d, peaks, residuals="real", weighting=weighting) for d in draws]
    found = solve_many(problems)
    share = np.mean([_hits(list(one.modes), truth) for one in found], axis=0)
    assert np.all((share >= 0.90) & (share <= most)), share


@pytest.mark.parametrize("known", [True, False], ids=["noise known", "noise unknown"])
@pytest.mark.parametrize("method", ["circle", "peaks"])
@pytest.mark.slow
def test_readings(one_mode: Truth, method: str, known: bool) -> None:
    hits = []
    for draw in _draws(one_mode, np.linspace(40, 65, 120), 6, known=known):
        found = estimate(draw, method, Choices(at=[51.0]))
        assert len(found) == 1
        hits.append(_hits(list(found), one_mode))
    share = np.mean(hits, axis=0)
    assert np.all((share >= 0.90) & (share <= 0.99)), share


@pytest.mark.slow
def test_refined_lscf() -> None:
    truth = real_modes([20.0, 40.0], [0.04, 0.05], np.array([[1.0, 1.2]]))
    hits = []
    for draw in _draws(truth, np.linspace(5, 60, 110), 7, known=True):
        found = estimate(draw, "lscf", Choices(highest_order=12))
        assert len(found) >= 2
        near = [min(found.modes, key=lambda mode: abs(mode.frequency - f)) for f in truth.frequency]
        hits.append(_hits(near, truth))
    share = np.mean(hits, axis=0)
    assert np.all((share >= 0.90) & (share <= 0.99)), share
