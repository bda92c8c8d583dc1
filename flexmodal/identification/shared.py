"""Misfit that neighbouring lines share, as a model's error does and noise does not.

A model that lacks something and makes up for it by its parameters may come within the noise: a soft link
looks like soft joints. What it cannot make up for then lies under the noise, and goes on from line to line
with the same sign, where the noise of one line knows nothing of the next. With z = ln(model / measured) in
standard deviations of its noise,

    s = Re z_k z̄_{k+1},  averaged over the lines of an observation,

is 0 for noise and the mean square of the model's error for an error that is smooth. Blows share theirs too: a
hammer that falls a little beside its point in one of two trials moves all lines together. What trials that
repeat each other do not share is no error of the model, so that the same product of their differences is
taken off. Large z count as `HUBER`, and the median over observations is taken: one blow that went wrong is no
error of the model.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.identification.descent import HUBER
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.observations import Observations

FEWEST = 20
"""Pairs of lines from which an observation says anything."""

LEAST = 0.02
"""Autocorrelation from which neighbours count as independent."""


def independence(weighted: Complex[np.ndarray, "observation line"], furthest: int) -> float:
    """κ = 1/(1 + 2Σρ): part of the lines that count, by the autocorrelation ρ of residuals.

    Args:
        weighted: residuals in standard deviations.
        furthest: lag at which the sum ends at the latest [line].
    """
    power = float(np.sum(np.abs(weighted) ** 2))
    total = 1.0
    for lag in range(1, min(furthest, weighted.shape[1] - 1)):
        rho = float(np.sum((weighted[:, lag:] * np.conj(weighted[:, :-lag])).real)) / max(power, 1e-300)
        if rho < LEAST:
            break
        total += 2 * rho
    return 1 / total


def shared_misfit(observations: Observations, predicted: Complex[np.ndarray, "observation line"]) -> float:
    """Median of s over the observations, in variances of the noise; NaN where none has enough lines.

    Args:
        observations: what was measured.
        predicted: receptances by the model [m/N].
    """
    found = []
    for row in range(len(observations)):
        lag = _lag(observations, int(observations.level[row]))
        used = observations.used[row]
        pairs = used[lag:] & used[:-lag]
        if pairs.sum() < FEWEST:
            continue
        size = np.sqrt(np.where(used, observations.variance[row], 1.0))
        away = np.where(used, residual(predicted[row], observations.value[row]) / size, 0.0)
        found.append(_product(away, pairs, lag) - _by_blows(observations, row, size, pairs, lag))
    return float(np.median(found)) if found else float("nan")


def _by_blows(
    observations: Observations,
    row: int,
    size: Float[np.ndarray, " line"],
    pairs: Bool[np.ndarray, " pair"],
    lag: int,
) -> float:
    """What s is of errors that belong to single trials, or were said to be there, and not to the model."""
    records = np.flatnonzero(observations.of_record == row)
    count = len(records)
    if not observations.campaign.tolerance.is_exact:
        noise = observations.noise[records].sum(axis=0) / count**2
        share = np.clip(1 - noise / size**2, 0.0, 1.0)
        return float(share[:-lag][pairs].mean())
    if count < 2:
        return _window(observations, int(observations.level[row]), lag)
    used = observations.used[row]
    mean = np.where(used, observations.value[row], 1.0)
    values = observations.records.value[records]
    apart = np.where(used, values / mean - 1, 0.0) / (size * math.sqrt(count * (count - 1)))
    return sum(_product(one, pairs, lag) for one in apart)


def _product(away: Complex[np.ndarray, " line"], pairs: Bool[np.ndarray, " pair"], lag: int) -> float:
    """Mean of Re z_k z̄_{k+lag} over pairs of lines, z no larger than `HUBER`."""
    cut = away * np.minimum(1.0, HUBER / np.maximum(np.abs(away), 1e-12))
    return float((cut[lag:] * cut[:-lag].conj()).real[pairs].mean())


def _lag(observations: Observations, level: int) -> int:
    """Lines to the next one that has noise of its own: 1, more where the axis is finer than 1/record."""
    frequency, length = observations.records.frequency, observations.lengths[level]
    if length <= 0 or len(frequency) < 2:
        return 1
    step = float(np.median(np.diff(frequency)))
    return min(max(1, round(1 / (length * step))), len(frequency) - 1)


def _window(observations: Observations, level: int, lag: int) -> float:
    """What an exponential window w makes lines share: Re ∫w² e^(−2πi k t/T) dt / ∫w² dt, k the lag."""
    decay, length = observations.decays[level], observations.lengths[level]
    if decay <= 0 or length <= 0:
        return 0.0
    a = 2 * decay * length
    return a**2 / (a**2 + (2 * math.pi * lag) ** 2)
