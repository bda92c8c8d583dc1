"""What kind of disagreement a region of an FRF is, and the sentence that an engineer would say."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.disagreement.peaks import peaks
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual

SMOOTH = 3
"""Lines to either side over which a squared residual is averaged."""
APART, FAR = 0.01, 0.25
"""Relative distances from which a resonance has moved, and up to which two count as one that did."""
SAME = 0.05
"""Relative difference up to which two levels count as equal."""
STRETCH = 0.15
"""Relative change of all frequencies up to which a model is looked for in the measurement."""
MOVED = 0.3
"""Of the squared residual what may be left then."""
CLEAR, PROMINENT, FAINT = 0.3, 0.1, 0.01
"""Height of the logarithm of a peak over what is beside it: no noise, a peak, one that damping hides."""
FEWEST = 7
"""Lines from which that can be told."""

Signal = Complex[np.ndarray, " line"]


def kind_of(
    observations: Observations, predicted: np.ndarray, row: int, first: int, last: int
) -> tuple[str, str]:
    """Kind of a region of one FRF, and its sentence.

    Args:
        observations: measured receptances.
        predicted: the model's.
        row: number of the observation.
        first: line at which the region begins.
        last: its last line.
    """
    name = _name(observations, row)
    used = observations.used[row]
    r = residual(predicted[row], observations.value[row])
    frequency = observations.axis.frequency
    band = f"{frequency[first]:.3g} to {frequency[last]:.3g} Hz"
    whole = last - first > 0.6 * len(frequency)
    if whole:
        kind = _whole(r[used], frequency[used])
        if kind is not None:
            return kind[0], f"{name}: {kind[1]}"
    force = _force(observations, row, first, last)
    if force is not None:
        return "depends on force", f"{name}, {band}: {force}"
    window = slice(max(first - SMOOTH, 0), min(last + SMOOTH + 1, len(frequency)))
    wide = slice(max(first - 8 * SMOOTH, 0), min(last + 8 * SMOOTH + 1, len(frequency)))
    moved = _moved(observations.value[row], predicted[row], frequency, window)
    if moved is not None:
        return moved[0], f"{name}: {moved[1]}"
    for sign, what in ((1.0, "resonance"), (-1.0, "antiresonance")):
        told = _peaks(observations.value[row], predicted[row], frequency, wide, window, sign, what)
        if told is not None:
            return told[0], f"{name}: {told[1]}"
    level, lag = float(np.mean(r[window].real)), float(np.degrees(np.mean(r[window].imag)))
    if abs(level) < SAME and abs(lag) > 1:
        side = "ahead of" if lag > 0 else "behind"
        return "phase slope", f"{name}, {band}: the model is {abs(lag):.2g}° {side} what was measured"
    more = "more" if level > 0 else "less"
    part = abs(np.expm1(level)) * 100
    size = f"{part:.0f} %" if part >= 10 else f"{part:.2g} %"
    peaks = _extrema(predicted[row], 1.0)
    if peaks.size and frequency[last] < 0.8 * frequency[peaks[0]]:
        return "stiffness line", f"{name}, {band}: below the first resonance the model moves {size} {more}"
    if peaks.size and frequency[first] > 1.2 * frequency[peaks[-1]]:
        return "mass line", f"{name}, {band}: above the last resonance the model moves {size} {more}"
    return "level", f"{name}, {band}: the model moves {size} {more} than was measured"


def _whole(r: Signal, frequency: Float[np.ndarray, " line"]) -> tuple[str, str] | None:
    """A residual over the whole band that is one factor, or one delay."""
    level = float(np.median(r.real))
    slope = float(np.sum(frequency * r.imag) / np.sum(frequency**2))
    spread = float(np.sqrt(np.mean(np.abs(r) ** 2)))
    flat = float(np.sqrt(np.mean(np.abs(r - level) ** 2)))
    straight = float(np.sqrt(np.mean(np.abs(r - 1j * slope * frequency) ** 2)))
    if flat < 0.5 * spread and flat <= straight:
        factor = np.exp(-level)
        return "level", f"measured over model is {factor:.3g} at every frequency"
    if straight < 0.5 * spread:
        delay = slope / (2 * np.pi)
        return "phase slope", f"the phase falls with frequency as after a delay of {1e3 * delay:.3g} ms"
    return None


def _force(observations: Observations, row: int, first: int, last: int) -> str | None:
    """Whether the same FRF under other blows differs here by more than noise."""
    same = np.flatnonzero(
        (observations.posture == observations.posture[row])
        & np.all(observations.response == observations.response[row], axis=1)
        & np.all(observations.reference == observations.reference[row], axis=1)
        & (observations.level != observations.level[row])
    )
    lines = slice(first, last + 1)
    for other in same.tolist():
        both = observations.used[row, lines] & observations.used[other, lines]
        if both.sum() < 3:
            continue
        change = residual(observations.value[other, lines][both], observations.value[row, lines][both])
        noise = observations.variance[row, lines][both] + observations.variance[other, lines][both]
        if np.mean(np.abs(change) ** 2) > 9 * np.mean(noise):
            one, two = (observations.peak(int(observations.level[k])) for k in (row, other))
            return f"the FRF changes between blows of {one:.3g} N and {two:.3g} N"
    return None


def _moved(measured: Signal, model: Signal, frequency: np.ndarray, window: slice) -> tuple[str, str] | None:
    """Whether the model is right but for its frequencies; with much damping no peak shows it."""
    seen, here = measured[window], frequency[window]
    if len(here) < FEWEST:
        return None
    before = residual(model[window], seen)
    size = float(np.sum(np.abs(before) ** 2))
    level = float(np.sum(np.abs(before - np.mean(before)) ** 2)) / size
    stretches = np.exp(np.linspace(-STRETCH, STRETCH, 61))
    left = []
    for stretch in stretches:
        there = here / stretch
        shifted = np.interp(there, frequency, model.real) + 1j * np.interp(there, frequency, model.imag)
        inside = (there >= frequency[0]) & (there <= frequency[-1]) & (shifted != 0)
        after = residual(np.where(inside, shifted, seen), seen)
        left.append(
            float(np.sum(np.abs(after) ** 2)) / max(float(np.sum(np.abs(before[inside]) ** 2)), 1e-300)
        )
    best = int(np.argmin(left))
    if left[best] > MOVED or left[best] > 0.5 * level or not 0 < best < len(left) - 1:
        return None
    dips, tops = (_extrema(measured, sign, window) for sign in (-1.0, 1.0))
    what, found = ("antiresonance", dips) if dips.size and not tops.size else ("resonance", tops)
    middle = float(frequency[found[0]]) if found.size else float(here[int(np.argmax(np.abs(before)))])
    off = 1 / stretches[best] - 1
    return f"shifted {what}", (
        f"about {middle:.3g} Hz the model is what was measured moved by {100 * off:+.2g} % in frequency"
    )


def _peaks(
    measured: Signal, model: Signal, frequency: np.ndarray, wide: slice, window: slice, sign: float, what: str
) -> tuple[str, str] | None:
    """What resonances (or antiresonances) in a region have to say: which lack a partner, which differ."""
    there, here = _extrema(measured, sign, wide), _extrema(model, sign, wide, FAINT)
    pairs = _partners(there, here, frequency)
    lone = [k for k in _extrema(measured, sign, window, CLEAR).tolist() if k not in pairs]
    if lone:
        k = max(lone, key=lambda k: sign * np.log(np.abs(measured[k])))
        return f"missing {what}", f"a measured {what} at {frequency[k]:.4g} Hz is missing from the model"
    known = set(pairs.values())
    ours = [k for k in _extrema(model, sign, window, CLEAR).tolist() if k not in known]
    if ours:
        k = max(ours, key=lambda k: sign * np.log(np.abs(model[k])))
        return f"extra {what}", f"the model has a {what} at {frequency[k]:.4g} Hz that was not measured"
    inside = {k: near for k, near in pairs.items() if window.start <= k < window.stop}
    if not inside:
        return None
    k = max(inside, key=lambda k: abs(np.log(frequency[inside[k]] / frequency[k])))
    if abs(inside[k] - k) > 1 and abs(frequency[inside[k]] / frequency[k] - 1) > APART:
        return f"shifted {what}", (
            f"the {what} measured at {frequency[k]:.4g} Hz lies at {frequency[inside[k]]:.4g} Hz in the model"
        )
    k = max(inside, key=lambda k: abs(np.log(np.abs(model[inside[k]] / measured[k]))))
    level = float(np.abs(model[inside[k]] / measured[k]))
    if what != "resonance" or abs(level - 1) < SAME:
        return None  # what differs beside the peaks is something else
    kind = "too much damping" if level < 1 else "too little damping"
    return kind, f"at {frequency[k]:.4g} Hz the model has {kind}: its peak is {level:.2f} × the measured"


def _partners(there: np.ndarray, here: np.ndarray, frequency: np.ndarray) -> dict[int, int]:
    """Peaks of the measurement and of the model that are nearest to each other, and not too far."""
    if not there.size or not here.size:
        return {}
    far = np.abs(np.log(frequency[there][:, None] / frequency[here]))
    nearest = far.argmin(axis=1)
    return {
        int(k): int(here[near])
        for row, (k, near) in enumerate(zip(there, nearest, strict=True))
        if far[row, near] < FAR and int(far[:, near].argmin()) == row
    }


def _extrema(
    value: Signal, sign: float, lines: slice | None = None, prominence: float = PROMINENT
) -> np.ndarray:
    """Peaks (sign 1) or dips (−1) of the magnitude."""
    log = sign * np.log(np.maximum(np.abs(value), 1e-300))
    smooth = np.convolve(np.pad(log, 1, mode="edge"), np.ones(3) / 3, mode="valid")
    found = peaks(smooth, prominence)
    if lines is not None:
        found = found[(found >= lines.start) & (found < lines.stop)]
    return found


def _name(observations: Observations, row: int) -> str:
    posture = observations.postures[int(observations.posture[row])]
    response, reference = (
        observations.direction(where) for where in (observations.response[row], observations.reference[row])
    )
    return f"{posture.name}, {response} per {reference}"
