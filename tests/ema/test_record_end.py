"""What the end of a record makes of modes: by the rest of the motion, and on records that are cut short."""

import numpy as np
from scipy.integrate import quad

from flexmodal.campaign import FrfRecords, Trial
from flexmodal.ema import fit
from flexmodal.ema.estimate import estimate
from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.record_end import SAYS, missing, with_record_end

POLES = (-1.05 + 2j * np.pi * 8.3, -2.5 + 2j * np.pi * 31.0)
RESIDUES = tuple(-1e-5j * np.random.default_rng(1).uniform(0.2, 1.0, (2, 24)))
LENGTH, BEFORE = 4.0, 0.04
"""Of the record, and the part of it before the blow [s]."""


def pairs():
    for pole, residue in zip(POLES, RESIDUES, strict=True):
        yield pole, residue
        yield np.conj(pole), residue.conj()


def cut_short(frequency, after, power=2):
    """The FRF of a motion that is watched for a time: Σ A λᵏ (1 − e^{(λ − s)T})/(s − λ), and for
    acceleration what the blow itself makes, Σ A λ."""
    s = 2j * np.pi * frequency[:, None]
    value = sum(a * p**power * (1 - np.exp((p - s) * after)) / (s - p) for p, a in pairs())
    return value + sum(a * p for p, a in pairs()) if power == 2 else value


def test_what_is_missing_is_the_rest_of_the_motion():
    """∫ from T on of the acceleration times e^(−st), taken numerically."""
    frequency = np.arange(2.0, 60.0, 0.25)
    found = estimate(Measured(frequency, cut_short(frequency, 50.0), "inertance"))
    assert len(found) == 2
    after = 1.7
    rest = missing(found, after)[0]
    for line in (10, 26, 90):
        s = 2j * np.pi * frequency[line]
        for frf in range(2):

            def moving(t, part, s=s, frf=frf):
                motion = sum(
                    (a[frf] * p**2 * np.exp(p * t)).real for p, a in zip(POLES, RESIDUES, strict=True)
                )
                return getattr(2 * motion * np.exp(-s * t), part)

            parts = [
                quad(moving, after, after + 15, args=(part,), limit=2000)[0] for part in ("real", "imag")
            ]
            expected = parts[0] + 1j * parts[1]
            np.testing.assert_allclose(rest[line, frf], expected, rtol=2e-3, atol=1e-6 * abs(expected))


def test_intervals_hold_the_truth_of_records_that_end_early():
    frequency = np.arange(8, 801) / LENGTH
    value = cut_short(frequency, LENGTH - BEFORE)
    random = np.random.default_rng(3)
    noise = 0.01 * np.abs(value)
    noisy = value + noise * (
        random.normal(size=value.shape) + 1j * random.normal(size=value.shape)
    ) / np.sqrt(2)
    found = estimate(Measured(frequency, noisy, "inertance", noise**2))
    wider = with_record_end(found, LENGTH)
    truth = [abs(pole) / (2 * np.pi) for pole in POLES]

    def misses(modes):
        return [
            abs(mode.frequency - true) / (mode.frequency_interval()[1] - mode.frequency)
            for mode, true in zip(modes, truth, strict=True)
        ]

    assert max(misses(found)) > 1.2  # 1.6 % of the motion is missing, and the noise does not know
    assert max(misses(wider)) < 1
    assert SAYS in wider.modes[0].remarks
    assert [mode.frequency for mode in wider] == [mode.frequency for mode in found]


def test_long_records_change_nothing():
    frequency = np.arange(1, 321) / LENGTH
    found = estimate(Measured(frequency, cut_short(frequency, LENGTH), "inertance"))
    assert with_record_end(found, 40.0) is found
    assert with_record_end(found, None) is found


def test_fit_takes_the_length_from_the_trials():
    frequency = np.arange(1, 321) / LENGTH
    value = cut_short(frequency, LENGTH - BEFORE)[:, :2].T
    trials = (Trial(1, 100.0, 3, "soft", record_length=LENGTH),)
    records = FrfRecords(
        frequency, value, None, np.array([1, 1]), np.array([1, 1]), np.array([[1, 3], [2, 3]]),
        np.array([[1, 3], [1, 3]]), "inertance", trials,
    )  # fmt: skip
    for per in ("posture", "frf"):
        stated = fit(records, per=per)
        silent = fit(FrfRecords(**{**vars(records), "trials": ()}), per=per)
        for one, other in zip(stated, silent, strict=True):
            assert one.modes.modes[0].frequency_error > other.modes.modes[0].frequency_error
