"""Which measured mode is which of the model's: the pairs that the likelihood likes best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmodal.identification.evidence.likelihood.forecast import Forecast
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood, Pairs
from flexmodal.modal.tracking import assign

FARTHEST = -5e8
"""Ln likelihood under which two modes are no pair at all."""


def paired(
    likelihood: Likelihood, seen: Sequence[Forecast], scales: Mapping[str, float], grant: float
) -> Pairs:
    """Pair the modes of each posture so that the likelihood is highest.

    Args:
        likelihood: of the measured modes.
        seen: what the model predicts in each posture.
        scales: logarithms of the scales of the scatter.
        grant: relative error of frequencies that is granted besides.
    """
    measured = likelihood.measured
    pairs = [-1] * len(measured.modes)
    for number, here in enumerate(measured.here):
        if not here:
            continue
        gain = np.array([likelihood.gains(k, seen[number], scales, grant) for k in here])
        for k, m, row in zip(here, assign(-gain, 0.0).tolist(), gain, strict=True):
            pairs[k] = m if m >= 0 and row[m] > FARTHEST else -1
    return tuple(pairs)
