"""Which measured mode is which of the model's: the pairs that the likelihood likes best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmodal.diagnosis.modes.forecast import Forecast
from flexmodal.diagnosis.modes.likelihood import Likelihood, Pairs

FARTHEST = -5e8
"""Ln likelihood under which two modes are no pair at all."""


def paired(
    likelihood: Likelihood, seen: Sequence[Forecast], scales: Mapping[str, float], grant: float
) -> Pairs:
    """Pair the modes of each posture by `scipy.optimize.linear_sum_assignment`.

    Args:
        likelihood: of the measured modes.
        seen: what the model predicts in each posture.
        scales: logarithms of the scales of the scatter.
        grant: relative error of frequencies that is granted besides.
    """
    from scipy.optimize import linear_sum_assignment

    measured = likelihood.measured
    pairs = [-1] * len(measured.observed.modes)
    for number, here in enumerate(measured.here):
        if not here:
            continue
        gain = np.array([likelihood.gains(k, seen[number], scales, grant) for k in here])
        padded = np.concatenate([gain, np.zeros((len(here), len(here)))], axis=1)
        for row, column in zip(*linear_sum_assignment(-padded), strict=True):
            if column < gain.shape[1] and gain[row, column] > FARTHEST:
                pairs[here[row]] = int(column)
    return tuple(pairs)
