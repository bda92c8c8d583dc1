"""One mode from what several FRFs say of it separately."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodal.ema.mode import ModeEstimate


def pooled(estimates: Sequence[ModeEstimate | None]) -> ModeEstimate:
    """Average frequency and damping by their variances; keep each FRF's residue.

    Where the FRFs disagree by more than their errors allow, the error of the average grows to match
    (Birge's ratio); what choices make of the numbers does not average out. An FRF without an estimate has
    the residue 0 until a linear fit finds it.

    Args:
        estimates: of one FRF each, in their order; at least one that is not None.
    """
    found = [estimate for estimate in estimates if estimate is not None]
    frequency, frequency_variance = _average(
        [one.frequency for one in found], [one.covariance[0, 0] for one in found]
    )
    damping, damping_variance = _average(
        [one.damping_ratio for one in found], [one.covariance[1, 1] for one in found]
    )
    together = np.sum([one.covariance[0, 1] for one in found]) / max(
        np.sqrt(
            np.sum([one.covariance[0, 0] for one in found]) * np.sum([one.covariance[1, 1] for one in found])
        ),
        np.finfo(float).tiny,
    )
    mixed = float(np.clip(together, -1, 1)) * np.sqrt(frequency_variance * damping_variance)
    empty = (np.zeros(1, dtype=complex), np.zeros((1, 2, 2)), np.zeros(1))
    parts = [
        empty if one is None else (one.residue, one.residue_covariance, one.by_choices[2:] ** 2)
        for one in estimates
    ]
    return replace(
        found[0],
        frequency=frequency,
        damping_ratio=damping,
        covariance=np.array([[frequency_variance, mixed], [mixed, damping_variance]]),
        residue=np.concatenate([part[0] for part in parts]),
        residue_covariance=np.concatenate([part[1] for part in parts]),
        choices=np.mean([one.choices for one in found], axis=0),
        residue_choices=np.concatenate([part[2] for part in parts]),
        freedom=float(sum(one.freedom for one in found)) if len(found) == 1 else float(len(found) - 1),
        remarks=tuple(dict.fromkeys(remark for one in found for remark in one.remarks)),
    )


def _average(values: Sequence[float], variances: Sequence[float]) -> tuple[float, float]:
    value, variance = np.array(values), np.array(variances)
    if np.all(variance == 0):  # forced by hand
        return float(np.mean(value)), 0.0
    weight = 1 / np.maximum(variance, 1e-30 + 1e-12 * np.max(variance))
    mean = float(np.sum(weight * value) / np.sum(weight))
    birge = float(np.sum(weight * (value - mean) ** 2)) / max(len(value) - 1, 1)
    return mean, max(birge, 1.0) / float(np.sum(weight))
