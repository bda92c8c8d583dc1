"""A campaign of blows to its modes: windows taken out, noise from coherence and repeats, estimators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import Blow, Campaign, CampaignPoint, CampaignPosture, Trial, Window
from flexmodal.ema import Choices, fit, mode_table, records_of
from flexmodal.ema.of_campaign import known_variance
from flexmodal.ema.records import by_posture
from flexmodal.errors import InvalidRequest

RATE, SAMPLES = 512, 1024
TIME = np.arange(SAMPLES) / RATE
FREQUENCY, DAMPING = np.array([14.0, 47.0]), np.array([0.01, 0.02])
SHAPE = np.array([[1.0, 0.6], [0.7, -1.0]])  # point by mode
CHOICES = Choices(at=list(FREQUENCY))


def responses(force: np.ndarray) -> np.ndarray:
    """Displacements of two points under a force at the first, by convolution with the impulse response."""
    omega = 2 * np.pi * FREQUENCY
    damped = omega * np.sqrt(1 - DAMPING**2)
    decay = (
        np.exp(-DAMPING[:, None] * omega[:, None] * TIME) * np.sin(damped[:, None] * TIME) / damped[:, None]
    )
    impulse = (SHAPE * SHAPE[0]) @ decay / RATE
    return np.array([np.convolve(force, one)[:SAMPLES] for one in impulse])


def campaign(trials: int, blows: int, noise: float, decay: float = 0.0, jump: float = 0.0) -> Campaign:
    """Blows of the same kind; `jump` scales the response from trial to trial, as a loose sensor does."""
    rng = np.random.default_rng(4)
    window = Window("exponential", decay) if decay else "none"
    made = []
    for trial in range(1, trials + 1):
        for number in range(1, blows + 1):
            force = np.zeros(SAMPLES)
            force[2:5] = rng.uniform(0.8, 1.2) * np.array([50.0, 100.0, 50.0])
            clean = responses(force) * (1 + jump * (trial - 1))
            spoilt = clean + noise * np.std(clean, axis=1, keepdims=True) * rng.normal(size=clean.shape)
            made.append(Blow(1, trial, number, (1, 3), TIME, force, ((1, 3), (2, 3)), spoilt, "displacement"))
    points = tuple(CampaignPoint(n, f"point {n}", "arm", (0.0, 0.0, 0.0)) for n in (1, 2))
    described = tuple(Trial(n, 100.0, blows, "soft", window=window) for n in range(1, trials + 1))
    return Campaign("blows", "none", (3.0, 90.0), (CampaignPosture(1, "as it is", {}),), points, described,
                    blows=tuple(made))  # fmt: skip


def test_the_damping_of_the_window_is_taken_out_and_the_picture_stays_that_of_the_measurement() -> None:
    """14 Hz damped by 1 % has decayed to a sixth after 2 s: it leaks, or its damping is the window's."""
    (found,) = fit(campaign(2, 3, 1e-3, decay=5.0), per="posture", choices=CHOICES)
    for mode, frequency, damping in zip(found.modes, FREQUENCY, DAMPING, strict=True):
        assert mode.frequency == pytest.approx(frequency, rel=1e-3)
        # The window adds 5/(2π·14) = 5.7 % to the first and 1.7 % to the second; what leaks is e⁻¹⁰ of it.
        assert mode.damping_ratio == pytest.approx(damping, abs=1e-3)
    assert found.modes.decay == 5.0
    assert found.modes.misfit < 0.02
    table = mode_table([found])
    assert len(table) == 4
    np.testing.assert_allclose(np.unique(table.natural_frequency), FREQUENCY, rtol=1e-3)


def test_windows_that_differ_cannot_be_averaged() -> None:
    mixed = campaign(2, 3, 1e-3, decay=5.0)
    trials = (mixed.trials[0], replace(mixed.trials[1], window="none"))
    with pytest.raises(InvalidRequest, match="separate"):
        fit(replace(mixed, trials=trials), choices=CHOICES)
    apart = fit(replace(mixed, trials=trials), trials="separate", choices=CHOICES)
    assert {one.modes.decay for one in apart} == {5.0, 0.0}


def test_noise_comes_from_coherence_and_repeats() -> None:
    alone, repeated = campaign(1, 6, 0.05, decay=5.0), campaign(2, 6, 0.05, decay=5.0)
    single, pair = (known_variance(records_of(one)) for one in (alone, repeated))
    assert single is not None
    assert pair is not None
    inside = slice(10, 150)
    # Both are estimates of one thing: 140 lines, smoothed over 19.
    assert np.median(single[:, inside]) == pytest.approx(np.median(pair[:, inside]), rel=0.5)
    assert known_variance(records_of(campaign(1, 1, 0.05, decay=5.0))) is None  # one blow says nothing


def test_trials_that_scatter_more_than_their_noise_raise_it() -> None:
    """A sensor that gains a tenth from one trial to the next: coherence and repeats of each know nothing."""
    steady, loose = (campaign(4, 4, 0.01, decay=5.0, jump=jump) for jump in (0.0, 0.1))
    spreads = []
    for one in (steady, loose):
        records = records_of(one)
        kinds = tuple(replace(trial, force_peak=100.0 + trial.id) for trial in one.trials)  # no repeats
        records = replace(records, trials=kinds)
        ((_, _, measured),) = by_posture(records, "average", known_variance(records))
        spreads.append(measured.within(10.0, 20.0).variance.mean())
    assert spreads[1] > 30 * spreads[0]


def test_each_estimator_finds_the_modes() -> None:
    for estimator in ("H1", "H2", "Hv"):
        (found,) = fit(campaign(1, 4, 1e-3, decay=5.0), per="posture", estimator=estimator, choices=CHOICES)
        np.testing.assert_allclose(found.modes.frequency, FREQUENCY, rtol=1e-3)
