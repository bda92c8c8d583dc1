"""Data that nobody would measure on purpose: an answer or one clear sentence, never a warning or a crash."""

from __future__ import annotations

import json

import numpy as np
import pytest

from flexmodal.campaign import FrfRecords, noise_floor
from flexmodal.ema import Choices, Measured, as_json, estimate, fit
from flexmodal.errors import FlexmodalError, InvalidRequest

from .truth import Truth, measured

AXIS = np.linspace(0, 80, 161)


def records(value: np.ndarray) -> FrfRecords:
    count = len(value)
    ones, three = np.ones(count, dtype=int), np.full(count, 3)
    response = np.stack([np.arange(1, count + 1), three], axis=1)
    return FrfRecords(AXIS, value, None, ones, ones, response, np.stack([ones, three], axis=1), "inertance")


def odd_values(seed: int) -> np.ndarray:
    """Three FRFs: flat, noise, a single line, zeros, tiny noise, huge or tiny throughout, by the seed."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(3, len(AXIS))) + 1j * rng.normal(size=(3, len(AXIS)))
    line = np.zeros((3, len(AXIS)), dtype=complex)
    line[:, 40] = 1.0
    s = 2j * np.pi * AXIS
    mode = (s**2 / ((2 * np.pi * 30) ** 2 + s**2 + 0.04 * 2 * np.pi * 30 * s))[None] * np.ones((3, 1))
    silent = mode.copy()
    silent[1] = 1e-3 * noise[1]
    kinds = (np.ones_like(line), noise, line, 0 * line, mode + 1e-13 * noise, 1e200 * mode, 1e-200 * mode,
             silent, mode * np.sign(rng.normal(size=len(AXIS))))  # fmt: skip
    return kinds[seed % len(kinds)]


@pytest.mark.some(3)
@pytest.mark.parametrize("method", ["peaks", "circle", "least-squares", "lscf"])
@pytest.mark.parametrize(
    "seed", [0, 2, 3, 4, 5, 6, 8, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 7))]
)
def test_odd_frfs_give_an_answer_or_a_sentence(seed: int, method: str) -> None:
    for per in ("frf", "posture"):
        for at in (None, [30.0]):
            try:
                found = fit(records(odd_values(seed)), method, per=per, choices=Choices(at=at))
            except FlexmodalError:  # one sentence, and none of Python's or numpy's
                continue
            json.dumps(as_json(found), allow_nan=False)


@pytest.mark.parametrize("size", [1e200, 1e-200])
def test_sizes_that_cannot_be_squared_are_refused(size: float) -> None:
    mode = odd_values(4)
    with pytest.raises(InvalidRequest, match="1e"):
        fit(records(size * mode))
    with pytest.raises(InvalidRequest):
        noise_floor(records(size * mode), (2.0, 80.0))


def test_a_circle_beside_frfs_of_noise_keeps_their_residues(four_modes: Truth) -> None:
    data = measured(four_modes, np.linspace(2, 120, 400), level=0.005)
    rng = np.random.default_rng(1)
    noise = 1e-6 * (rng.normal(size=(400, 1)) + 1j * rng.normal(size=(400, 1)))
    both = Measured(data.frequency, np.concatenate([data.value[:, :1], noise], axis=1), "mobility")
    found = estimate(both, "circle", Choices(at=[8.0, 94.0]))
    assert len(found) == 2
    for mode in found:
        assert np.all(np.isfinite(mode.residue_error))
        assert abs(mode.residue[1]) < 1e-2 * abs(mode.residue[0])
