"""Gaps between what a model predicts and what was measured, fitted and held out."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.preparation import Bench
from flexmodal.diagnosis.weigh import Weighable
from flexmodal.identification import gap
from flexmodal.identification.frf_fit import residual

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


def over_floor(bench: Bench, one: Weighable) -> float:
    """Gap over noise floor, without the few observations that are worst.

    Where a point hardly moves along its axis, a hammer's tilt of a fraction of a degree counts for more
    than noise.
    """
    observations = bench.observations
    each = np.where(observations.used, np.abs(residual(one.predicted, observations.value)) ** 2, 0.0)
    ratio = each.sum(axis=1) / np.maximum((observations.variance * observations.used).sum(axis=1), 1e-300)
    keep = ratio <= np.quantile(ratio, 1 - WORST)
    return gap(observations, one.predicted, keep).over_floor


def left(bench: Bench, first: Weighable, last: Weighable) -> float:
    """Part of the first model's disagreement above the noise that the last one leaves."""
    every = bench.observations
    floor = gap(every, last.predicted).noise_floor
    before, after = gap(every, first.predicted).value, gap(every, last.predicted).value
    return max(after**2 - floor**2, 0.0) / max(before**2 - floor**2, 1e-300)
