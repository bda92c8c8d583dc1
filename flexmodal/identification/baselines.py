"""What needs no model: a posture's FRFs taken to be those of the other postures.

A model earns its keep only where it predicts a posture that it has not seen better than these do. Three
baselines stand beside it:

- the mean of the others: at each line the mean of ln|H| over the other postures, with the phase of the sum of
  their H/|H|; in the measure of the gap nothing that is one number a line lies nearer to all of them;
- the nearest posture: the FRF of the posture whose angles differ least, as root of the sum of squares;
- shuffled postures, a control: the same model fitted while every posture bears another's angles. A model that
  fits these as well has not been told by its data which posture is which.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex, Int

from flexmodal.identification.gap import gap
from flexmodal.identification.observations import Observations

BETTER = 0.95
"""A gap counts as smaller than another from this multiple of it down; less is chance."""

UNTOLD = "these data do not tell the postures apart"
MUCH_BETTER = 0.5
"""Multiple of the gap with the angles as stated from which down another's angles are the right ones."""


@dataclass(frozen=True)
class PostureBaseline:
    """One posture that was held out."""

    posture: str
    model: float
    """Gap of the model that had not seen it."""
    mean: float
    """Of the mean of the other postures' FRFs."""
    nearest: float
    """Of the FRFs of the nearest of them."""
    nearest_posture: str
    noise_floor: float


@dataclass(frozen=True)
class Baselines:
    """Gaps on what was held out, of a model and of what needs none, all on the same records."""

    model: float
    mean: float
    nearest: float
    noise_floor: float
    each: tuple[PostureBaseline, ...]
    missing: int = 0
    """FRFs that no other posture has a counterpart of; they are left out of all of these gaps."""
    fitted: float | None = None
    """Gap of the fit to everything, to set beside the next."""
    shuffled: float | None = None
    """The same where every posture bears another's angles; None where that was not tried."""

    @property
    def beats_mean(self) -> bool:
        """Whether the model is nearer than the mean of the others."""
        return self.model < BETTER * self.mean

    @property
    def beats_nearest(self) -> bool:
        """Whether the model is nearer than the nearest posture."""
        return self.model < BETTER * self.nearest

    @property
    def tells_postures(self) -> bool:
        """Whether the right angles fit better than shuffled ones; so where that was not tried."""
        return self.shuffled is None or self.fitted is None or self.fitted < BETTER * self.shuffled

    @property
    def verdict(self) -> str:
        """How the model stands beside them, in words."""
        mean, near = f"the mean of the others ({self.mean:.2g})", f"the nearest posture ({self.nearest:.2g})"
        if not self.beats_mean:
            also = "" if self.beats_nearest else f", nor than {near}"
            model = f"on postures it has not seen this model ({self.model:.2g})"
            says = [f"{model} predicts no better than {mean}{also}"]
        elif not self.beats_nearest:
            says = [
                f"on postures it has not seen this model ({self.model:.2g}) beats {mean} but predicts no "
                f"better than {near}"
            ]
        else:
            says = [f"on postures it has not seen it beats {mean} and {near} with {self.model:.2g}"]
        if self.fitted is not None and self.shuffled is not None and not self.tells_postures:
            says.append(untold(self.fitted, self.shuffled))
        return "; ".join(says)


def untold(fitted: float, control: float) -> str:
    """What it means that a model fits as well, or better, while postures bear others' angles.

    Args:
        fitted: gap with the angles as stated.
        control: gap with them shuffled.
    """
    gaps = f"({control:.2g} against {fitted:.2g})"
    if control < MUCH_BETTER * fitted:
        return (
            f"with the postures' angles shuffled it fits far better {gaps}: angles and FRFs do not belong "
            "together as stated; look at flexmodal check"
        )
    return f"with the postures' angles shuffled it fits as well {gaps}: {UNTOLD}"


def baselines(
    observations: Observations,
    predicted: Complex[np.ndarray, "observation line"],
    held_out: Sequence[str] = (),
) -> Baselines | None:
    """Set a model's held-out predictions beside what needs no model.

    Args:
        observations: everything that was measured.
        predicted: receptances of each observation by a model that had not seen its posture [m/N].
        held_out: names of the postures that the model was not shown, judged by the FRFs of the others. Each
            in turn, judged by all others, where none is named.

    Returns:
        None where no posture that is judged has a counterpart in another.
    """
    wanted = [
        number
        for number, one in enumerate(observations.postures)
        if np.any(observations.posture == number) and (not held_out or one.name in held_out)
    ]
    known = np.array([one.name not in held_out for one in observations.postures])
    mean, nearest = np.array(predicted), np.array(predicted)
    judged, donors = np.zeros(len(observations), bool), np.full(len(observations), -1)
    for row in np.flatnonzero(np.isin(observations.posture, wanted)).tolist():
        others = _counterparts(observations, row, known)
        if not others.size:
            continue
        mean[row] = log_mean(observations.value[others])
        away = [_distance(observations, row, other) for other in others.tolist()]
        donors[row] = others[int(np.argmin(away))]
        nearest[row], judged[row] = observations.value[donors[row]], True
    if not judged.any():
        return None
    each = tuple(
        _one(observations, number, rows, (predicted, mean, nearest), donors)
        for number in wanted
        if (rows := judged & (observations.posture == number)).any()
    )
    whole = [gap(observations, value, judged) for value in (predicted, mean, nearest)]
    missing = int(np.isin(observations.posture, wanted).sum() - judged.sum())
    return Baselines(whole[0].value, whole[1].value, whole[2].value, whole[0].noise_floor, each, missing)


def shuffled(observations: Observations) -> Observations:
    """The same FRFs while every posture bears another's angles: that half of the list further on.

    Args:
        observations: of two postures or more, or there is nothing to shuffle.
    """
    postures = observations.postures
    step = max(1, len(postures) // 2)
    turned = postures[step:] + postures[:step]
    return replace(
        observations,
        postures=tuple(replace(one, q=other.q) for one, other in zip(postures, turned, strict=True)),
    )


def log_mean(value: Complex[np.ndarray, "some line"]) -> Complex[np.ndarray, " line"]:
    """Mean of ln|H| at each line, with the phase of the sum of H/|H|; zeros are left out.

    Args:
        value: FRFs [m/N].

    Returns:
        0 on a line where all of them are.
    """
    size = np.abs(value)
    there = size > 0
    count = there.sum(axis=0)
    logarithm = np.log(np.where(there, size, 1.0)).sum(axis=0) / np.maximum(count, 1)
    turning = np.where(there, value / np.where(there, size, 1.0), 0).sum(axis=0)
    phase = np.where(turning == 0, 1.0, turning / np.where(turning == 0, 1.0, np.abs(turning)))
    return np.where(count > 0, np.exp(logarithm) * phase, 0)


def _counterparts(
    observations: Observations, row: int, known: Bool[np.ndarray, " posture"]
) -> Int[np.ndarray, " some"]:
    """Observations of the same two places in other postures, of the same kind of blow where there are."""
    same = known[observations.posture] & (observations.posture != observations.posture[row])
    same &= np.all(observations.response == observations.response[row], axis=1)
    same &= np.all(observations.reference == observations.reference[row], axis=1)
    alike = same & (observations.level == observations.level[row])
    return np.flatnonzero(alike if alike.any() else same)


def _distance(observations: Observations, one: int, other: int) -> float:
    """Root of the sum of squared differences of the angles of two observations' postures [rad]."""
    first, second = (observations.postures[int(observations.posture[row])].q for row in (one, other))
    return posture_distance(first, second)


def posture_distance(one: Mapping[str, float], other: Mapping[str, float]) -> float:
    """Root of the sum of squared differences of two postures' joints [rad, m]; a joint left out is 0.

    Args:
        one: angle or way of each joint.
        other: likewise.
    """
    return math.hypot(*(one.get(joint, 0.0) - other.get(joint, 0.0) for joint in {*one, *other}))


def _one(
    observations: Observations,
    number: int,
    rows: Bool[np.ndarray, " observation"],
    values: tuple[np.ndarray, np.ndarray, np.ndarray],
    donors: Int[np.ndarray, " observation"],
) -> PostureBaseline:
    model, mean, nearest = (gap(observations, value, rows) for value in values)
    lenders = np.bincount(observations.posture[donors[rows]], minlength=len(observations.postures))
    name = observations.postures[int(np.argmax(lenders))].name
    return PostureBaseline(
        observations.postures[number].name, model.value, mean.value, nearest.value, name, model.noise_floor
    )
