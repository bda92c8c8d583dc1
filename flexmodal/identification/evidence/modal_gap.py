"""The gap with modes alone: relative errors of frequency, of damping (by a tenth), and 1 − MAC."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.measured_modes import MeasuredMode, ModeObservations
from flexmodal.identification.evidence.modal_residuals import ModeProblem

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


def errors_of(problem: ModeProblem, x: Float[np.ndarray, " parameter"]) -> Float[np.ndarray, "observation 3"]:
    """Relative error of frequency, a tenth of that of damping, and 1 − MAC; NaN where nothing was measured.

    Modes that the model has no partner for stay NaN; `ModeProblem.partners` names them. Antiresonances have a
    frequency only.
    """
    observed = problem.observations
    partners = problem.partners(x)
    table = np.full((len(observed), 3), np.nan)
    shapes = "shape" in problem.use or "residue" in problem.use
    for number in range(len(observed.postures)):
        here = observed.here[number]
        seen = problem.see(x, number, slopes=False)
        alike = problem.alike(number, seen)
        for row, k in enumerate(here):
            mode, partner = observed.modes[k], partners[k]
            if partner < 0:
                continue
            mac = float(alike[row, partner]) if shapes else float("nan")
            found = seen.found
            table[k] = mode_errors(mode, found.frequency[partner], found.damping_ratio[partner], mac)
    if "antiresonance" in problem.use:
        entries = problem.entries(x, partners, slopes=False)[len(observed.modes) :]
        for k, one in enumerate(entries):
            if one is not None:
                table[len(observed.modes) + k, 0] = np.expm1(one.residual[0])
    return table


def gap_of_errors(table: Float[np.ndarray, "observation 3"]) -> float:
    """Root mean square of what there is."""
    known = table[np.isfinite(table)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def noise_of(observed: ModeObservations, table: Float[np.ndarray, "observation 3"]) -> float:
    """The same figure for the errors of measurement, over the entries that the table has."""
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
