"""Modes that a fit of the whole band drives away although the FRFs show them: fitted in bands of their own.

Where a band holds what the model has no terms for, such as modes damped beyond half of critical or just below
its first line, least squares bends a mode that is there to explain them. Round its resonance the mode still
stands, with residual terms for all the rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.ema.measured import FEWEST_LINES
from flexmodal.ema.methods.least_squares import DRIVEN, HIDDEN, LeastSquaresProblem, solve_least_squares
from flexmodal.ema.mode import EstimatedModes, ModeEstimate, with_residual_terms

_WIDTHS = 3.0
"""A mode counts as driven away that ends so many half-power bandwidths, and two lines, from its pole."""
_LINES = 12
"""Its own band reaches as many bandwidths to either side, and so many lines at least."""
_NEAR = 3.0
"""A damping ratio found there may differ from the one begun with by this factor."""


def refit_locally(problem: LeastSquaresProblem, found: EstimatedModes) -> EstimatedModes:
    """The modes that stayed near their poles, and the others as far as fits in bands of their own show them.

    Args:
        problem: what was fitted, from poles that a stabilisation diagram or the indicator showed.
        found: what came of it.
    """
    spacing = problem.measured.spacing
    hidden = {frequency for frequency, why in found.refused if why == HIDDEN}
    starts = [start for start in problem.start if float(start[0]) not in hidden]
    stayed = [mode for mode in found if any(_stays(mode, start, spacing) for start in starts)]
    driven = [start for start in starts if not any(_stays(mode, start, spacing) for mode in stayed)]
    if not driven:
        return found
    alone = {float(start[0]): _alone(problem, start) for start in driven}
    back = [mode for mode in alone.values() if mode is not None]
    modes = tuple(sorted([*stayed, *back], key=lambda mode: mode.frequency))
    told = dict(found.refused)
    lost = {f: told.get(f, f"{DRIVEN} it far from its pole") for f, mode in alone.items() if mode is None}
    refused = tuple(sorted([*((f, why) for f, why in found.refused if f not in alone), *lost.items()]))
    if not modes:
        return replace(found, modes=(), refused=refused)
    return with_residual_terms(replace(found, modes=modes, refused=refused), problem.residuals)


def _stays(mode: ModeEstimate, start: np.ndarray, spacing: float) -> bool:
    width = 2 * abs(float(start[1])) * float(start[0])
    return abs(mode.frequency - float(start[0])) <= _WIDTHS * width + 2 * spacing


def _alone(problem: LeastSquaresProblem, start: np.ndarray) -> ModeEstimate | None:
    """One mode with its neighbours in a band of its own; None if it does not stay there."""
    frequency, damping = float(start[0]), abs(float(start[1]))
    reach = max(_WIDTHS * 2 * damping * frequency, _LINES * problem.measured.spacing)
    axis = problem.measured.frequency
    lines = (axis >= frequency - reach) & (axis <= frequency + reach)
    inside = np.abs(problem.start[:, 0] - frequency) < reach
    unknowns = 4 * np.count_nonzero(inside) + 4
    if np.count_nonzero(lines) < max(FEWEST_LINES, unknowns / 2 + 1):
        return None
    low, high = float(axis[lines][0]), float(axis[lines][-1])
    part = replace(
        problem,
        measured=problem.measured.within(low, high),
        start=problem.start[inside],
        free=problem.free[inside],
    )
    fit = solve_least_squares(part)
    mode = min(fit.modes, key=lambda mode: abs(mode.frequency - frequency), default=None)
    if mode is None or not fit.converged:
        return None
    if abs(mode.frequency - frequency) > max(2 * damping * frequency, 2 * problem.measured.spacing):
        return None
    if not 1 / _NEAR < mode.damping_ratio / damping < _NEAR:
        return None
    remark = f"fitted from {low:.4g} to {high:.4g} Hz: in the whole band the fit drives it away"
    return replace(mode, remarks=(*mode.remarks, remark))
