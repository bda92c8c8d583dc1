"""Least squares fit of the modal sum [Hearne 2.19] with residual terms [2.20], of one FRF or of all.

Poles are shared by all the FRFs of a problem, residues are each FRF's own. `build_least_squares` gives
the problem, to be looked at; `solve_least_squares` the modes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.basis import TERMS, Residuals, check_residuals
from flexmodal.ema.methods.choice_variance import Solved, moves_of
from flexmodal.ema.methods.covariance import noise_of, propagate
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.separable import Separable, minimise
from flexmodal.ema.methods.weights import Weighting, by_deviation, weights_of
from flexmodal.ema.mode import EstimatedModes, ModeEstimate, fold_terms, with_residual_terms
from flexmodal.ema.quality import with_quality
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import POWER

DRIVEN = "the fit drives"
"""How a reason begins why a mode was left out that a fit of the whole band drives away."""
HIDDEN = "its residue cannot be told from 0"


@dataclass(frozen=True, eq=False)
class LeastSquaresProblem:
    """What is to be fitted, from where, and what counts how much."""

    measured: Measured
    start: Float[np.ndarray, "mode 2"]
    """Natural frequency [Hz] and damping ratio of each mode to begin from."""
    free: Bool[np.ndarray, "mode 2"]
    """Which of them are sought; the others stay."""
    residuals: Residuals = "complex"
    weighting: Weighting = "variance"
    vary: bool = True
    """Whether it is solved again under other residual terms, weights and band, for the uncertainty."""
    keep: bool = False
    """Whether modes stay that these FRFs do not show; otherwise the rest is fitted again without them."""
    further: int = 0
    """Terms more of the residual terms' series, see `residual_columns`."""


def build_least_squares(
    measured: Measured,
    peaks: Sequence[Peak],
    *,
    band: tuple[float, float] | None = None,
    residuals: str = "complex",
    weighting: str = "variance",
    vary: bool = True,
) -> LeastSquaresProblem:
    """Set a fit up.

    Args:
        measured: the FRFs.
        peaks: where the modes are, as `choose_peaks` gives them.
        band: the lines to fit [Hz]; all of them if None.
        residuals: none, real or complex terms for what lies outside the band.
        weighting: variance, uniform or logarithmic. Without a known variance the first weighs each FRF
            by what its own deviations show.
        vary: solve again under other residual terms, weights and band, and state how far that moves each
            number.

    Raises:
        InvalidRequest: no peaks, more unknowns than lines, or a choice that does not exist.
    """
    check_residuals(residuals)
    if weighting not in get_args(Weighting):
        raise InvalidRequest(Fault("call", "weighting", repr(weighting), ", ".join(get_args(Weighting))))
    part = measured if band is None else measured.within(*band)
    if not peaks:
        raise InvalidRequest(Fault("call", "peaks", "none", "at least one; give them by hand"))
    unknowns = 4 * len(peaks) + TERMS[check_residuals(residuals)]
    if 2 * len(part.frequency) <= unknowns:
        found = f"{len(part.frequency)} lines for {len(peaks)} modes"
        raise InvalidRequest(
            Fault("call", "peaks", found, f"more than {unknowns // 2} lines, or fewer modes")
        )
    ordered = sorted(peaks, key=lambda peak: peak.frequency)
    return LeastSquaresProblem(
        measured=part,
        start=np.array([[peak.frequency, peak.start_damping] for peak in ordered]),
        free=np.array([[not peak.holds_frequency, not peak.holds_damping] for peak in ordered]),
        residuals=residuals,  # type: ignore[arg-type]
        weighting=weighting,  # type: ignore[arg-type]
        vary=vary,
    )


def solve_least_squares(problem: LeastSquaresProblem) -> EstimatedModes:
    """Fit one problem."""
    return solve_many([problem])[0]


def solve_many(problems: Sequence[LeastSquaresProblem]) -> list[EstimatedModes]:
    """Fit problems of one shape (the same lines, modes, FRFs) together: much quicker than in turn."""
    first = problems[0]
    unit, power = float(np.mean(first.measured.omega)), POWER[first.measured.form]
    separable, scale, variance = _scaled(problems)
    value = separable.value
    start = np.stack([problem.start for problem in problems])
    omega, damping, state, settled = minimise(separable, 2 * np.pi * start[..., 0] / unit, start[..., 1])
    if variance is None and first.weighting == "variance" and value.shape[2] > 1:
        separable = replace(separable, weight=by_deviation(state.deviation))
        omega, damping, state, settled = minimise(separable, omega, damping)
    by_weight = first.weighting != "logarithmic"
    noise, freedom = noise_of(separable, omega, damping, state, variance, by_weight=by_weight)
    covariances = propagate(separable, omega, damping, state, noise)
    solved = Solved(separable, omega, damping, state, noise, covariances)
    moves = moves_of(solved, first.weighting, variance) if first.vary else np.zeros((1, 1, 1))
    moves = np.broadcast_to(moves, (*omega.shape, 2 + value.shape[2]))
    size = scale / unit**power
    found = [
        _collect(problem, group, unit, size[group, 0], solved, moves[group], freedom, settled)
        for group, problem in enumerate(problems)
    ]
    return [_without_runaways(problem, *one) for problem, one in zip(problems, found, strict=True)]


def _scaled(problems: Sequence[LeastSquaresProblem]) -> tuple[Separable, np.ndarray, np.ndarray | None]:
    """In units of the mean line and of each FRF's root mean square, which comes with it, and the variance."""
    first = problems[0]
    value = np.stack([problem.measured.value for problem in problems])
    scale = np.sqrt(np.mean(np.abs(value) ** 2, axis=1, keepdims=True))
    known = first.measured.variance is not None
    variance = np.stack([np.asarray(p.measured.variance) for p in problems]) / scale**2 if known else None
    value = value / scale
    separable = Separable(
        omega=first.measured.omega / np.mean(first.measured.omega),
        value=value,
        weight=weights_of(first.weighting, value, variance),
        power=POWER[first.measured.form],
        residuals=first.residuals,
        free=first.free,
        further=first.further,
    )
    return separable, scale, variance


def with_terms_enough(problem: LeastSquaresProblem, most: int) -> LeastSquaresProblem:
    """The problem with as many terms more of the residual terms' series as lower Schwarz's criterion.

    That is n ln S + p ln n for p real unknowns fitted to n real numbers with the sum of squares S (Annals of
    Statistics 6, 1978): a term more has to lower S by more than it would lower that of noise.

    Args:
        problem: a fit of few modes among many, in a band of their own.
        most: terms to try.
    """
    best, lowest = problem, np.inf
    start = problem.start[None] * [2 * np.pi / np.mean(problem.measured.omega), 1.0]
    for further in range(most + 1):
        trial = replace(problem, further=further)
        separable, _, _ = _scaled([trial])
        _, lines, frfs = separable.value.shape
        columns = 2 * len(problem.start) + (1 + further) * TERMS[problem.residuals]
        if columns + np.count_nonzero(problem.free) / frfs >= lines:
            break
        _, _, state, settled = minimise(separable, start[..., 0], start[..., 1])
        if not settled[0]:
            break
        count = 2 * separable.value.size
        unknowns = columns * frfs + np.count_nonzero(problem.free)
        left = max(float(state.cost[0]), np.finfo(float).tiny)
        criterion = count * np.log(left) + unknowns * np.log(count)
        if criterion < lowest:
            best, lowest = trial, criterion
    return best


def _without_runaways(
    problem: LeastSquaresProblem, modes: list[ModeEstimate], found: EstimatedModes
) -> EstimatedModes:
    """Fit again without the modes that these FRFs do not show, and say which those were."""
    why = [None if problem.keep else _runaway(mode, problem.measured) for mode in modes]
    if not any(why):
        return with_quality(found)
    keep = np.array([reason is None for reason in why])
    told = [(float(start[0]), reason) for start, reason in zip(problem.start, why, strict=True) if reason]
    if not keep.any():
        zero = np.zeros_like(found.upper)
        return replace(found, modes=(), upper=zero, lower=zero.copy(), refused=tuple(told), converged=True)
    again = solve_least_squares(replace(problem, start=problem.start[keep], free=problem.free[keep]))
    return replace(again, refused=tuple(sorted([*again.refused, *told])))


def _runaway(mode: ModeEstimate, measured: Measured) -> str | None:
    """Why an estimate is no mode of these FRFs; None if it may be one."""
    if not measured.frequency[0] <= mode.frequency <= measured.frequency[-1]:
        return f"{DRIVEN} it out of the band"
    if not -0.4 < mode.damping_ratio < 0.95:
        return f"{DRIVEN} its damping ratio to {mode.damping_ratio:.2g}"
    if not _shown(mode):
        return HIDDEN
    return None


def _shown(mode: ModeEstimate) -> bool:
    """Whether the residues differ from 0 at the level of 1 %: AᵀC⁻¹A against χ², of all FRFs or of one."""
    from scipy.special import chdtri

    parts = np.stack([mode.residue.real, mode.residue.imag], axis=1)
    scale = np.sqrt(np.maximum(np.diagonal(mode.residue_covariance, axis1=1, axis2=2), 1e-300))
    correlation = mode.residue_covariance / (scale[:, :, None] * scale[:, None, :]) + 1e-9 * np.eye(2)
    scaled = parts / scale
    sizes = np.sum(scaled * np.linalg.solve(correlation, scaled[..., None])[..., 0], axis=1)
    count = len(sizes)
    return bool(sizes.sum() > chdtri(2 * count, 0.01) or sizes.max() > chdtri(2, 0.01 / count))


def _collect(
    problem: LeastSquaresProblem,
    group: int,
    unit: float,
    size: Float[np.ndarray, " frf"],
    solved: Solved,
    moves: Float[np.ndarray, "mode number"],
    freedom: np.ndarray,
    settled: np.ndarray,
) -> tuple[list[ModeEstimate], EstimatedModes]:
    """One group's answer in SI units, the modes in the order of the start as well as sorted.

    The kernel's unit of residue is `size` × `unit`.
    """
    omega, damping, covariances = solved.omega, solved.damping, solved.covariances
    count = omega.shape[1]
    linear = solved.state.linear[group]
    units = np.array([unit / (2 * np.pi), 1.0])
    spread = np.diag(np.tile(units, count))
    pole = spread @ covariances.pole[group] @ spread
    modes = []
    for mode in range(count):
        part = slice(2 * mode, 2 * mode + 2)
        residue: Complex[np.ndarray, " frf"] = (
            (linear[:, 2 * mode] + 1j * linear[:, 2 * mode + 1]) * size * unit
        )
        modes.append(
            ModeEstimate(
                frequency=float(omega[group, mode] * unit / (2 * np.pi)),
                damping_ratio=float(damping[group, mode]),
                residue=residue,
                covariance=pole[part, part],
                residue_covariance=covariances.linear[group, :, part, part]
                * (size * unit)[:, None, None] ** 2,
                freedom=float(freedom[group]),
                quality=0.0,
                method="least-squares",
                choices=np.diag(moves[mode, :2] * units**2),
                residue_choices=moves[mode, 2:] * (size * unit) ** 2,
            )
        )
    terms = TERMS[problem.residuals]
    upper, lower = fold_terms(linear[:, 2 * count : 2 * count + terms].T * size)
    found = EstimatedModes(
        modes=tuple(sorted(modes, key=lambda mode: mode.frequency)),
        measured=problem.measured,
        method="least-squares",
        upper=upper,
        lower=lower * unit**2,
        converged=bool(settled[group]),
    )
    return modes, with_residual_terms(found, problem.residuals) if problem.further else found
