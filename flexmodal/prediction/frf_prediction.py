"""The FRFs of a posture that nobody struck, with their band, and why they should be believed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.frf import PointDirection
from flexmodal.identification.baselines import BETTER, untold
from flexmodal.identification.outcome import EXPLAINED
from flexmodal.prediction.judging import together, typical
from flexmodal.prediction.leave_one_out import LeftOut
from flexmodal.prediction.methods import DATA_ALONE, METHODS
from flexmodal.report.words import times_noise
from flexmodal.text.shown import Shown

FEW = 5
"""Postures below which the errors that a band is made of are a handful."""
CHOSEN_ANEW, SHUFFLED = "chosen anew", "angles shuffled"
BESIDE: Mapping[str, str] = {
    CHOSEN_ANEW: "the best of these without the posture that is judged",
    SHUFFLED: "a control: the model fitted to all, each with another's angles",
}
"""What stands below the methods."""
TWIN = 0.25
"""Of the usual distance between postures, below which one that was left out is said to count for less."""
APART = 3.0
"""Multiple of the typical gap from which a posture left out is named: there the method does not hold."""


@dataclass(frozen=True, eq=False)
class PredictedFrf:
    """One receptance."""

    response: PointDirection
    reference: PointDirection
    value: Complex[np.ndarray, " line"]
    """[m/N]"""
    log_size: Float[np.ndarray, " line"]
    """Half width of the 95 % band of ln|value|."""
    phase: Float[np.ndarray, " line"]
    """Half width of the 95 % band of the phase [rad]."""

    @property
    def low(self) -> Float[np.ndarray, " line"]:
        """Lower end of the size [m/N]."""
        return np.abs(self.value) * np.exp(-self.log_size)

    @property
    def high(self) -> Float[np.ndarray, " line"]:
        """Upper end of the size [m/N]."""
        return np.abs(self.value) * np.exp(self.log_size)


@dataclass(frozen=True, eq=False, repr=False)
class FrfPrediction(Shown):
    """Receptances of one posture."""

    robot: str
    campaign: str
    posture: Mapping[str, float]
    """[rad, m]"""
    frequency: Float[np.ndarray, " line"]
    """[Hz]"""
    frfs: tuple[PredictedFrf, ...]
    method: str
    """That predicts, see `METHODS`."""
    left_out: LeftOut
    beyond: tuple[str, ...] = ()
    """Joints that stand outside what was measured."""
    remote: float = 1.0
    """Distance to the nearest measured posture over the typical one between these, 1 or more."""
    axes: Mapping[str, str] = field(default_factory=dict)
    """What x, y, z are at points where they are not the world's."""
    ways: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """Unit vector in the world of every direction in this posture, by its text."""

    _PICTURE: ClassVar[str] = "flexmodal.prediction.plot:draw_prediction"

    def _facts(self) -> Mapping[str, object]:
        gaps = self.left_out.typical
        return {
            "": f"{len(self.frfs)} receptances of {self.robot}",
            "method": f"{self.method}: {METHODS[self.method]}",
            "gap, left out": f"{gaps[self.method]:.3g}, noise floor {self.left_out.noise_floor:.2g}",
        }

    @property
    def is_data_alone(self) -> bool:
        """Whether physics has no part in it."""
        return self.method in DATA_ALONE

    @property
    def rows(self) -> list[tuple[str, float, float, Float[np.ndarray, " posture"]]]:
        """Method, typical gap, gap over all postures left out, gap of each; those of `BESIDE` last."""
        left = self.left_out
        each = {name: left.gaps[name] for name in METHODS}
        each |= {CHOSEN_ANEW: left.chosen_anew, SHUFFLED: left.shuffled}
        return [
            (name, typical(gaps, left.counts), together(gaps, left.weight), gaps)
            for name, gaps in each.items()
        ]

    @property
    def verdict(self) -> str:
        """What it is worth, and what would make it better."""
        says = worth(self.left_out, self.method)
        if self.beyond:
            says.append(f"outside what was measured: {', '.join(self.beyond)}")
        if self.remote > 1 and self.method != "physics":
            says.append(f"{self.remote:.1f} times as far from the measured postures as these are apart")
        says += [f"x, y, z at {name} are {axes}" for name, axes in self.axes.items()]
        return "; ".join(says)


def worth(left: LeftOut, method: str) -> list[str]:
    """What a method is worth on postures it has not seen, in sentences.

    Args:
        left: what was left out.
        method: that predicts.
    """
    gaps = left.typical
    here = gaps[method]
    says = [
        f"predicted by {method}, {METHODS[method]}: {here:.2g} on a typical posture it had not "
        f"seen, {times_noise(left.typical_times(method))}"
    ]
    each = zip(left.names, left.gaps[method].tolist(), strict=True)
    far = [f"{name} ({value:.2g})" for name, value in each if value > APART * here]
    if far:
        says.append(f"it was far off in {', '.join(far)}: do not use it where the arm stands like that")
    says.append(_beside(gaps, method))
    twins = [name for name, standing in zip(left.names, left.standing, strict=True) if standing < TWIN]
    if twins:
        says.append(
            f"{', '.join(twins)}: so near to another posture that leaving it out says little; such a one "
            "counts for less"
        )
    if not left.tells_postures:
        fitted, control = (typical(each, left.counts) for each in (left.fitted, left.shuffled))
        says.append(untold(fitted, control))
    if method in DATA_ALONE:
        says.append(
            "physics has no part in this: no model of the robot predicts the postures as well; away from "
            "the measured postures nothing holds it"
        )
    if len(left.postures) < FEW:
        says.append(f"{len(left.postures)} postures were struck: the band rests on as many errors")
    if method in DATA_ALONE:
        says.append("next: look at `flexmodal check`, then strike more postures")
    elif left.typical_times(method) > EXPLAINED:
        says.append(
            "next: `flexmodal diagnose` looks for what the model lacks; a posture struck nearby narrows it"
        )
    return says


def _beside(gaps: Mapping[str, float], method: str) -> str:
    """How the method stands beside what needs no model."""
    mean, near = gaps["mean"], gaps["nearest"]
    worse = [
        f"{words} ({value:.2g})"
        for words, value in (("the mean of the others", mean), ("the nearest posture", near))
        if gaps[method] >= BETTER * value
    ]
    if worse:
        return f"this is no better than {' or '.join(worse)}"
    also = "" if method == "physics" else f", physics alone {gaps['physics']:.2g}"
    return f"the mean of the others has {mean:.2g}, the nearest posture {near:.2g}{also}"
