"""What neighbouring lines share of a misfit: none of noise, all of a smooth error, none of a blow's own."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.identification import build_identification, observe, solve_identification
from flexmodal.identification.doubt import COHERENCE, LINES, REPEATS, jackknife, limits
from flexmodal.identification.outcome import EXPLAINED
from flexmodal.identification.shared import shared_misfit
from flexmodal.rig import Hide, simulate


def trials_of(fanuc, count):
    """FRFs of one posture; trials that repeat each other."""
    made = simulate(fanuc, postures=1, points=3, trials=count, references=2, seed=5, time=False, scatter=0.0)
    trials = tuple(replace(one, repeat_of=1 if one.id > 1 else None) for one in made.campaign.trials)
    records = replace(made.campaign.frfs, trials=trials)
    return observe(replace(made.campaign, trials=trials, frfs=records, blows=()))


@pytest.fixture(scope="module")
def pair(fanuc):
    """Two trials that repeat each other; variances of the mean are 1e-4, every line is used."""
    seen = trials_of(fanuc, 2)
    every = np.ones(seen.used.shape, bool)
    return replace(seen, used=every, variance=np.full(seen.used.shape, 1e-4), value=np.exp(seen.value * 0))


def with_records(seen, first, second):
    """The observations as the means of two records each, ln of which is given in standard deviations."""
    values = np.empty(seen.records.value.shape, complex)
    for row in range(len(seen)):
        one, other = np.flatnonzero(seen.of_record == row)
        values[one], values[other] = 1 + 0.01 * first[row], 1 + 0.01 * second[row]
    mean = np.array([values[seen.of_record == row].mean(axis=0) for row in range(len(seen))])
    return replace(seen, value=mean, records=replace(seen.records, value=values))


def noise(random, shape):
    """Circular, of variance 2: that of a mean of two is 1."""
    return random.normal(size=shape) + 1j * random.normal(size=shape)


def test_noise_shares_nothing_and_a_smooth_error_all_of_its_square(pair):
    random, shape = np.random.default_rng(2), pair.value.shape
    seen = with_records(pair, noise(random, shape), noise(random, shape))
    assert abs(shared_misfit(seen, np.ones(shape, complex))) < 0.05  # 800 lines: ± 1/√800 each, a median of 6
    for size in (0.5, 1.0):
        wave = size * np.exp(2j * np.pi * np.arange(shape[1]) / 200)
        found = shared_misfit(seen, np.exp(0.01 * wave)[None] * np.ones(shape))
        assert found == pytest.approx(size**2, abs=0.08)


def test_what_one_blow_has_by_itself_is_no_error_of_the_model(pair):
    """One of two trials 2 % too large: the mean is off by a standard deviation, so is their difference."""
    random, shape = np.random.default_rng(3), pair.value.shape
    seen = with_records(pair, noise(random, shape) + 2.0, noise(random, shape))
    model = np.ones(shape, complex)
    assert abs(shared_misfit(seen, model)) < 0.1
    first = np.array([np.flatnonzero(seen.of_record == row)[0] for row in range(len(seen))])
    records = seen.records.take(first)  # were there no second trial to say so
    alone = replace(seen, records=records, of_record=np.arange(len(seen)), noise=seen.noise[first])
    assert shared_misfit(alone, model) == pytest.approx(1.0, abs=0.15)


def test_a_window_makes_noise_share_what_the_formula_says(fanuc):
    """White noise of records of 4 s under exp(−σt), its lines by FFT; none of it is the model's."""
    single = trials_of(fanuc, 1)
    random, lines = np.random.default_rng(4), single.value.shape[1]
    length, decay = 4.0, 2.0
    window = np.exp(-decay * np.linspace(0, length, 4 * lines, endpoint=False))
    spectra = np.fft.fft(random.normal(size=(len(single), 4 * lines)) * window)[:, 1 : lines + 1]
    z = spectra / np.sqrt(np.mean(np.abs(spectra) ** 2))
    bare = replace(
        single,
        records=replace(single.records, frequency=np.arange(1, lines + 1) / length),
        value=np.exp(-0.01 * z),
        variance=np.full(z.shape, 1e-4),
        used=np.ones(z.shape, bool),
        lengths=(length,) * len(single.levels),
    )
    model = np.ones(bare.value.shape, complex)
    a = 2 * decay * length
    assert shared_misfit(bare, model) == pytest.approx(a**2 / (a**2 + 4 * np.pi**2), abs=0.1)
    assert abs(shared_misfit(replace(bare, decays=(decay,) * len(bare.levels)), model)) < 0.1


def test_too_few_lines_say_nothing(pair):
    assert np.isnan(shared_misfit(replace(pair, used=np.zeros_like(pair.used)), pair.value))


@pytest.fixture(scope="module")
def campaigns(fanuc):
    """A robot that is as its card says but for its numbers, and one with a soft link besides."""
    return {
        height: simulate(
            fanuc,
            postures=["configuration_1", "configuration_3", "configuration_5"],
            points=3,
            trials=2,
            hide=[Hide("link_flexibility", height=height)] if height else [],
            seed=31,
            time=False,
        )
        for height in (0.0, 3.0)
    }


def test_a_soft_link_that_looks_like_soft_joints_leaves_no_interval(campaigns):
    """It meets the data to within the noise, and its stiffnesses are not those of the joints."""
    made = campaigns[3.0]
    outcome = solve_identification(build_identification(made.campaign, made.robot), in_turn=False)
    assert outcome.over_noise < EXPLAINED
    assert outcome.shared_misfit > COHERENCE.withheld
    assert outcome.withheld
    assert "goes on from line to line as noise does not" in outcome.verdict
    assert all(np.isnan(one.standard_error) for one in outcome.estimates)
    low, high = outcome.uncertainty.interval(outcome.at)  # as they would have been given
    truth = np.array([np.log(made.truth.factors[name]) for name in outcome.problem.space.names])
    assert np.mean((low <= truth) & (truth <= high)) < 0.8


def test_a_complete_model_has_its_intervals(campaigns):
    made = campaigns[0.0]
    outcome = solve_identification(build_identification(made.campaign, made.robot), in_turn=False)
    assert abs(outcome.shared_misfit) < COHERENCE.doubted
    assert not outcome.withheld
    assert any(np.isfinite(one.standard_error) for one in outcome.estimates)


def test_a_silent_record_still_tells_the_noise_of_its_repeat(fanuc):
    """One record of a pair that is nothing but noise does not make the campaign one without repeats."""
    made = simulate(fanuc, postures=2, points=2, trials=2, references=1, seed=6, time=False)
    trials = tuple(replace(one, repeat_of=1 if one.id == 2 else None) for one in made.campaign.trials)
    frfs = replace(made.campaign.frfs, trials=trials, coherence=None)
    value = frfs.value.copy()
    value[0] = 1e-3 * np.abs(value[0]).mean() * noise(np.random.default_rng(1), value.shape[1:])
    spoilt = replace(made.campaign, trials=trials, frfs=replace(frfs, value=value), blows=())
    seen = observe(spoilt, bare=True)
    assert len(seen.silent) == 1
    assert not seen.by_lines


def test_what_is_shared_a_little_widens_the_intervals_by_left_out_postures(campaigns):
    """The jackknife by hand, and a verdict that says so; where nothing was left out none are given."""
    made = campaigns[0.0]
    outcome = solve_identification(build_identification(made.campaign, made.robot))
    assert not outcome.doubted
    middle = (COHERENCE.doubted + COHERENCE.withheld) / 2
    doubted = replace(outcome, shared_misfit=middle)
    assert doubted.doubted
    assert "where a posture is left out" in doubted.verdict
    away = outcome.without - outcome.at
    error = np.sqrt(2 / 3 * np.sum(away**2, axis=0))
    t = 4.302652729749464  # of two degrees of freedom
    for k, (plain, wide) in enumerate(zip(outcome.estimates, doubted.estimates, strict=True)):
        if plain.at_bound:
            continue
        low, high = np.log(np.array(wide.interval) / wide.card)
        assert low == pytest.approx(min(np.log(plain.interval[0] / plain.card), outcome.at[k] - t * error[k]))
        assert high == pytest.approx(
            max(np.log(plain.interval[1] / plain.card), outcome.at[k] + t * error[k])
        )
    assert replace(doubted, without=None).withheld


def test_the_jackknife_of_a_mean_is_its_standard_error():
    """Means without each of n numbers: the scatter over √n, exactly."""
    random = np.random.default_rng(3)
    values = random.normal(size=(6, 2))
    whole = values.mean(axis=0)
    without = np.array([np.delete(values, k, axis=0).mean(axis=0) for k in range(6)])
    error, t = jackknife(whole, without)
    np.testing.assert_allclose(error, values.std(axis=0, ddof=1) / np.sqrt(6))
    assert t == pytest.approx(2.570582, rel=1e-6)


def test_limits_go_by_what_tells_the_noise(fanuc):
    made = simulate(
        fanuc, postures=2, points=2, references=1, trials=4, band=(2.0, 60.0), record_length=2.0, seed=1,
        time=False,
    )  # fmt: skip
    repeated = build_identification(made.campaign, made.robot).evidence
    single = replace(made.campaign, frfs=made.campaign.frfs.select(trial=made.campaign.trials[0].id))
    alone = build_identification(single, made.robot).evidence
    assert limits(repeated, bare=False) == REPEATS
    assert limits(alone, bare=False) == COHERENCE
    assert limits(alone, bare=True) == LINES
