"""Where measurement and model disagree, of what kind the disagreement is, and in words.

A region is a run of neighbouring lines of one FRF on which the smoothed squared residual stands out of the
noise. Its share is its part of everything that stands out.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.outcome import Region
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual

SMOOTH = 3
"""Lines to either side over which a squared residual is averaged."""
STANDS_OUT = 4.0
"""Times the variance of the noise from which a line stands out."""
MOST = 12
"""Regions that are listed."""
NEAR = 0.06
"""Relative distance up to which two resonances count as one that moved."""

FEWEST = 5
"""Lines that two levels of force have to share to be compared."""

Signal = Complex[np.ndarray, " line"]


def excess(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> Float[np.ndarray, "observation line"]:
    """|ln(model / measured)|² above the noise; 0 on lines that are not used or do not stand out."""
    squared = np.where(observations.used, np.abs(residual(predicted, observations.value)) ** 2, 0.0)
    noise = np.where(observations.used, observations.variance, 0.0)
    kernel = np.ones(2 * SMOOTH + 1) / (2 * SMOOTH + 1)
    smooth = np.apply_along_axis(np.convolve, 1, squared, kernel, mode="same")
    floor = np.apply_along_axis(np.convolve, 1, noise, kernel, mode="same")
    return np.where(smooth > STANDS_OUT * floor + 1e-6, np.maximum(squared - noise, 0.0), 0.0)


def but_for_the_blow(observations: Observations) -> Int[np.ndarray, " observation"]:
    """A number for each observation, the same for those that differ in nothing but the force of the blow."""
    decay = np.array(observations.decays)[observations.level]
    key = np.column_stack([observations.posture, observations.response, observations.reference, decay])
    return np.unique(key, axis=0, return_inverse=True)[1].ravel()


def force_dependence(observations: Observations) -> float:
    """How much FRFs change with the force of the blow, over what their noise makes of it.

    The mean squared difference of the logarithm between two levels over the sum of their variances, for each
    pair; three in four pairs are below what is returned. About 1 for a linear structure; NaN with one level.
    """
    owner = but_for_the_blow(observations)
    found = []
    for pair in range(int(owner.max()) + 1):
        rows = np.flatnonzero(owner == pair)
        for one, other in itertools.pairwise(rows.tolist()):
            both = observations.used[one] & observations.used[other]
            noise = float(np.sum((observations.variance[one] + observations.variance[other])[both]))
            if both.sum() >= FEWEST and noise > 0:
                change = residual(observations.value[one][both], observations.value[other][both])
                found.append(float(np.sum(np.abs(change) ** 2)) / noise)
    return float(np.quantile(found, 0.75)) if found else float("nan")


def disagreement(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> tuple[Region, ...]:
    """The regions with the largest shares, the largest first; what several levels share, once.

    Args:
        observations: measured receptances.
        predicted: the model's, for every observation.
    """
    above = excess(observations, predicted)
    total = float(above.sum())
    if total <= 0:
        return ()
    found: list[tuple[float, int, int, int]] = []
    for row in range(len(observations)):
        for first, last in _runs(above[row]):
            found.append((float(above[row, first : last + 1].sum()) / total, row, first, last))
    found.sort(reverse=True)
    regions: list[Region] = []
    seen: dict[tuple[int, ...], int] = {}
    frequency = observations.axis.frequency
    for share, row, first, last in found:
        kind, says = _kind(observations, predicted, row, first, last)
        pair = (*observations.response[row].tolist(), *observations.reference[row].tolist())
        middle = round(20 * float(np.log(frequency[(first + last) // 2])))
        key = (int(observations.posture[row]), *pair, middle)
        if key in seen:
            known = regions[seen[key]]
            regions[seen[key]] = replace(known, share=known.share + share)
            continue
        if len(regions) >= MOST:
            continue
        seen[key] = len(regions)
        response, reference = observations.response[row].tolist(), observations.reference[row].tolist()
        regions.append(
            Region(
                posture=observations.postures[int(observations.posture[row])].id,
                response=(response[0], response[1]),
                reference=(reference[0], reference[1]),
                trial=int(observations.levels[int(observations.level[row])][0]),
                band=(float(frequency[first]), float(frequency[last])),
                share=share,
                kind=kind,
                says=says,
            )
        )
    return tuple(sorted(regions, key=lambda region: -region.share))


def _runs(above: Float[np.ndarray, " line"]) -> Iterator[tuple[int, int]]:
    """Runs of lines that stand out, gaps of a few lines bridged."""
    lines = np.flatnonzero(above > 0)
    if not lines.size:
        return
    for run in np.split(lines, np.flatnonzero(np.diff(lines) > 2 * SMOOTH) + 1):
        yield int(run[0]), int(run[-1])


def _kind(
    observations: Observations, predicted: np.ndarray, row: int, first: int, last: int
) -> tuple[str, str]:
    """Kind of a region and its sentence."""
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
    for sign, what in ((1.0, "resonance"), (-1.0, "antiresonance")):
        told = _peaks(observations.value[row], predicted[row], frequency, wide, window, sign, what)
        if told is not None:
            return told[0], f"{name}: {told[1]}"
    level = float(np.mean(r[window].real))
    more = "more" if level > 0 else "less"
    size = f"{abs(np.expm1(level)) * 100:.0f} %"
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


def _peaks(
    measured: Signal, model: Signal, frequency: np.ndarray, wide: slice, window: slice, sign: float, what: str
) -> tuple[str, str] | None:
    """What the resonances (or antiresonances) in a region have to say."""
    there, here = _extrema(measured, sign, wide), _extrema(model, sign, wide)
    inside = [k for k in there if window.start <= k < window.stop]
    ours = [k for k in here if window.start <= k < window.stop]
    if not inside and not ours:
        return None
    if inside and here.size:
        k = max(inside, key=lambda k: sign * np.log(np.abs(measured[k])))
        near = int(here[np.argmin(np.abs(np.log(frequency[here] / frequency[k])))])
        ratio = frequency[near] / frequency[k]
        if abs(np.log(ratio)) < NEAR:
            if abs(near - k) <= 1 and what == "resonance":
                level = np.abs(model[near]) / np.abs(measured[k])
                kind = "too much damping" if level < 1 else "too little damping"
                return kind, (
                    f"at {frequency[k]:.4g} Hz the model has {kind}: its peak is {level:.2f} × the measured"
                )
            return f"shifted {what}", (
                f"the {what} measured at {frequency[k]:.4g} Hz lies at {frequency[near]:.4g} Hz in the model"
            )
        return f"missing {what}", f"a measured {what} at {frequency[k]:.4g} Hz is missing from the model"
    if inside:
        k = max(inside, key=lambda k: sign * np.log(np.abs(measured[k])))
        return f"missing {what}", f"a measured {what} at {frequency[k]:.4g} Hz is missing from the model"
    if there.size and min(abs(np.log(frequency[ours[0]] / frequency[there]))) < NEAR:
        return f"shifted {what}", f"the model has a {what} at {frequency[ours[0]]:.4g} Hz that lies elsewhere"
    return f"extra {what}", f"the model has a {what} at {frequency[ours[0]]:.4g} Hz that was not measured"


def _extrema(value: Signal, sign: float, lines: slice | None = None) -> np.ndarray:
    """Peaks (sign 1) or dips (−1) of the magnitude, of a prominence of 10 % or more."""
    from scipy.signal import find_peaks

    log = sign * np.log(np.maximum(np.abs(value), 1e-300))
    smooth = np.convolve(np.pad(log, 1, mode="edge"), np.ones(3) / 3, mode="valid")
    found, _ = find_peaks(smooth, prominence=0.1)
    if lines is not None:
        found = found[(found >= lines.start) & (found < lines.stop)]
    return found


def _name(observations: Observations, row: int) -> str:
    def place(where: Sequence[int]) -> str:
        return f"{observations.campaign.point(int(where[0])).name}:{'xyz'[int(where[1]) - 1]}"

    posture = observations.postures[int(observations.posture[row])]
    return (
        f"{posture.name}, {place(observations.response[row].tolist())} per "
        f"{place(observations.reference[row].tolist())}"
    )
