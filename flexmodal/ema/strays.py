"""Modes that a fit of the whole band drives away although the FRFs show them: fitted in bands of their own.

Where a band holds what the model has no terms for, such as modes damped beyond half of critical or just below
its first line, least squares bends a mode that is there to explain them. Round its resonance the mode still
stands, with residual terms for all the rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.ema.least_squares import DRIVEN, LeastSquaresProblem, solve_least_squares
from flexmodal.ema.measured import FEWEST_LINES
from flexmodal.ema.mode import EstimatedModes, ModeEstimate, with_residual_terms

_WIDTHS = 3.0
"""A mode's own band reaches so many half-power bandwidths to either side, or so many lines:"""
_LINES = 12
_NEAR = 3.0
"""A damping ratio found there may differ from the one begun with by this factor."""


def with_strays(problem: LeastSquaresProblem, found: EstimatedModes) -> EstimatedModes:
    """The same modes, and those that were driven away as far as bands of their own show them.

    Args:
        problem: what was fitted.
        found: what came of it.
    """
    driven = {frequency for frequency, why in found.refused if why.startswith(DRIVEN)}
    back = {
        float(start[0]): mode
        for start in problem.start
        if float(start[0]) in driven and (mode := _alone(problem, start)) is not None
    }
    if not back:
        return found
    modes = tuple(sorted([*found.modes, *back.values()], key=lambda mode: mode.frequency))
    refused = tuple(one for one in found.refused if one[0] not in back)
    return with_residual_terms(replace(found, modes=modes, refused=refused), problem.residuals)


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
