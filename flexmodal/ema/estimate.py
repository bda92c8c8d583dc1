"""Modes of a set of FRFs by any of the four methods, under one set of choices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np

from flexmodal.ema.choices import Choices
from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.basis import check_residuals
from flexmodal.ema.methods.choice_variance import moved
from flexmodal.ema.methods.circle import CircleFit, fit_circle
from flexmodal.ema.methods.fillers import without_fillers
from flexmodal.ema.methods.least_squares import (
    LeastSquaresProblem,
    build_least_squares,
    solve_least_squares,
    solve_many,
)
from flexmodal.ema.methods.local_refit import refit_locally, refused_peaks
from flexmodal.ema.methods.noise import with_variance
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.picking import pick_peak
from flexmodal.ema.methods.select import choose_peaks
from flexmodal.ema.methods.stabilisation import Stabilisation, stabilise
from flexmodal.ema.mode import EstimatedModes, Method, ModeEstimate, with_residual_terms
from flexmodal.ema.pooling import pooled
from flexmodal.ema.quality import with_quality
from flexmodal.errors import Fault, InvalidRequest


def estimate(
    measured: Measured, method: str = "least-squares", choices: Choices | None = None
) -> EstimatedModes:
    """Find modes that are common to some FRFs.

    Args:
        measured: the FRFs, of one structure in one state.
        method: peaks, circle, least-squares or lscf.
        choices: what to decide by hand.

    Raises:
        InvalidRequest: no such method, or choices that contradict the lines.
    """
    wanted = choices or Choices()
    name = check_method(method)
    check_residuals(wanted.residuals)
    part = measured if wanted.band is None else measured.within(*wanted.band)
    if name == "lscf":
        return _by_lscf(part, wanted)
    peaks = peaks_of(part, wanted)
    if not peaks:
        return nothing(part, name)
    if name == "least-squares":
        problem = _problem(part, peaks, wanted)
        return completed(problem, solve_least_squares(problem), wanted)
    return by_reading(part, peaks, name, wanted)


def check_method(method: str) -> Method:
    """Return the method, or raise InvalidRequest that lists the four."""
    if method not in get_args(Method):
        raise InvalidRequest(Fault("call", "method", repr(method), ", ".join(get_args(Method))))
    return method  # type: ignore[return-value]


def peaks_of(measured: Measured, choices: Choices) -> tuple[Peak, ...]:
    """The peaks that the choices amount to; errors as in `choose_peaks`.

    Args:
        measured: FRFs of one posture.
        choices: what a person decides.
    """
    return choose_peaks(
        measured,
        at=choices.at,
        forbid=choices.forbid,
        hold_frequency=choices.hold_frequency,
        damping=choices.damping,
        prominence=choices.prominence,
        highest_order=choices.highest_order,
        tolerances=choices.tolerances,
    )


def nothing(measured: Measured, method: Method) -> EstimatedModes:
    """An answer without modes, that says so.

    Args:
        measured: FRFs in which no mode was found.
        method: what was tried.
    """
    zero = np.zeros(measured.value.shape[1], dtype=complex)
    middle = float(np.median(measured.frequency))
    plain = refused_peaks(EstimatedModes((), measured, method, zero, zero.copy()))
    said = ((middle, "no peak stands out of the noise in the whole band; name one by hand"),)
    return plain if plain.refused else replace(plain, refused=said)


def each_by_least_squares(
    parts: Sequence[Measured], peaks: Sequence[Peak], choices: Choices
) -> list[EstimatedModes]:
    """Fit many sets of FRFs of one shape from the same peaks, each with poles of its own.

    Args:
        parts: FRFs, one by one.
        peaks: where to look.
        choices: what a person decides.
    """
    problems = [_problem(part, peaks, choices) for part in parts]
    pairs = zip(problems, solve_many(problems), strict=True)
    return [completed(problem, found, choices) for problem, found in pairs]


def completed(problem: LeastSquaresProblem, found: EstimatedModes, choices: Choices) -> EstimatedModes:
    """Without fillers, with what the whole band drove away, missed or met poorly; as is, if a person chose.

    Args:
        problem: what was fitted.
        found: what came of it.
        choices: what a person decides.
    """
    if choices.at is not None:
        return found
    found = refit_locally(problem, without_fillers(problem, found))
    forbidden = [mode for mode in found if any(low <= mode.frequency <= high for low, high in choices.forbid)]
    if not forbidden:
        return found
    left = tuple(mode for mode in found if mode not in forbidden)
    told = [(mode.frequency, "forbidden by hand") for mode in forbidden]
    plain = replace(found, modes=left, refused=tuple(sorted([*found.refused, *told])))
    return with_residual_terms(plain, problem.residuals)


def _problem(measured: Measured, peaks: Sequence[Peak], choices: Choices) -> LeastSquaresProblem:
    return build_least_squares(
        measured, peaks, residuals=choices.residuals, weighting=choices.weighting, vary=choices.vary
    )


def by_reading(measured: Measured, peaks: Sequence[Peak], method: Method, choices: Choices) -> EstimatedModes:
    """Peak picking or circle fit of every peak in every FRF, pooled over the FRFs.

    Args:
        measured: FRFs of one posture.
        peaks: where to look.
        method: peaks or circle.
        choices: what a person decides.
    """
    noisy = with_variance(measured)
    parts = [noisy.only(frf) for frf in range(measured.value.shape[1])]
    beside = _beside(parts, peaks) if choices.vary else [()] * len(parts)
    modes: list[ModeEstimate] = []
    refused: list[tuple[float, str]] = []
    for peak in peaks:
        answers = [_read(part, peak, method, other) for part, other in zip(parts, beside, strict=True)]
        found = [answer if isinstance(answer, ModeEstimate) else None for answer in answers]
        if all(one is None for one in found):
            refused.append((peak.frequency, str(answers[0])))
            continue
        modes.append(_fill_residues(pooled(found), found, noisy, peak))
    zero = np.zeros(measured.value.shape[1], dtype=complex)
    modes.sort(key=lambda mode: mode.frequency)
    plain = EstimatedModes(tuple(modes), measured, method, zero, zero.copy(), tuple(refused))
    if choices.at is None:
        plain = refused_peaks(plain)
    return with_quality(with_residual_terms(plain, check_residuals(choices.residuals))) if modes else plain


def _beside(parts: Sequence[Measured], peaks: Sequence[Peak]) -> list[Sequence[ModeEstimate]]:
    """What least squares finds in each FRF with all peaks at once: a reading knows of no neighbours."""
    if 2 * len(parts[0].frequency) <= 4 * len(peaks) + 4:
        return [()] * len(parts)
    fits = solve_many([build_least_squares(part, peaks, vary=False) for part in parts])
    return [one.modes if one.converged else () for one in fits]


def _read(
    measured: Measured, peak: Peak, method: Method, beside: Sequence[ModeEstimate]
) -> ModeEstimate | str:
    """Read one peak; how far least squares parts from it is what neighbours do to the reading."""
    answer = pick_peak(measured, peak) if method == "peaks" else fit_circle(measured, peak)
    found = answer.mode if isinstance(answer, CircleFit) else answer
    if isinstance(found, str):
        return found
    near = min(beside, key=lambda mode: abs(mode.frequency - found.frequency), default=None)
    if near is None or abs(near.frequency - found.frequency) > max(peak.width, measured.spacing):
        return found
    return moved(found, near)


def _fill_residues(
    mode: ModeEstimate, found: Sequence[ModeEstimate | None], measured: Measured, peak: Peak
) -> ModeEstimate:
    """Give the FRFs that show no such peak the residue that a linear fit finds at the pooled pole."""
    empty = [frf for frf, one in enumerate(found) if one is None]
    if not empty:
        return mode
    held = replace(
        peak,
        frequency=mode.frequency,
        low=min(peak.low, 0.999 * mode.frequency),
        high=max(peak.high, 1.001 * mode.frequency),
        holds_frequency=True,
        damping=min(max(mode.damping_ratio, 1e-9), 0.97),
    )
    residue, covariance = mode.residue.copy(), mode.residue_covariance.copy()
    near = measured.within(held.low, held.high)
    for frf in empty:
        problem = replace(build_least_squares(near.only(frf), [held], vary=False), keep=True)
        linear = solve_least_squares(problem)
        residue[frf] = linear.modes[0].residue[0]
        covariance[frf] = linear.modes[0].residue_covariance[0]
    names = ", ".join(measured.labels[frf] for frf in empty)
    remark = f"no such peak in {names}: residue there by a linear fit at this pole"
    return replace(mode, residue=residue, residue_covariance=covariance, remarks=(*mode.remarks, remark))


def _by_lscf(measured: Measured, choices: Choices) -> EstimatedModes:
    """Poles from the stabilisation diagram, residues by a linear fit; refined together unless told not to."""
    highest = min(choices.highest_order, (len(measured.frequency) - 1) // 2)
    diagram = stabilise(measured, highest=highest, tolerances=choices.tolerances)
    return modes_of(diagram, choices)


def modes_of(diagram: Stabilisation, choices: Choices) -> EstimatedModes:
    """The modes that a stabilisation diagram shows, or those nearest to the frequencies in `choices.at`.

    Args:
        diagram: a stabilisation diagram.
        choices: what a person decides.

    Raises:
        InvalidRequest: a frequency or damping forced where there is no stable pole.
    """
    measured = diagram.measured
    if choices.at is None:
        picked = [int(place) for place in diagram.choose()]
        picked = [p for p in picked if not any(a <= diagram.frequency[p] <= b for a, b in choices.forbid)]
    else:
        wanted = [one.frequency if isinstance(one, Peak) else float(one) for one in choices.at]
        picked = [diagram.nearest(frequency) for frequency in wanted]
    peaks = [_peak_at(diagram, place) for place in sorted(set(picked), key=lambda p: diagram.frequency[p])]
    if not peaks:
        return nothing(measured, "lscf")
    start = [peak if choices.refine else replace(peak, holds_frequency=True) for peak in peaks]
    start = [replace(p, damping=None) if choices.refine else p for p in start]
    start = _forced(start, choices)
    problem = _problem(measured, start, choices)
    found = solve_least_squares(problem)
    if choices.refine:
        found = completed(problem, found, choices)
    modes = [replace(mode, method="lscf") for mode in found.modes]
    if not choices.refine:
        modes = [_with_scatter(mode, diagram) for mode in modes]
    return replace(found, modes=tuple(modes), method="lscf")


def _peak_at(diagram: Stabilisation, place: int) -> Peak:
    frequency, damping = float(diagram.frequency[place]), float(diagram.damping_ratio[place])
    low, high = float(diagram.measured.frequency[0]), float(diagram.measured.frequency[-1])
    return Peak(
        frequency,
        min(low, 0.999 * frequency),
        max(high, 1.001 * frequency),
        width=2 * damping * frequency,
        damping=damping,
    )


def _forced(peaks: list[Peak], choices: Choices) -> list[Peak]:
    """Force what the choices force, on the nearest pole within a tenth."""
    for frequency, ratio in [(f, None) for f in choices.hold_frequency] + list(choices.damping.items()):
        nearest = min(range(len(peaks)), key=lambda place: abs(peaks[place].frequency - frequency))
        if abs(peaks[nearest].frequency - frequency) > 0.1 * frequency:
            found = f"{frequency:g} Hz, nearest pole at {peaks[nearest].frequency:.4g} Hz"
            raise InvalidRequest(Fault("call", "forced by hand", found, "a stable pole within a tenth"))
        change = {"frequency": frequency, "holds_frequency": True} if ratio is None else {"damping": ratio}
        peaks[nearest] = replace(peaks[nearest], **change)  # type: ignore[arg-type]
    return peaks


def _with_scatter(mode: ModeEstimate, diagram: Stabilisation) -> ModeEstimate:
    """Take the scatter over the orders, which are a choice, and say that it is no confidence interval."""
    near = [
        c for c in diagram.columns() if np.any(np.isclose(diagram.frequency[c], mode.frequency, rtol=1e-9))
    ]
    if not near:
        return mode
    table = np.stack([diagram.frequency[near[0]], diagram.damping_ratio[near[0]]])
    remark = "the uncertainty is the scatter over the orders, not a confidence interval"
    return replace(
        mode,
        covariance=np.zeros((2, 2)),
        choices=np.cov(table),
        remarks=(*mode.remarks, remark),
    )
