"""How well a mode explains the lines around it, and what a reader should know before trusting it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.ema.measured import Measured
from flexmodal.ema.mode import EstimatedModes, ModeEstimate

_FEW_LINES = 2.0
"""Half-power bands narrower than this many lines are called narrow."""

POOR = 0.9
"""Share of the signal explained below which a fit is called poor."""


def with_quality(found: EstimatedModes) -> EstimatedModes:
    """The same modes with quality and remarks."""
    model = found.synthesise()
    modes = []
    for mode in found.modes:
        quality = _quality(mode, found.measured, model)
        modes.append(replace(mode, quality=quality, remarks=(*mode.remarks, *_remarks(mode, found, quality))))
    return replace(found, modes=tuple(modes))


def around(mode: ModeEstimate, measured: Measured) -> np.ndarray:
    """Which lines lie within two half-power bands of the resonance; the five nearest at least.

    Args:
        mode: whose resonance.
        measured: the FRFs it was found in.
    """
    distance = np.abs(measured.frequency - mode.frequency)
    reach = max(2 * abs(mode.damping_ratio) * mode.frequency, float(np.sort(distance)[4]))
    return distance <= reach


def share_explained(mode: ModeEstimate, found: EstimatedModes) -> float:
    """How much of the signal round a mode a fit explains, from 0 to 1.

    Args:
        mode: one of the fit's.
        found: the fit.
    """
    return _quality(mode, found.measured, found.synthesise())


def _quality(mode: ModeEstimate, measured: Measured, model: np.ndarray) -> float:
    """1 − Σ|measured − model|²/Σ|measured|² there, each FRF counted by its strength; not below 0."""
    lines = around(mode, measured)
    signal = np.sum(np.abs(measured.value[lines]) ** 2)
    away = np.sum(np.abs(measured.value[lines] - model[lines]) ** 2)
    return float(np.clip(1 - away / signal, 0.0, 1.0)) if signal > 0 else 0.0


def _remarks(mode: ModeEstimate, found: EstimatedModes, quality: float) -> list[str]:
    measured = found.measured
    remarks = []
    if mode.damping_ratio <= 0:
        remarks.append("the damping ratio is not positive: no passive structure has it")
    elif mode.damping_interval()[0] < 0:
        remarks.append("the interval of the damping ratio reaches 0")
    width = 2 * abs(mode.damping_ratio) * mode.frequency / measured.spacing
    if width < _FEW_LINES:
        remarks.append(f"the half-power band is {width:.2g} lines wide")
    if not measured.frequency[0] <= mode.frequency <= measured.frequency[-1]:
        remarks.append("the resonance lies outside the band")
    if quality < POOR:
        remarks.append(f"the fit explains {100 * quality:.0f} % of the signal around the resonance")
    return remarks
