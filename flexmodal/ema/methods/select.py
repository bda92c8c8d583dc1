"""Which peaks are modes: by a rule that repeats itself exactly, and by hand where a person knows better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.least_squares import HIDDEN, build_least_squares, solve_least_squares
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.stabilisation import Tolerances, stabilise
from flexmodal.ema.methods.standing import half_power_width, mode_indicator, stand_out
from flexmodal.errors import Fault, InvalidRequest

_LOWEST_ORDERS = 6
"""A diagram of fewer orders shows nothing that stays."""

_BESIDE = 2.0
"""A peak within so many lines of a stable pole, or within its half-power bandwidth, is that pole's."""

_SURE = 7.0
"""Standard deviations by which a peak must stand out of the valleys beside it to be none of the noise's."""


def choose_peaks(
    measured: Measured,
    *,
    band: tuple[float, float] | None = None,
    at: Sequence[float | Peak] | None = None,
    forbid: Sequence[tuple[float, float]] = (),
    hold_frequency: Sequence[float] = (),
    damping: Mapping[float, float] | None = None,
    prominence: float = 2.0,
    most: int = 50,
    highest_order: int = 40,
    tolerances: Tolerances | None = None,
) -> tuple[Peak, ...]:
    """Find the peaks, or take those that a person names.

    The automatic ones are the poles that stay where they are while the order of a common-denominator fit of
    all FRFs rises (`stabilise`), since close or heavily damped modes make no peak of their own, and those
    peaks of the mode indicator that no such pole explains.

    Args:
        measured: the FRFs, all of them together.
        band: where to look [Hz].
        at: frequencies [Hz] or peaks to take instead of the automatic ones.
        forbid: bands in which no automatic peak is wanted [Hz].
        hold_frequency: frequencies that the fit must take as they are; one is added where no peak is near.
        damping: damping ratio to force on the peak nearest to each frequency.
        prominence: least height over the higher of the valleys beside a peak of the indicator [dB].
        most: keep so many of the most prominent peaks.
        highest_order: of the common-denominator fit.
        tolerances: what counts as a pole that stays.

    Raises:
        InvalidRequest: a frequency outside the measured lines, a damping to force where there is no peak.
    """
    part = measured if band is None else measured.within(*band)
    indicator = mode_indicator(part)
    widths: dict[float, float] = {}
    if at is None:
        widths = _stable_poles(part, highest_order, tolerances)
        places = [float(part.frequency[line]) for line in stand_out(part, indicator, prominence, _SURE, most)]
        reach = {pole: max(width, _BESIDE * part.spacing) for pole, width in widths.items()}
        places = [f for f in places if not any(abs(f - pole) <= reach[pole] for pole in reach)]
        chosen: list[float | Peak] = [
            f for f in sorted([*widths, *places]) if not any(low <= f <= high for low, high in forbid)
        ]
    else:
        chosen = list(at)
    for frequency in hold_frequency:
        near = [c for c in chosen if abs(_frequency(c) - frequency) <= 0.02 * frequency]
        chosen = [c for c in chosen if c not in near] + [frequency]
    _refuse_outside(part, chosen)
    peaks = _with_bands(part, indicator, chosen, widths, by_hand=at is not None)
    if at is None:
        peaks = _confirmed(part, peaks)
    held = set(hold_frequency)
    peaks = [replace(p, holds_frequency=True, by_hand=True) if p.frequency in held else p for p in peaks]
    return tuple(_force_damping(peaks, damping or {}))


def _confirmed(measured: Measured, peaks: list[Peak]) -> list[Peak]:
    """Without those whose residues least squares cannot tell from 0: noise has stable poles at times."""
    if not peaks or 4 * len(peaks) + 4 >= 2 * len(measured.frequency):
        return peaks
    found = solve_least_squares(build_least_squares(measured, peaks, vary=False))
    hidden = {frequency for frequency, why in found.refused if why == HIDDEN}
    return [peak for peak in peaks if peak.frequency not in hidden]


def _frequency(chosen: float | Peak) -> float:
    return chosen.frequency if isinstance(chosen, Peak) else float(chosen)


def _refuse_outside(measured: Measured, chosen: Sequence[float | Peak]) -> None:
    low, high = float(measured.frequency[0]), float(measured.frequency[-1])
    wrong = [_frequency(c) for c in chosen if not low < _frequency(c) < high]
    if wrong:
        allowed = f"frequencies inside {low:g} to {high:g} Hz"
        raise InvalidRequest([Fault("call", "peaks", f"{frequency:g} Hz", allowed) for frequency in wrong])


def _stable_poles(
    measured: Measured, highest_order: int, tolerances: Tolerances | None
) -> dict[float, float]:
    """Natural frequency and half-power bandwidth of the poles that stay where they are [Hz]."""
    highest = min(highest_order, (len(measured.frequency) - 1) // 3)
    if highest < _LOWEST_ORDERS:
        return {}
    diagram = stabilise(measured, highest=highest, tolerances=tolerances)
    found = {}
    for place in diagram.choose():
        frequency, damping = float(diagram.frequency[place]), float(diagram.damping_ratio[place])
        if measured.frequency[0] < frequency < measured.frequency[-1]:
            found[frequency] = 2 * damping * frequency
    return found


def _with_bands(
    measured: Measured,
    indicator: np.ndarray,
    chosen: Sequence[float | Peak],
    widths: Mapping[float, float],
    *,
    by_hand: bool,
) -> list[Peak]:
    """Give each frequency the lines as far as the valleys beside it, and its half-power width."""
    axis = measured.frequency
    ordered = sorted(chosen, key=_frequency)
    lines = [int(np.argmin(np.abs(axis - _frequency(c)))) for c in ordered]
    valleys = [a + int(np.argmin(indicator[a : b + 1])) if b > a else a for a, b in pairwise(lines)]
    edges = [0, *valleys, len(axis) - 1]
    peaks = []
    for place, (one, line) in enumerate(zip(ordered, lines, strict=True)):
        if isinstance(one, Peak):
            peaks.append(one)
            continue
        low, high = edges[place], edges[place + 1]
        frequency = float(one)
        below, above = min(float(axis[low]), frequency * 0.999), max(float(axis[high]), frequency * 1.001)
        width = widths.get(frequency) or half_power_width(axis, indicator, line, low, high)
        peaks.append(Peak(frequency, below, above, width, by_hand=by_hand))
    return peaks


def _force_damping(peaks: list[Peak], damping: Mapping[float, float]) -> list[Peak]:
    for frequency, ratio in damping.items():
        if not peaks:
            raise InvalidRequest(
                Fault("call", "damping", f"{ratio:g} at {frequency:g} Hz", "a peak to force it on")
            )
        nearest = min(range(len(peaks)), key=lambda place: abs(peaks[place].frequency - frequency))
        if abs(peaks[nearest].frequency - frequency) > 0.1 * frequency:
            found = f"{ratio:g} at {frequency:g} Hz, nearest peak at {peaks[nearest].frequency:g} Hz"
            raise InvalidRequest(Fault("call", "damping", found, "a peak within a tenth of that frequency"))
        peaks[nearest] = replace(peaks[nearest], damping=ratio)
    return peaks
