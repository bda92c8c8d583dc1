"""Gaps between what a model predicts and what was measured, fitted and held out."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.preparation import Bench
from flexmodal.diagnosis.weigh import Weighable
from flexmodal.identification import gap
from flexmodal.identification.gap import over_noise as averages_over_noise


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
    """Distance from the averages over that of their noise; 1 if perfect.

    Other than the gap it does not drown in the noise of single records and of points that hardly move.
    """
    return averages_over_noise(bench.observations, one.predicted)


def left(bench: Bench, first: Weighable, last: Weighable) -> float:
    """Part of the first model's disagreement above the noise that the last one leaves."""
    before, after = over_noise(bench, first), over_noise(bench, last)
    return max(after**2 - 1, 0.0) / max(before**2 - 1, 1e-300)
