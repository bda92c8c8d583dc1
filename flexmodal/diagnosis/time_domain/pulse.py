"""The hammer's pulse in each kind of blow: as recorded, or what is usual for its tip.

The pulse is a haversine, f(t) = P/2 (1 − cos(2πt/T)). Where a campaign has the blows themselves, P and T are
those whose spectrum comes nearest to the recorded ones' mean size. Otherwise T is usual for tip and peak, see
`campaign.pulse_length`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import pulse_length
from flexmodal.identification import Observations

_STRONG = 0.1
"""Part of the largest size of a force's spectrum from which a line tells of the pulse."""
_LENGTHS = (5e-5, 5e-2)
"""Shortest and longest pulse that is looked for [s]."""


@dataclass(frozen=True)
class Pulse:
    """A blow."""

    peak: float
    """[N]"""
    length: float
    """[s]"""

    def force(self, time: Float[np.ndarray, " time"]) -> Float[np.ndarray, " time"]:
        """At times since the contact [N]."""
        inside = (time > 0) & (time < self.length)
        return np.where(inside, self.peak / 2 * (1 - np.cos(2 * np.pi * time / self.length)), 0.0)


def pulses(observations: Observations) -> tuple[Pulse, ...]:
    """The pulse of each kind of blow (`observations.levels`)."""
    return tuple(_pulse(observations, level) for level in range(len(observations.levels)))


def haversine(frequency: Float[np.ndarray, " line"], length: float) -> Complex[np.ndarray, " line"]:
    """Spectrum of a pulse of unit peak [s].

    Args:
        frequency: of the lines [Hz].
        length: of the pulse [s].
    """
    x = frequency * length
    with np.errstate(divide="ignore", invalid="ignore"):
        size = length / 2 * np.sinc(x) / (1 - x**2)
    return np.where(np.abs(x - 1) < 1e-6, length / 4, size) * np.exp(-1j * np.pi * x)


def usual(tip: str, peak: float) -> Pulse:
    """What a hammer does by its tip and the peak of the blow [N].

    Args:
        tip: soft, medium or hard; another counts as medium.
        peak: of the force [N].
    """
    return Pulse(peak, pulse_length(tip, peak))


def _pulse(observations: Observations, level: int) -> Pulse:
    campaign, trials = observations.campaign, observations.levels[level]
    blows = [blow for blow in campaign.blows if blow.trial in trials]
    if not blows:
        return usual(campaign.trial(trials[0]).tip, observations.peak(level))
    step = blows[0].step
    spectrum = np.mean([np.abs(np.fft.rfft(blow.force)) for blow in blows], axis=0) * step
    frequency = np.fft.rfftfreq(len(blows[0].force), step)
    return _nearest(frequency, spectrum, campaign.band)


def _nearest(
    frequency: Float[np.ndarray, " line"], size: Float[np.ndarray, " line"], band: tuple[float, float]
) -> Pulse:
    """The haversine nearest to a measured spectrum, on a logarithmic scale, in a band."""
    from scipy.optimize import minimize_scalar

    inside = (frequency >= band[0]) & (frequency <= band[1])
    strong = inside & (size >= _STRONG * size[inside].max())
    f, log = frequency[strong], np.log(size[strong])

    def off(log_length: float) -> float:
        shape = np.abs(haversine(f, float(np.exp(log_length))))
        return float(np.var(log - np.log(np.maximum(shape, 1e-30))))

    shortest, longest = np.log(_LENGTHS)
    tried = np.linspace(shortest, longest, 60)
    best = int(np.argmin([off(one) for one in tried]))
    around = tried[[max(best - 1, 0), min(best + 1, len(tried) - 1)]]
    length = float(np.exp(minimize_scalar(off, bounds=tuple(around), method="bounded").x))
    return Pulse(float(np.exp(np.mean(log - np.log(np.abs(haversine(f, length)))))), length)
