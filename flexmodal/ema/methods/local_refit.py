"""Modes that a fit of the whole band drives away, misses or meets poorly: fitted in bands of their own.

Where a band holds what the model has no terms for, such as modes damped beyond half of critical or just below
its first line, or ripples, least squares bends a mode that is there to explain them, or leaves one out. Round
its resonance the mode still stands, with residual terms for all the rest. So a band is split where its fit is
poor: each such mode, and each peak of the indicator that no mode explains, is fitted with its neighbours
between lines of its own, and what comes of it joins the others unless it is one of them already. A peak that
gives no mode is refused with the reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodal.ema.measured import FEWEST_LINES
from flexmodal.ema.methods.basis import TERMS
from flexmodal.ema.methods.fillers import HEAVY
from flexmodal.ema.methods.least_squares import (
    DRIVEN,
    HIDDEN,
    LeastSquaresProblem,
    solve_least_squares,
    with_terms_enough,
)
from flexmodal.ema.methods.standing import Standing, clear_peaks, unexplained
from flexmodal.ema.mode import EstimatedModes, ModeEstimate, with_residual_terms
from flexmodal.ema.quality import POOR, share_explained

_WIDTHS = 3.0
"""A mode counts as driven away that ends so many half-power bandwidths, and two lines, from its pole."""
_TERMS = 3
"""Terms more of the residual terms' series that a band of its own may take: the modes left out are near."""
_LINES = 12
"""Its own band reaches as many bandwidths to either side, and so many lines at least."""
_NEAR = 3.0
"""A damping ratio found there may differ from the one begun with by this factor."""
_RESOLVED = 3.0
"""A half-power band of fewer lines says how wide a mode is at most."""
_HALVED = 0.5
"""A poor fit is replaced by one that leaves at most this part of what it leaves round the resonance."""
_FEWEST = 0.5
"""A peak that no mode explained gives one if its own fit explains so much of the signal there."""


def refit_locally(problem: LeastSquaresProblem, found: EstimatedModes) -> EstimatedModes:
    """The modes that the fit of the whole band meets well, and what bands of their own show of the others.

    Args:
        problem: what was fitted, from poles that a stabilisation diagram or the indicator showed.
        found: what came of it.
    """
    spacing = problem.measured.spacing
    hidden = {frequency for frequency, why in found.refused if why == HIDDEN}
    starts = [start for start in problem.start if float(start[0]) not in hidden]
    stayed = [mode for mode in found if any(_stays(mode, start, spacing) for start in starts)]
    driven = [start for start in starts if not any(_stays(mode, start, spacing) for mode in stayed)]
    told = dict(found.refused)
    modes = [_better(problem, mode, found) for mode in stayed]
    for start in driven:
        frequency = float(start[0])
        alone = _alone(problem, start, problem.start, "in the whole band the fit drives it away")
        why = told.pop(frequency, f"{DRIVEN} it far from its pole")
        _join(modes, alone, frequency, told, why, problem)
    peaks = clear_peaks(problem.measured)
    for peak in _left(peaks, modes, spacing):
        if not _left([peak], modes, spacing):
            continue  # the fit of a higher one explains it
        known = next(
            (why for f, why in told.items() if abs(f - peak.frequency) <= max(peak.width, spacing)), ""
        )
        start = np.array([peak.frequency, min(max(peak.width / (2 * peak.frequency), 1e-6), HEAVY)])
        others = np.array([[mode.frequency, mode.damping_ratio] for mode in modes]).reshape(-1, 2)
        remark = "the fit of the whole band leaves its peak unexplained"
        alone = _alone(problem, start, np.concatenate([others, start[None]]), remark)
        why = f"a peak of {peak.rise:.1f} dB that the fit leaves unexplained"
        told = {
            f: w for f, w in told.items() if abs(f - peak.frequency) > max(peak.width, spacing) or f in hidden
        }
        _join(modes, alone, peak.frequency, told, f"{why}; {known}" if known else why, problem)
    if len(modes) == len(found) and all(a is b for a, b in zip(sorted_by(modes), found, strict=True)):
        return replace(found, refused=tuple(sorted(told.items())))
    whole = replace(found, modes=tuple(sorted_by(modes)), refused=tuple(sorted(told.items())))
    return with_residual_terms(whole, problem.residuals) if modes else replace(whole, modes=())


def refused_peaks(found: EstimatedModes) -> EstimatedModes:
    """The same modes, with a reason for each clear peak of the indicator that none of them explains.

    Args:
        found: what a reading of given peaks came to.
    """
    spacing = found.measured.spacing
    left = _left(clear_peaks(found.measured), list(found.modes), spacing)
    told = [frequency for frequency, _ in found.refused]
    more = [
        (peak.frequency, f"a peak of {peak.rise:.1f} dB that was not taken for a mode")
        for peak in left
        if not any(abs(f - peak.frequency) <= max(peak.width, 2 * spacing) for f in told)
    ]
    return replace(found, refused=tuple(sorted([*found.refused, *more]))) if more else found


def sorted_by(modes: Sequence[ModeEstimate]) -> list[ModeEstimate]:
    """Modes in the order of frequency."""
    return sorted(modes, key=lambda mode: mode.frequency)


def _left(peaks: Sequence[Standing], modes: Sequence[ModeEstimate], spacing: float) -> list[Standing]:
    return unexplained(peaks, [(mode.frequency, mode.damping_ratio) for mode in modes], spacing)


def _stays(mode: ModeEstimate, start: np.ndarray, spacing: float) -> bool:
    width = 2 * abs(float(start[1])) * float(start[0])
    return abs(mode.frequency - float(start[0])) <= _WIDTHS * width + 2 * spacing


def _join(
    modes: list[ModeEstimate],
    alone: ModeEstimate | str,
    frequency: float,
    told: dict[float, str],
    why: str,
    problem: LeastSquaresProblem,
) -> None:
    """Add a mode to those found, unless it is one of them; a peak without one is refused."""
    if isinstance(alone, str):
        told[frequency] = f"{why}, and {alone}"
        return
    twin = min(modes, key=lambda mode: abs(mode.frequency - alone.frequency), default=None)
    reach = max(problem.measured.spacing / 2, min(alone.damping_ratio, HEAVY) * alone.frequency / 2)
    if twin is not None and abs(twin.frequency - alone.frequency) <= reach:
        told[frequency] = f"{why}, and a fit of its own gives the mode at {twin.frequency:.4g} Hz once more"
        return
    modes.append(alone)


def _better(problem: LeastSquaresProblem, mode: ModeEstimate, found: EstimatedModes) -> ModeEstimate:
    """A mode, or, where the fit round it is poor, what its own band makes of it, if that is much better."""
    if mode.quality >= POOR:
        return mode
    start = np.array([mode.frequency, mode.damping_ratio])
    starts = np.array([[one.frequency, one.damping_ratio] for one in found.modes])
    alone = _alone(problem, start, starts, "the fit of the whole band is poor there")
    if isinstance(alone, str) or 1 - alone.quality > _HALVED * (1 - mode.quality):
        return mode
    return alone


def _alone(
    problem: LeastSquaresProblem, start: np.ndarray, starts: np.ndarray, because: str
) -> ModeEstimate | str:
    """One mode with its neighbours in a band of its own, or why there is none."""
    frequency, damping = float(start[0]), abs(float(start[1]))
    reach = max(_WIDTHS * 2 * damping * frequency, _LINES * problem.measured.spacing)
    axis = problem.measured.frequency
    lines = (axis >= frequency - reach) & (axis <= frequency + reach)
    inside = np.abs(starts[:, 0] - frequency) < reach
    unknowns = 4 * np.count_nonzero(inside) + 4
    if np.count_nonzero(lines) < max(FEWEST_LINES, unknowns / 2 + 1):
        return f"{np.count_nonzero(lines)} lines round it are too few for a fit of its own"
    low, high = float(axis[lines][0]), float(axis[lines][-1])
    nearest = np.argmin(np.abs(problem.start[None, :, 0] - starts[inside][:, :1]), axis=1)
    same = np.isclose(problem.start[nearest, 0], starts[inside][:, 0])
    part = replace(
        problem,
        measured=problem.measured.within(low, high),
        start=starts[inside],
        free=np.where(same[:, None], problem.free[nearest], True),
    )
    fit = solve_least_squares(with_terms_enough(part, _TERMS) if TERMS[part.residuals] else part)
    mode = min(fit.modes, key=lambda mode: abs(mode.frequency - frequency), default=None)
    if not fit.converged:
        return "a fit of its own does not converge"
    if mode is None or abs(mode.frequency - frequency) > max(
        2 * damping * frequency, 2 * problem.measured.spacing
    ):
        hidden = [why for f, why in fit.refused if abs(f - frequency) <= problem.measured.spacing]
        return f"in a fit of its own {hidden[0]}" if hidden else "a fit of its own finds none there"
    least = damping / _NEAR if 2 * damping * frequency > _RESOLVED * problem.measured.spacing else 0.0
    if not least < mode.damping_ratio < _NEAR * damping or mode.damping_ratio > max(HEAVY, damping):
        return (
            f"a fit of its own gives it a damping ratio of {mode.damping_ratio:.2g}, not about {damping:.2g}"
        )
    explained = share_explained(mode, fit)
    if explained < _FEWEST:
        return f"a fit of its own explains {100 * explained:.0f} % of the signal there"
    remark = f"fitted from {low:.4g} to {high:.4g} Hz: {because}"
    return replace(mode, remarks=(*mode.remarks, remark))
