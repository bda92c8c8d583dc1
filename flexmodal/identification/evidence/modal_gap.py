"""The gap with modes alone: relative errors of frequency, of damping (by a tenth), and 1 − MAC."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.likelihood.forecast import Forecast
from flexmodal.identification.evidence.measured_modes import MeasuredMode, ModeObservations
from flexmodal.modal.mac import mac_with

DAMPING_SHARE = 0.1


def mode_errors(
    mode: MeasuredMode, frequency: float, damping_ratio: float, alike: float
) -> tuple[float, float, float]:
    """Relative error of frequency, a tenth of that of damping, and 1 − MAC; NaN where nothing was measured.

    Args:
        mode: as it was measured.
        frequency: predicted [Hz].
        damping_ratio: predicted.
        alike: MAC of the shapes.
    """
    damping = DAMPING_SHARE * (damping_ratio / mode.damping_ratio - 1)
    return frequency / mode.frequency - 1, damping, 1 - alike


def errors_of(
    measured: ModeObservations, seen: Sequence[Forecast], pairs: Sequence[int], *, shapes: bool = True
) -> Float[np.ndarray, "mode 3"]:
    """Relative error of frequency, a tenth of that of damping, and 1 − MAC of every measured mode.

    NaN where nothing was measured, and throughout where the model has no partner.

    Args:
        measured: the modes.
        seen: what the model has in each posture.
        pairs: which mode of it each is.
        shapes: whether these are compared; of several hammer positions the mean.
    """
    table = np.full((len(measured.modes), 3), np.nan)
    for k, (mode, m) in enumerate(zip(measured.modes, pairs, strict=True)):
        if m < 0:
            continue
        one = seen[mode.posture]
        alike = [
            0.0 if np.isnan(one.shape[0, m]) else mac_with(s.residue, one.shape[measured.rows(s.places), m])
            for s in mode.shapes
            if shapes and len(s.places) > 1
        ]
        mac = float(np.mean(alike)) if alike else float("nan")
        frequency, ratio = np.exp(one.log_frequency[m]), np.exp(one.log_damping[m])
        table[k] = mode_errors(mode, float(frequency), float(ratio), mac)
    return table


def gap_of_errors(table: Float[np.ndarray, "observation 3"]) -> float:
    """Root mean square of what there is."""
    known = table[np.isfinite(table)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def noise_of(observed: ModeObservations, table: Float[np.ndarray, "observation 3"]) -> float:
    """The same figure for the errors of measurement, over the entries that the table has.

    Args:
        observed: the modes, with their standard errors.
        table: errors of a model by mode in frequency, damping and shape; NaN where there is none.
    """
    noise = np.full(table.shape, np.nan)
    for k, mode in enumerate(observed.modes):
        noise[k, 0], noise[k, 1] = mode.frequency_error, DAMPING_SHARE * mode.damping_error
        spread = []
        for shape in mode.shapes:
            part = np.abs(shape.residue) ** 2 / np.sum(np.abs(shape.residue) ** 2)
            spread.append(float(np.sum(part * shape.error**2)))
        if spread:
            noise[k, 2] = np.mean(spread)
    for k, zero in enumerate(observed.antiresonances):
        noise[len(observed.modes) + k, 0] = zero.error
    return gap_of_errors(np.where(np.isfinite(table), noise, np.nan))
