"""Heavily damped modes that fill what others leave: refused unless lines that were held out need them.

A mode damped by a third makes no resonance; in a fit it mostly stands for what the model has no terms for.
Whether it is one of the structure is asked of lines that the fit did not see: every second part of the band
is fitted without the others, with the mode and without it, and the lines left out say which of the two
predicts them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from flexmodal.ema.methods.least_squares import LeastSquaresProblem, solve_least_squares
from flexmodal.ema.methods.noise import noise_levels
from flexmodal.ema.mode import EstimatedModes, ModeEstimate

HEAVY = 0.3
"""A damping ratio from which a mode has to be proved."""
_FEWEST = 3
"""Lines in a part of the band that is held out, half a half-power bandwidth wide otherwise; every second one
is."""
_BETTER = 3.0
"""Held-out squared deviations without the mode over those with it, from which on it is proved. Not sharp: on
arms of the rig with heavily damped joints two thirds of the modes above 0.3 have 10 and more, the others 3
and less."""


def without_fillers(problem: LeastSquaresProblem, found: EstimatedModes) -> EstimatedModes:
    """Fit again without the modes damped by 0.3 and more that lines held out do not need.

    Args:
        problem: what was fitted.
        found: what came of it.
    """
    told: list[tuple[float, str]] = []
    while True:
        heavy = [mode for mode in found.modes if mode.damping_ratio > HEAVY and not _held(mode, problem)]
        gains = [(_gain(problem, found, mode), mode) for mode in heavy]
        weak = [(gain, mode) for gain, mode in gains if gain < _BETTER]
        if not weak:
            return replace(found, refused=tuple(sorted([*found.refused, *told])))
        _, worst = min(weak, key=lambda pair: pair[0])
        size = f"damped by {100 * worst.damping_ratio:.0f} %"
        told.append((worst.frequency, f"{size}, and lines held out are predicted as well without it"))
        left = [mode for mode in found.modes if mode is not worst]
        if not left:
            zero = np.zeros_like(found.upper)
            refused = tuple(sorted([*found.refused, *told]))
            return replace(found, modes=(), upper=zero, lower=zero.copy(), refused=refused)
        before = found.refused
        found = solve_least_squares(_from(problem, left))
        found = replace(found, refused=tuple(sorted([*before, *found.refused])))


def _held(mode: ModeEstimate, problem: LeastSquaresProblem) -> bool:
    """Whether a person forced the damping of this mode."""
    nearest = int(np.argmin(np.abs(problem.start[:, 0] - mode.frequency)))
    return not problem.free[nearest].all()


def _from(problem: LeastSquaresProblem, modes: list[ModeEstimate]) -> LeastSquaresProblem:
    """The problem begun from these modes; what was held stays held."""
    start = np.array([[mode.frequency, mode.damping_ratio] for mode in modes])
    nearest = np.argmin(np.abs(problem.start[None, :, 0] - start[:, :1]), axis=1)
    return replace(problem, start=start, free=problem.free[nearest])


def _gain(problem: LeastSquaresProblem, found: EstimatedModes, mode: ModeEstimate) -> float:
    """Squared deviations of lines held out, without the mode over with it.

    Both sets of poles are those of fits of all lines; the residues are those of the lines that are seen.
    """
    others = [one for one in found.modes if one is not mode]
    again = (
        solve_least_squares(replace(_from(problem, others), vary=False, keep=True)).modes if others else ()
    )
    width = max(mode.damping_ratio * mode.frequency, _FEWEST * problem.measured.spacing)
    part = np.floor((problem.measured.frequency - problem.measured.frequency[0]) / width) % 2 == 0
    with_it, without = (
        sum(_left(problem, modes, lines) for lines in (part, ~part))
        for modes in (list(found.modes), list(again))
    )
    return without / with_it if with_it > 0 else 1.0


def _left(problem: LeastSquaresProblem, modes: list[ModeEstimate], lines: Bool[np.ndarray, " line"]) -> float:
    """Squared deviations of the other lines, residues fitted to these, each FRF in units of its noise."""
    measured = problem.measured
    scale = noise_levels(measured)
    if not modes:
        return float(np.sum(np.abs(measured.value[~lines] / scale) ** 2))
    if 2 * np.count_nonzero(lines) <= 4 * len(modes) + 4 or lines.all():
        return float("inf")
    variance = None if measured.variance is None else measured.variance[lines]
    seen = replace(
        measured, frequency=measured.frequency[lines], value=measured.value[lines], variance=variance
    )
    start = _from(problem, modes)
    held = replace(start, measured=seen, free=np.zeros_like(start.free), vary=False, keep=True)
    away = measured.value[~lines] - solve_least_squares(held).synthesise(measured.frequency[~lines])
    return float(np.sum(np.abs(away / scale) ** 2))
