"""Blows to FRFs: against closed forms, against pyFRF, and with the blows spoilt on purpose."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import Blow, Trial, Window, band_pass_blow, estimate_frfs, without_window
from flexmodal.errors import InvalidCampaign, InvalidRequest

RATE, SAMPLES = 1024, 2048
TIME = np.arange(SAMPLES) / RATE
LINES = np.fft.rfftfreq(SAMPLES, 1 / RATE)
POLE = -9.0 + 2j * np.pi * 40.0


def pulse(start: float = 0.02, width: float = 0.004, peak: float = 180.0) -> np.ndarray:
    inside = (start <= TIME) & (start + width >= TIME)
    return peak * np.where(inside, np.sin(np.pi * (TIME - start) / width), 0.0)


def response_of(force: np.ndarray) -> np.ndarray:
    """Convolution with the sampled impulse response Im exp(λt), nothing before the record."""
    impulse = np.exp(POLE * TIME).imag / RATE
    return np.convolve(force, impulse)[:SAMPLES]


def sampled_frf(shift: float = 0.0) -> np.ndarray:
    """Transfer function of that convolution, a geometric series, with the pole moved by −shift."""
    pole, z = POLE - shift, np.exp(-2j * np.pi * LINES / RATE)
    return (1 / (1 - np.exp(pole / RATE) * z) - 1 / (1 - np.exp(pole.conjugate() / RATE) * z)) / 2j / RATE


def blow(force: np.ndarray, response: np.ndarray, sequence: int = 1, **labels: object) -> Blow:
    fields = {"posture": 1, "trial": 1, "reference": (2, 3), "channels": ((1, 3),), **labels}
    return Blow(sequence=sequence, time=TIME, force=force, response=response[None], **fields)


def noisy_blows(count: int, on_force: float, on_response: float, seed: int = 0) -> list[Blow]:
    rng = np.random.default_rng(seed)
    force = [pulse(peak=rng.uniform(150, 200)) for _ in range(count)]
    return [
        blow(
            f + on_force * rng.normal(size=SAMPLES),
            response_of(f) + on_response * rng.normal(size=SAMPLES),
            number,
        )
        for number, f in enumerate(force, start=1)
    ]


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
def test_without_noise_the_closed_form_comes_out(estimator: str) -> None:
    # The decay has fallen to exp(-9 * 2 s) = 1.5e-8 at the end of the record: so much leaks.
    frfs = estimate_frfs([blow(pulse(), response_of(pulse()))], estimator=estimator)
    truth, inside = sampled_frf(), LINES < 200
    np.testing.assert_allclose(frfs.frequency, LINES)
    assert np.max(np.abs(frfs.value[0] - truth)[inside]) < 1e-6 * np.abs(truth).max()
    assert frfs.form == "inertance"
    np.testing.assert_allclose(frfs.coherence[0], 1.0)


def test_h1_withstands_noise_in_the_response_and_h2_noise_in_the_force() -> None:
    # 150 blows: random error of the mean of |H| over 100 lines is far below the 3 % asked for.
    truth, band = np.abs(sampled_frf()), (LINES > 60) & (LINES < 120)

    def bias(estimator: str, on_force: float, on_response: float) -> float:
        blows = noisy_blows(150, on_force, on_response)
        return float(np.mean(np.abs(estimate_frfs(blows, estimator=estimator).value[0])[band] / truth[band]))

    assert bias("H1", 0.0, 2e-2) == pytest.approx(1, abs=0.03)
    assert bias("H2", 0.0, 2e-2) > 1.2
    assert bias("H2", 3.0, 0.0) == pytest.approx(1, abs=0.03)
    assert bias("H1", 3.0, 0.0) < 0.95


def test_hv_is_the_geometric_mean_and_coherence_their_ratio() -> None:
    blows = noisy_blows(5, 1.0, 1e-3)
    h1, h2, hv = (estimate_frfs(blows, estimator=name) for name in ("H1", "H2", "Hv"))
    np.testing.assert_allclose(np.abs(hv.value) ** 2, np.abs(h1.value * h2.value), rtol=1e-12)
    np.testing.assert_allclose(h1.coherence, np.abs(h1.value / h2.value), rtol=1e-9)
    assert np.all(h1.coherence <= 1)


def test_pyfrf_gives_the_same() -> None:
    from pyFRF import FRF

    blows = noisy_blows(4, 1.0, 1e-3)
    force, response = np.array([b.force for b in blows]), np.array([b.response[0] for b in blows])
    theirs = FRF(
        sampling_freq=RATE,
        exc_type="f",
        resp_type="d",
        window="none",
        fft_len=SAMPLES,
        weighting="linear",
    )
    for one, other in zip(force, response, strict=True):
        theirs.add_data(one, other)
    for name in ("H1", "H2"):
        ours = estimate_frfs(blows, estimator=name)
        wanted = np.ravel(getattr(theirs, f"get_{name}")())
        # Both are quotients of the same averaged spectra; only rounding differs.
        np.testing.assert_allclose(ours.value[0][1:-1], wanted[1:-1], rtol=1e-8, err_msg=name)
    np.testing.assert_allclose(ours.coherence[0][1:-1], np.ravel(theirs.get_coherence())[1:-1], rtol=1e-8)


def test_the_exponential_window_moves_the_pole_and_can_be_taken_out() -> None:
    decay = 12.0
    trial = Trial(1, 180.0, 1, "hard", window=Window("exponential", decay))
    frfs = estimate_frfs([blow(pulse(), response_of(pulse()))], trials=[trial])
    truth = sampled_frf(decay)
    assert np.max(np.abs(frfs.value[0] - truth)[LINES < 200]) < 1e-8 * np.abs(truth).max()
    moved = POLE - decay
    ratio, frequency = -moved.real / abs(moved), abs(moved) / (2 * np.pi)
    back = without_window(frequency, ratio, decay)
    assert back[0] == pytest.approx(abs(POLE) / (2 * np.pi), rel=1e-12)
    assert back[1] == pytest.approx(-POLE.real / abs(POLE), rel=1e-12)


def test_the_force_window_keeps_noise_after_the_pulse_out() -> None:
    truth, band = sampled_frf(), (LINES > 20) & (LINES < 120)

    def error(trial: Trial) -> float:
        frfs = estimate_frfs(noisy_blows(8, 2.0, 0.0), trials=[trial])
        return float(np.median(np.abs(frfs.value[0] / truth - 1)[band]))

    plain = Trial(1, 180.0, 8, "hard")
    # The noise of 2048 samples becomes that of the pulse's few and of some 20 more while it fades.
    assert error(replace(plain, window=Window("force", 100.0))) < error(plain) / 4


def test_trials_say_how_many_blows_were_averaged() -> None:
    frfs = estimate_frfs(noisy_blows(3, 0, 1e-3), trials=[Trial(1, 180.0, 9, "hard")])
    assert [trial.averages for trial in frfs.trials] == [3]


def test_faults_are_named() -> None:
    good = blow(pulse(), response_of(pulse()))
    second = 0.6 * pulse(start=0.05)
    clipped = np.minimum(pulse(width=0.008), 60.0)
    soft = pulse(width=0.04)
    blows = [
        good,
        blow(pulse() + second, response_of(pulse() + second), 2),
        blow(clipped, response_of(clipped), 3),
        blow(soft, response_of(soft), 4),
    ]
    frfs = estimate_frfs(blows, band=(5.0, 150.0))
    found = {(flag.blow, flag.kind) for flag in frfs.flags}
    assert {(2, "double hit"), (3, "overload"), (4, "low energy in band")} <= found
    assert all(number != 1 for number, _ in found)
    hit = next(flag for flag in frfs.flags if flag.kind == "double hit")
    assert (
        str(hit) == "posture 1, trial 1, blow 2, point 2 direction +3: double hit: 2 pulses, at 22.5, 51.8 ms"
    )


def test_a_force_that_goes_on_is_no_double_hit_and_a_hammer_that_bounces_often_is() -> None:
    sweep = 100.0 * np.sin(2 * np.pi * (5 + 40 * TIME) * TIME)
    bounces = sum(part * pulse(start=0.02 + 0.03 * k) for k, part in enumerate((1.0, 0.7, 0.5, 0.3, 0.2)))
    offset = pulse() + 0.6 * pulse(start=0.05) + 40.0  # a charge amplifier that was not zeroed
    found = {}
    for number, force in enumerate((sweep, bounces, offset), start=1):
        flags = estimate_frfs([blow(force, response_of(force))], band=(5.0, 150.0)).flags
        found[number] = [flag.says for flag in flags if flag.kind == "double hit"]
    assert found[1] == []
    assert "5 pulses" in found[2][0]
    assert "2 pulses" in found[3][0]


def test_low_coherence_is_named_with_its_point() -> None:
    frfs = estimate_frfs(noisy_blows(6, 0.0, 1.0), band=(5.0, 150.0))
    assert [(flag.kind, flag.point, flag.blow) for flag in frfs.flags if flag.kind == "low coherence"] == [
        ("low coherence", (1, 3), None)
    ]


def test_a_line_without_force_is_zero_with_coherence_zero() -> None:
    force = np.zeros(SAMPLES)
    force[::2] = 1.0  # power at 0 Hz and at half the sampling rate, and nowhere else
    rng = np.random.default_rng(0)
    frfs = estimate_frfs([blow(force, rng.normal(size=SAMPLES))])
    assert np.all(frfs.value[0, 1:-1] == 0)
    assert np.all(frfs.coherence[0, 1:-1] == 0)
    assert frfs.value[0, 0] != 0


@pytest.mark.parametrize(
    ("spoilt", "says"),
    [
        (lambda b: replace(b, force=0 * b.force), "zero throughout"),
        (lambda b: replace(b, force=b.force * np.nan), "not finite"),
        (lambda b: replace(b, time=2 * b.time, sequence=2), "samples every"),
    ],
)
def test_bad_blows_are_refused(spoilt: object, says: str) -> None:
    good = blow(pulse(), response_of(pulse()))
    with pytest.raises(InvalidCampaign, match=says):
        estimate_frfs([good, spoilt(good)])


def test_no_blows_and_unknown_estimators_are_refused() -> None:
    with pytest.raises(InvalidCampaign, match="none"):
        estimate_frfs([])
    with pytest.raises(InvalidRequest, match="H3"):
        estimate_frfs([blow(pulse(), pulse())], estimator="H3")


def test_blows_with_and_without_a_channel_and_mixed_quantities() -> None:
    good = blow(pulse(), response_of(pulse()))
    velocity = replace(good, quantity="velocity", channels=((3, 1),))
    frfs = estimate_frfs([good, replace(good, sequence=2, channels=((4, 1),)), velocity])
    assert frfs.response.tolist() == [[1, 3], [4, 1], [3, 1]]
    assert frfs.form == "inertance"
    np.testing.assert_allclose(frfs.value[2], frfs.value[0] * 2j * np.pi * LINES)


def test_band_pass_keeps_phase_and_takes_out_the_rest() -> None:
    slow, fast = np.sin(2 * np.pi * 3 * TIME), np.sin(2 * np.pi * 40 * TIME)
    passed = band_pass_blow(blow(pulse(), slow + fast), 20.0, 100.0).response[0]
    middle = slice(SAMPLES // 4, 3 * SAMPLES // 4)
    # Butterworth of order 4 run twice: 1 - 1e-3 at 40 Hz in 20 to 100 Hz, (3/20)^8 at 3 Hz.
    assert np.max(np.abs(passed - fast)[middle]) < 5e-3
    with pytest.raises(InvalidRequest, match="half the sampling rate"):
        band_pass_blow(blow(pulse(), slow), 20.0, 600.0)


def test_band_pass_is_off_by_default_and_leaves_the_ratio_alone() -> None:
    late = pulse(start=0.7)
    blows = [blow(late, response_of(late))]
    plain, passed = estimate_frfs(blows), estimate_frfs(blows, band_pass=(5.0, 200.0))
    inside = (LINES > 10) & (LINES < 100)
    assert not np.array_equal(plain.value, passed.value)
    # What the filter does at the ends of the record is the rest.
    assert np.max(np.abs(passed.value / plain.value - 1)[0, inside]) < 0.02
