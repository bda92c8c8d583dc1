"""Postures that a fit did not see, predicted by it: errors, and the logarithm of the predictive density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from flexmodal.identification.evidence.likelihood.errors import Errors, errors
from flexmodal.identification.evidence.likelihood.fit import fit_modes
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.predictive import predictive, restricted
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.modal import NO_MODES

FEWEST = 3
"""Postures from which on each is held out in turn."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Predictions of what was not fitted."""

    errors: Errors
    """Of every measured mode; NaN throughout where it was not predicted."""
    score: float
    """ln of the predictive density over that of peaks from anywhere [nat]."""
    frequency: tuple[float, ...]
    """Predicted [Hz]; NaN where the model has no such mode."""


def in_turn(fit: ModalFit) -> HeldOut | None:
    """Leave out each posture in turn, fit to the others from where the fit to all ended, and predict."""
    observed = fit.measured
    posture = np.array([mode.posture for mode in observed.modes])
    folds = [posture == k for k in np.unique(posture)]
    if len(folds) < FEWEST:
        return None
    fits = []
    for fold in folds:
        seen = fit.measured.keeping(~fold)
        scales = {
            k: v for k, v in fit.scales.items() if "." not in k or int(k.rpartition(".")[2]) in seen.numbers
        }
        try:
            fits.append(fit_modes(fit.model, seen, fit.x, fit.beliefs, scales=scales))
        except NO_MODES:
            return None
    return together(fits, fit.measured, folds, fit)


def together(
    fits: Sequence[ModalFit],
    whole: ModeObservations,
    folds: Sequence[Bool[np.ndarray, " mode"]],
    usual: ModalFit,
) -> HeldOut:
    """What fits predict for the modes that each did not see.

    Args:
        fits: one for each fold.
        whole: all modes.
        folds: which of them each fit did not see.
        usual: scales for modes that a fit has never seen the like of.
    """
    table = np.full((len(whole.modes), 3), np.nan)
    frequency = np.full(len(table), np.nan)
    score = 0.0
    for one, fold in zip(fits, folds, strict=True):
        there = restricted(replace(one, scales={**usual.scales, **one.scales}), whole.keeping(fold))
        table[fold] = errors(there)
        frequency[fold] = [
            np.exp(there.forecasts[mode.posture].log_frequency[m]) if m >= 0 else np.nan
            for mode, m in zip(there.measured.modes, there.pairs, strict=True)
        ]
        score += predictive(there)
    return HeldOut(table, score, tuple(frequency.tolist()))
