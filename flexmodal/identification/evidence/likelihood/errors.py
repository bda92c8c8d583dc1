"""The gap with modes alone, modes that the model lacks included, and the mean of the other postures.

As the file formats have it: the root mean square of relative errors of natural frequency, of damping (by a
tenth), and of 1 − MAC. A mode that the model lacks is wrong by 1, 0.1 and 1; a mode without structure
predicts no shape, which counts as 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.measured_modes import MeasuredMode, ModeObservations
from flexmodal.identification.evidence.modal_gap import DAMPING_SHARE, errors_of, gap_of_errors, mode_errors
from flexmodal.modal.mac import mac_with

Errors = Float[np.ndarray, "mode 3"]
"""Relative error of frequency, a tenth of that of damping, 1 − MAC; NaN where nothing was measured."""


@dataclass(frozen=True)
class Figures:
    """What a table of errors comes to."""

    frequency: float
    """Root mean square over modes with a partner [relative]."""
    damping: float
    mac: float
    """Mean over shapes that are predicted."""
    missing: int
    """Measured modes without a partner."""
    gap: float


def errors(fit: ModalFit) -> Errors:
    """Of every measured mode of a fit."""
    table = errors_of(fit.measured, fit.forecasts, fit.pairs)
    for k, mode in enumerate(fit.measured.modes):
        if fit.pairs[k] < 0:
            table[k] = lacking(mode)
    return table


def lacking(mode: MeasuredMode) -> tuple[float, float, float]:
    """Errors of a mode that the model does not have."""
    shaped = any(len(shape.places) > 1 for shape in mode.shapes)
    damped = np.isfinite(mode.damping_ratio)
    return 1.0, DAMPING_SHARE if damped else float("nan"), 1.0 if shaped else float("nan")


def figures(table: Errors) -> Figures:
    """Root mean squares and means."""
    there = table[:, 0] != 1.0
    alike = 1 - table[there, 2]
    return Figures(
        _rms(table[there, 0]),
        _rms(table[there, 1] / DAMPING_SHARE),
        float(np.mean(alike[np.isfinite(alike)])) if np.isfinite(alike).any() else float("nan"),
        int(np.sum(~there)),
        gap_of_errors(table),
    )


def mean_of_others(measured: ModeObservations) -> Errors:
    """Errors of a baseline without any model: each mode is what it is on average in the other postures."""
    modes = measured.modes
    table = np.full((len(modes), 3), np.nan)
    for k, mode in enumerate(modes):
        others = [m for m in modes if m.number == mode.number and m.posture != mode.posture]
        if not others:
            table[k] = lacking(mode)
            continue
        frequency = float(np.exp(np.mean([np.log(m.frequency) for m in others])))
        damped = [m.damping_ratio for m in others if np.isfinite(m.damping_ratio)]
        ratio = float(np.exp(np.mean(np.log(damped)))) if damped else float("nan")
        table[k] = mode_errors(mode, frequency, ratio, _alike_others(mode, others))
    return table


def _alike_others(mode: MeasuredMode, others: list[MeasuredMode]) -> float:
    """MAC with the shape that is nearest to those of the others, at the places they share."""
    if not mode.shapes:
        return float("nan")
    own = {
        (int(p), int(d)): r for (p, d), r in zip(mode.shapes[0].places, mode.shapes[0].residue, strict=True)
    }
    rows = []
    for other in others:
        for shape in other.shapes[:1]:
            known = {(int(p), int(d)): r for (p, d), r in zip(shape.places, shape.residue, strict=True)}
            row = np.array([known.get(place, 0.0) for place in own])
            if np.any(row):
                rows.append(row / np.linalg.norm(row))
    if not rows or len(own) < 2:
        return float("nan")
    best = np.linalg.svd(np.array(rows))[2][0].conj()
    return mac_with(np.array(list(own.values())), best.conj())


def _rms(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")
