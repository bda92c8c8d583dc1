"""Where measurement and model disagree, of what kind the disagreement is, and in words.

A region is a run of neighbouring lines of one FRF on which the smoothed squared residual stands out of the
noise. Its share is its part of everything that stands out.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.disagreement.kinds import SMOOTH, kind_of
from flexmodal.diagnosis.outcome import Region
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual

STANDS_OUT = 4.0
"""Times the variance of the noise from which a line stands out."""
MOST = 12
"""Regions that are listed."""
ALIKE = 1.01
"""Ratio up to which records are alike long; measured from the blow, they differ by a sample or two."""
FEWEST = 5
"""Lines that two levels of force have to share to be compared."""
FEWEST_PAIRS = 3
"""Sensors' directions under one hammer point in one posture that are judged apart from all others."""


def excess(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> Float[np.ndarray, "observation line"]:
    """|ln(model / measured)|² above the noise; 0 on lines that are not used or do not stand out.

    Args:
        observations: what was measured, with its noise.
        predicted: the same by a model.
    """
    squared = np.where(observations.used, np.abs(residual(predicted, observations.value)) ** 2, 0.0)
    noise = np.where(observations.used, observations.variance, 0.0)
    kernel = np.ones(2 * SMOOTH + 1) / (2 * SMOOTH + 1)
    smooth = np.apply_along_axis(np.convolve, 1, squared, kernel, mode="same")
    floor = np.apply_along_axis(np.convolve, 1, noise, kernel, mode="same")
    return np.where(smooth > STANDS_OUT * floor + 1e-6, np.maximum(squared - noise, 0.0), 0.0)


def but_for_the_blow(observations: Observations) -> Int[np.ndarray, " observation"]:
    """A number for each observation, the same for those that differ in nothing but the force of the blow.

    Others have another window, or records of another length, which cut off another part of the motion.
    """
    level = observations.level
    decay, length = np.array(observations.decays)[level], _lengths(observations)[level]
    key = np.column_stack(
        [observations.posture, observations.response, observations.reference, decay, length]
    )
    return np.unique(key, axis=0, return_inverse=True)[1].ravel()


def _lengths(observations: Observations) -> Int[np.ndarray, " level"]:
    """A number for each kind of blow, the same for records that are alike long."""
    length = np.array(observations.lengths, dtype=float)
    order = np.argsort(length)
    apart = length[order][1:] > ALIKE * length[order][:-1]
    found = np.zeros(len(length), dtype=int)
    found[order[1:]] = np.cumsum(apart)
    return found


def force_dependence(observations: Observations) -> float:
    """How much FRFs change with the force of the blow, over what their noise makes of it.

    The mean squared difference of the logarithm between two levels over the sum of their variances, for each
    pair; three in four pairs are below what is returned, or three in four of those of one hammer point in one
    posture above it, if that is more: what slides or touches may do so in one posture only. About 1 for a
    linear structure; NaN with one level.
    """
    owner = but_for_the_blow(observations)
    found: dict[tuple[int, ...], list[float]] = defaultdict(list)
    for pair in range(int(owner.max()) + 1):
        rows = np.flatnonzero(owner == pair)
        for one, other in itertools.pairwise(rows.tolist()):
            both = observations.used[one] & observations.used[other]
            noise = float(np.sum((observations.variance[one] + observations.variance[other])[both]))
            if both.sum() >= FEWEST and noise > 0:
                change = residual(observations.value[one][both], observations.value[other][both])
                blow = int(observations.posture[one]), *observations.reference[one].tolist()
                found[blow].append(float(np.sum(np.abs(change) ** 2)) / noise)
    if not found:
        return float("nan")
    somewhere = [float(np.quantile(some, 0.25)) for some in found.values() if len(some) >= FEWEST_PAIRS]
    return max(float(np.quantile(np.concatenate(list(found.values())), 0.75)), *somewhere, 0.0)


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
        kind, says = kind_of(observations, predicted, row, first, last)
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


def worst_point(seen: Observations, predicted: Complex[np.ndarray, "observation line"]) -> str:
    """Name of the point whose FRFs disagree most above the noise, all together.

    Args:
        seen: the FRFs.
        predicted: what a model has in their place.
    """
    above = excess(seen, predicted).sum(axis=1)
    points = np.unique(seen.response[:, 0])
    share = [above[seen.response[:, 0] == p].sum() for p in points]
    return seen.campaign.point(int(points[int(np.argmax(share))])).name
