"""Gaps between what a model predicts and what was measured, fitted and held out."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Complex

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import gap, predict
from flexmodal.identification.gap import over_noise as averages_over_noise


def as_believed(setup: Setup) -> Complex[np.ndarray, "observation line"]:
    """What the card says of a test, as that is thought to be set up.

    Args:
        setup: what the diagnosis works with.
    """
    return predict(Hypothesis(setup.context, setup.base), np.zeros(len(setup.base)), setup.observations)


def gap_of(setup: Setup, one: FittedFrfs, keep: Bool[np.ndarray, " observation"]) -> float:
    """The gap on some of the observations.

    Args:
        setup: what the diagnosis works with.
        one: the model.
        keep: observations that count.
    """
    return gap(setup.observations, one.predicted, keep).value


def gaps_of(setup: Setup, before: FittedFrfs, after: FittedFrfs, believed: float | None = None) -> Gaps:
    """The gaps of a pair of models, on everything and on the postures held out.

    Args:
        setup: what the diagnosis works with.
        before: the first model of the pair.
        after: the second.
        believed: gap of the card as it came; None where nobody asks for it.
    """
    held = setup.held if setup.held.any() else None
    every = np.ones(len(setup.observations), dtype=bool)
    return Gaps(
        before=gap_of(setup, before, every),
        after=gap_of(setup, after, every),
        held_out_before=None if held is None else gap_of(setup, before, held),
        held_out_after=None if held is None else gap_of(setup, after, held),
        noise_floor=gap(setup.observations, after.predicted).noise_floor,
        believed=believed,
    )


def over_noise(setup: Setup, one: FittedFrfs, keep: Bool[np.ndarray, " observation"] | None = None) -> float:
    """Distance from the averages over that of their noise, on some of the observations; 1 if perfect.

    Other than the gap it does not drown in the noise of single records and of points that hardly move. Where
    a test was not set up exactly, what is held out has the variance of its tolerances, many times that of the
    noise; it counts by the number of its lines then, lest all the others drown in it.

    Args:
        setup: what the diagnosis works with.
        one: the model.
        keep: observations that count; all if None.
    """
    if setup.said is None:
        return _over_noise(setup, one, keep)
    kept = np.ones(len(setup.held), dtype=bool) if keep is None else keep
    parts = [kept & ~setup.held, kept & setup.held]
    lines = [int(setup.observations.used[part].sum()) for part in parts]
    if not all(lines):
        return _over_noise(setup, one, kept)
    far = [_over_noise(setup, one, part) for part in parts]
    return float(np.sqrt(np.average(np.square(far), weights=lines)))


def _over_noise(setup: Setup, one: FittedFrfs, keep: Bool[np.ndarray, " observation"] | None) -> float:
    """The same, all of what counts taken together."""
    if keep is None:
        return averages_over_noise(setup.observations, one.predicted)
    return averages_over_noise(setup.observations.keeping(keep), one.predicted[keep])


def left(setup: Setup, first: FittedFrfs, last: FittedFrfs) -> float:
    """Part of the first model's disagreement above the noise that the last one leaves.

    Args:
        setup: what the diagnosis works with.
        first: the model whose disagreement counts as whole.
        last: the model with what was found.
    """
    before, after = over_noise(setup, first), over_noise(setup, last)
    return max(after**2 - 1, 0.0) / max(before**2 - 1, 1e-300)
