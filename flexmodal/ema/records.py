"""From records of a campaign to the FRFs that a fit takes: grouped by place, trials averaged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import FrfRecords, place_text
from flexmodal.ema.measured import Measured

_SMOOTH = 4
"""The scatter of trials is averaged over so many lines to either side."""
_SLOW = 8
"""Weights of trials are averaged over the lines over this to either side."""

Trials = Literal["average", "separate"]


@dataclass(frozen=True)
class Place:
    """Which FRF of a campaign."""

    posture: int
    response: tuple[int, int]
    reference: tuple[int, int]
    trial: int | None = None
    """None where trials were averaged."""

    def __str__(self) -> str:
        """Such as "3:+z per 2:+z"."""
        trial = "" if self.trial is None else f", trial {self.trial}"
        return f"{place_text(self.response)} per {place_text(self.reference)}{trial}"


def grouped(records: FrfRecords, trials: Trials) -> dict[Place, list[int]]:
    """Row numbers of each FRF, in the order of posture and then of the records.

    Args:
        records: FRFs of a campaign.
        trials: whether to keep them apart.
    """
    groups: dict[Place, list[int]] = {}
    for row in range(len(records.value)):
        response = (int(records.response[row, 0]), int(records.response[row, 1]))
        reference = (int(records.reference[row, 0]), int(records.reference[row, 1]))
        trial = int(records.trial[row]) if trials == "separate" else None
        place = Place(int(records.posture[row]), response, reference, trial)
        groups.setdefault(place, []).append(row)
    return dict(sorted(groups.items(), key=lambda item: item[0].posture))


def averaged(
    records: FrfRecords, groups: dict[Place, list[int]], variance: Float[np.ndarray, "record line"] | None
) -> tuple[Complex[np.ndarray, "line frf"], Float[np.ndarray, "line frf"] | None]:
    """Each FRF as the mean of its trials, with the variance of that mean.

    Trials count by 1/variance, taken as it goes over a quarter of the axis: the hammer fell a little
    elsewhere in each, so that weights that changed within a resonance would put one trial's residue on its
    one flank and another's on the other. The variance comes from those given for the records, raised where
    the trials scatter by more than these allow (Birge's ratio, smoothed over neighbouring lines); else, where
    every FRF has at least two trials, from their scatter about the mean, smoothed likewise; else it is not
    known.

    Args:
        records: FRFs of a campaign.
        groups: row numbers of each FRF.
        variance: E|noise|² of each record's values, in their unit squared.
    """
    values, spreads = [], []
    for rows in groups.values():
        stack = np.asarray(records.value)[rows]
        if variance is not None:
            noise = np.maximum(np.asarray(variance)[rows], np.finfo(float).tiny)
            weight = _slow_weight(noise)
            mean = np.sum(weight * stack, axis=0) / np.sum(weight, axis=0)
            birge = np.sum(np.abs(stack - mean) ** 2 / noise, axis=0) / max(len(rows) - 1, 1)
            values.append(mean)
            spread = np.sum(weight**2 * noise, axis=0) / np.sum(weight, axis=0) ** 2
            spreads.append(np.maximum(_smoothed(birge), 1.0) * spread)
            continue
        mean = np.mean(stack, axis=0)
        values.append(mean)
        if len(rows) > 1:
            scatter = np.sum(np.abs(stack - mean) ** 2, axis=0) / (len(rows) - 1) / len(rows)
            spreads.append(np.maximum(_smoothed(scatter), 1e-24 * np.max(np.abs(mean)) ** 2))
    known = len(spreads) == len(values)
    return np.stack(values, axis=1), np.stack(spreads, axis=1) if known else None


def _slow_weight(noise: Float[np.ndarray, "trial line"]) -> Float[np.ndarray, "trial line"]:
    """1/variance, its geometric mean over an eighth of the lines to either side; fewer at the ends."""
    lines = noise.shape[1]
    total = np.concatenate([np.zeros((len(noise), 1)), np.cumsum(np.log(noise), axis=1)], axis=1)
    first = np.maximum(np.arange(lines) - lines // _SLOW, 0)
    last = np.minimum(np.arange(lines) + lines // _SLOW + 1, lines)
    return np.exp((total[:, first] - total[:, last]) / (last - first))


def _smoothed(scatter: np.ndarray) -> np.ndarray:
    width = min(2 * _SMOOTH + 1, len(scatter))
    window = np.ones(width)
    return np.convolve(scatter, window, mode="same") / np.convolve(np.ones(len(scatter)), window, mode="same")


def by_posture(
    records: FrfRecords, trials: Trials, variance: Float[np.ndarray, "record line"] | None
) -> Iterator[tuple[int, Sequence[Place], Measured]]:
    """The FRFs of each posture together.

    Args:
        records: FRFs of a campaign.
        trials: whether to keep them apart.
        variance: E|noise|² of each record's values, in their unit squared.
    """
    groups = grouped(records, trials)
    for posture in dict.fromkeys(place.posture for place in groups):
        part = {place: rows for place, rows in groups.items() if place.posture == posture}
        value, spread = averaged(records, part, variance)
        labels = tuple(str(place) for place in part)
        ends = tuple((place_text(place.response), place_text(place.reference)) for place in part)
        ends = ends if len(set(ends)) == len(ends) else ()
        yield posture, list(part), Measured(records.frequency, value, records.form, spread, labels, ends)


def record_length(records: FrfRecords, posture: int) -> float | None:
    """Of the records that a posture's FRFs were estimated from, the shortest [s]; None where none is stated.

    Args:
        records: FRFs of a campaign.
        posture: its id.
    """
    used = set(records.trial[records.posture == posture].tolist())
    stated = [trial.record_length for trial in records.trials if trial.id in used]
    return min((length for length in stated if length is not None), default=None)
