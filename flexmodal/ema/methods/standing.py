"""Peaks that stand out of the mode indicator, and which of them no mode explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.noise import noise_levels, scatter, with_variance

_DEEPEST = 1e-20
"""A valley is taken for no deeper than this part of its peak."""
_CLEAR, _SURE = 6.0, 5.0
"""Decibels and standard deviations by which a peak stands over its valleys that asks for a mode or for a
reason."""
_BESIDE = 2.0
"""A peak within so many lines of a mode is that mode's."""


@dataclass(frozen=True)
class Standing:
    """A peak of the mode indicator."""

    frequency: float
    """[Hz]."""
    rise: float
    """Over the higher of its valleys [dB]."""
    width: float
    """Half-power bandwidth as the lines show it [Hz]."""


def mode_indicator(measured: Measured) -> Float[np.ndarray, " line"]:
    """Σ|Y|² over the FRFs as mobilities, each in units of its noise: every mode is a peak of it.

    A mobility's peak is symmetric about the natural frequency, and the sum misses no mode for a node at
    one point. It is the trace of what a complex mode indicator function (CMIF; Shih, Tsuei, Allemang and
    Brown 1988) has as singular values, with the noise whitened, so that an FRF of a point which hardly moves
    does not cover the others with its noise.
    """
    mobility = measured.to("mobility")
    return np.sum(np.abs(mobility.value / noise_levels(mobility)) ** 2, axis=1)


def clear_peaks(measured: Measured) -> list[Standing]:
    """Peaks of 6 dB and five standard deviations, the highest first: each asks for a mode or a reason.

    Args:
        measured: the FRFs.
    """
    indicator = mode_indicator(measured)
    lines = stand_out(measured, indicator, _CLEAR, _SURE, len(indicator))
    found = []
    for line in lines:
        rise = 10 * np.log10(_ratio(indicator, np.array([line]))[0])
        width = half_power_width(measured.frequency, indicator, int(line), 0, len(indicator) - 1)
        found.append(Standing(float(measured.frequency[line]), float(rise), width))
    return sorted(found, key=lambda one: -one.rise)


def unexplained(
    peaks: Sequence[Standing], modes: Sequence[tuple[float, float]], spacing: float
) -> list[Standing]:
    """Those peaks that have no mode within their half-power bandwidth, the mode's own, or two lines.

    Args:
        peaks: of the indicator.
        modes: natural frequency [Hz] and damping ratio.
        spacing: of the lines [Hz].
    """
    return [
        peak
        for peak in peaks
        if not any(
            abs(peak.frequency - frequency)
            <= max(_BESIDE * spacing, min(peak.width, 2 * damping * frequency))
            for frequency, damping in modes
        )
    ]


def stand_out(
    measured: Measured, indicator: np.ndarray, prominence: float, sure: float, most: int
) -> np.ndarray:
    """Lines of the peaks that rise over their valleys by `prominence` and by more than noise does.

    Args:
        measured: the FRFs.
        indicator: their mode indicator.
        prominence: least rise [dB].
        sure: least rise, in standard deviations of the indicator there.
        most: so many of the most prominent ones.
    """
    lines = 1 + np.flatnonzero((indicator[1:-1] > indicator[:-2]) & (indicator[1:-1] >= indicator[2:]))
    mobility = with_variance(measured).to("mobility")
    power = noise_levels(mobility) ** 2
    # Ripples from line to line, as of a delay, repeat like the signal, and are no modes either.
    share = np.maximum(np.asarray(mobility.variance), scatter(mobility.value)) / power
    # |Y + n|² has the variance 2|Y|²v + v² for circular noise of variance v.
    spread = np.sqrt(np.sum(2 * np.abs(mobility.value) ** 2 / power * share + share**2, axis=1))
    ratio = _ratio(indicator, lines)
    rise = indicator[lines] * (1 - 1 / ratio)
    clear = (10 * np.log10(ratio) >= prominence) & (rise >= sure * spread[lines])
    best = np.argsort(-ratio[clear], kind="stable")[:most]
    return np.sort(lines[clear][best])


def _ratio(indicator: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Height over the higher of the valleys beside each line."""
    valley = np.maximum(_lowest_since_higher(indicator), _lowest_since_higher(indicator[::-1])[::-1])[lines]
    ratio: np.ndarray = indicator[lines] / np.maximum(valley, _DEEPEST * indicator[lines])
    return ratio


def _lowest_since_higher(values: np.ndarray) -> np.ndarray:
    """For each entry the lowest one on the way back to a higher entry, or to the start if there is none."""
    lowest = values.copy()
    open_ones: list[int] = []  # falling values, each with no higher one behind it so far
    for place in range(len(values)):
        while open_ones and values[open_ones[-1]] <= values[place]:
            lowest[place] = min(lowest[place], lowest[open_ones.pop()])
        open_ones.append(place)
    return lowest


def half_power_width(axis: np.ndarray, indicator: np.ndarray, line: int, low: int, high: int) -> float:
    """Distance of the half-power points; twice the one that there is, or 4 % where there is none.

    Args:
        axis: the lines [Hz].
        indicator: on them.
        line: of the peak.
        low: first line to look at.
        high: last one.
    """
    half = indicator[line] / 2
    sides = []
    for path in (range(line, low, -1), range(line, high)):
        step = path.step
        for here in path:
            if indicator[here] >= half > indicator[here + step]:
                share = (indicator[here] - half) / (indicator[here] - indicator[here + step])
                sides.append(
                    abs(float(axis[here] - axis[line])) + share * abs(float(axis[here + step] - axis[here]))
                )
                break
    if not sides:
        return 0.04 * float(axis[line])
    return float(sum(sides) if len(sides) == 2 else 2 * sides[0])
