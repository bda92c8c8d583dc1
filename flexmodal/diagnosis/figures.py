"""Gaps between what a model predicts and what was measured, fitted and held out."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from flexmodal.campaign.noise import expected_log_square
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.preparation import Bench
from flexmodal.diagnosis.weigh import Weighable
from flexmodal.identification import gap
from flexmodal.identification.gap import share

WORST = 0.05
"""Part of the observations, the worst, that do not count in how far a model is from the floor."""


def gap_of(bench: Bench, one: Weighable, keep: Bool[np.ndarray, " observation"]) -> float:
    """The gap on some of the observations."""
    return gap(bench.observations, one.predicted, keep).value


def gaps_of(bench: Bench, before: Weighable, after: Weighable, believed: float | None = None) -> Gaps:
    """The gaps of a pair of models, on everything and on the postures held out."""
    held = bench.held if bench.held.any() else None
    every = np.ones(len(bench.observations), dtype=bool)
    return Gaps(
        before=gap_of(bench, before, every),
        after=gap_of(bench, after, every),
        held_out_before=None if held is None else gap_of(bench, before, held),
        held_out_after=None if held is None else gap_of(bench, after, held),
        noise_floor=gap(bench.observations, after.predicted).noise_floor,
        believed=believed,
    )


def over_noise(bench: Bench, one: Weighable) -> float:
    """Root mean square of |ln(model / measured)| over that of the noise of the averages; 1 if perfect.

    Other than the gap it does not drown in the noise of single records and of points that hardly move. The
    few observations that are worst do not count: where a point hardly moves along its axis, a hammer's tilt
    of a fraction of a degree counts for more than noise.
    """
    observations = bench.observations
    away = share(observations, one.predicted).sum(axis=1)
    noise = (expected_log_square(observations.variance) * observations.used).sum(axis=1)
    ratio = away / np.maximum(noise, 1e-300)
    keep = ratio <= np.quantile(ratio, 1 - WORST)
    return float(np.sqrt(away[keep].sum() / max(float(noise[keep].sum()), 1e-300)))


def left(bench: Bench, first: Weighable, last: Weighable) -> float:
    """Part of the first model's disagreement above the noise that the last one leaves."""
    before, after = over_noise(bench, first), over_noise(bench, last)
    return max(after**2 - 1, 0.0) / max(before**2 - 1, 1e-300)
