"""Whether records end while something still rings, told by the FRFs alone."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.identification import observe
from flexmodal.identification.ringing import ASIDE, _over_noise, rings_on
from flexmodal.rig import Hide, simulate


@pytest.fixture(scope="module")
def seen():
    """Observations of an arm as it is, and with a drive that takes a mode's damping away in one posture."""

    def made(*hide):
        result = simulate(
            flexmodal.load("fanuc_s360"), postures=["configuration_1", "configuration_7"], points=3, trials=2,
            averages=3, seed=4, record_length=4.0, band=(2.0, 200.0), hide=hide,
        )  # fmt: skip
        return observe(result.campaign)

    return made(), made(Hide("joint_coupling", "q1+q2", form="remote", parameters={"ratio": -0.135}))


def test_what_rings_on_is_seen_in_the_frfs(seen):
    still, ringing = seen
    assert not rings_on(still)
    assert rings_on(ringing)


def test_it_is_seen_where_it_rings_and_as_far_above_the_noise_as_it_is():
    """Against the closed form: a mode's response at the end of a record, seen through a Hann window."""
    length, apart = 4.0, 0.25
    frequency = np.arange(4.0, 104.0, apart)
    pole = 2j * np.pi * 50.0 - 0.3
    # a blow's record that is cut at its end: ∫₀ᵀ e^{(p − s)t} dt
    value = np.expm1((pole - 2j * np.pi * frequency) * length)[None] / (pole - 2j * np.pi * frequency)
    over = _over_noise(frequency, length, value, np.ones((1, len(frequency))))[0]
    off = ASIDE / (0.18 * length)
    near = np.arange(frequency[0] + off, frequency[-1] - off, 1 / (0.18 * length))
    assert abs(near[np.argmax(over)] - 50.0) < 1 / (0.18 * length)
    # Parseval's sum over the lines is 1/Δf times the response there, that of the noise 1/Δf ∫ W² df
    size = np.abs(np.exp(pole * (0.75 + 0.93) / 2 * length)) / apart
    x = np.arange(-4000, 4001) / 1000
    window = np.where(np.abs(np.abs(x) - 1) < 1e-9, 0.5, np.sinc(x) / np.where(np.abs(x) == 1, 1.0, 1 - x**2))
    noise = np.sum(window**2) * 1e-3 / (0.18 * length) / apart
    part = np.interp(50.0 - near[np.argmax(over)], x / (0.18 * length), window)
    assert over.max() == pytest.approx((size * part) ** 2 / noise, rel=0.1)


@pytest.mark.parametrize("lines", [slice(None, 2), [0, 1, 2, 5, 7, 8, 12, 20]])
def test_lines_that_cannot_tell_say_no(seen, lines):
    """Too few of them, or unevenly apart."""
    _, ringing = seen
    keep = np.arange(len(ringing.axis.frequency))[lines]
    records = replace(
        ringing.records, frequency=ringing.records.frequency[keep], value=ringing.records.value[:, keep],
        coherence=None,
    )  # fmt: skip
    few = replace(
        ringing, records=records, value=ringing.value[:, keep], variance=ringing.variance[:, keep],
        used=ringing.used[:, keep], noise=ringing.noise[:, keep],
    )  # fmt: skip
    assert not rings_on(few)
    assert not rings_on(replace(ringing, lengths=(0.0,) * len(ringing.lengths)))
