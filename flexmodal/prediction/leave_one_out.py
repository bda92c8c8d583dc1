"""Every posture left out in turn and predicted by every method, and the choices that follow from it.

A control stands beside: the model fitted to all postures while each bears another's angles. A model that then
fits as well as with the right ones has not been told by its data which posture is which.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.identification.baselines import BETTER, shuffled
from flexmodal.identification.evidence.evidence import Fitted
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.gap import gap, over_noise
from flexmodal.identification.observations import Observations
from flexmodal.prediction.alignment import natural_frequencies
from flexmodal.prediction.cross_motion import PARTS, with_cross_motion
from flexmodal.prediction.judging import (
    ALONE,
    SHARES,
    USUAL,
    best,
    best_part,
    best_share,
    standings,
    together,
    typical,
)
from flexmodal.prediction.methods import METHODS, Known, log_ratio, predicted_by_all
from flexmodal.prediction.panel import Panel, panel_of

SETTLED = 2e-5
"""A step that changes the cost of a fit without a posture relatively by less is its last."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Predictions of postures by what the others tell."""

    panel: Panel
    postures: tuple[int, ...]
    predicted: Mapping[str, Complex[np.ndarray, "observation line"]]
    """By method, of each observation by what had not seen its posture [m/N]."""
    gaps: Mapping[str, Float[np.ndarray, " posture"]]
    """By method, of each posture."""
    weight: Float[np.ndarray, " posture"]
    """What the lines of each posture count for together."""
    noise_floor: float
    resonances: tuple[Float[np.ndarray, " mode"], ...]
    """The model's natural frequencies in each posture as fitted without it [Hz]."""
    fitted: Float[np.ndarray, " posture"]
    """Gaps of the model fitted to all of them, which has seen what it is judged by."""
    shuffled: Float[np.ndarray, " posture"]
    """The same of a model fitted while each posture bears another's angles: a control."""
    times: Mapping[str, Float[np.ndarray, " posture"]]
    """By method, and of the two fits above as "fitted" and "shuffled": distance of each posture over that of
    the noise of its averages, the scale of every verdict."""
    standing: Float[np.ndarray, " posture"]
    """How much each posture says of one that nobody struck: its distance from the nearest other over the root
    mean square of these, 1 at most. A twin is predicted by its twin."""
    share: float = 1.0
    """Of what was learnt, that goes into `hybrid`; a posture left out is predicted by that of the others."""
    mix: float = 0.0
    """Weight of the prediction without physics in `hybrid`; likewise."""
    beside: float = PARTS[0]
    """Part of the mean of the postures that moves beside the model in `hybrid`; likewise."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the postures."""
        return tuple(self.panel.observations.postures[number].name for number in self.postures)

    @property
    def counts(self) -> Float[np.ndarray, " posture"]:
        """What each posture counts for where methods are compared."""
        return self.weight * self.standing

    @property
    def gap(self) -> dict[str, float]:
        """Of each method over all postures."""
        return {name: together(each, self.weight) for name, each in self.gaps.items()}

    @property
    def typical(self) -> dict[str, float]:
        """Of each method in a posture like these: the geometric mean."""
        return {name: typical(each, self.counts) for name, each in self.gaps.items()}

    @property
    def chosen(self) -> str:
        """The method that predicts best what it has not seen."""
        return best(self.gaps, self.counts)

    @property
    def tells_postures(self) -> bool:
        """Whether the right angles fit better than shuffled ones."""
        fitted, control = (typical(each, self.counts) for each in (self.fitted, self.shuffled))
        return fitted < BETTER * control

    @property
    def chosen_anew(self) -> Float[np.ndarray, " posture"]:
        """Gap of each posture where the method is chosen by the others, not by what it is judged by."""
        return np.array([self.gaps[name][one] for one, name in enumerate(self.methods_anew)])

    @property
    def methods_anew(self) -> tuple[str, ...]:
        """The method that the other postures choose for each."""
        count, found = len(self.postures), []
        for one in range(count):
            others = np.arange(count) != one
            found.append(best({n: each[others] for n, each in self.gaps.items()}, self.counts[others]))
        return tuple(found)

    def typical_times(self, name: str) -> float:
        """Distance of a typical posture over that of the noise: the geometric mean.

        Args:
            name: a key of `times`, or "anew" for the method that the other postures choose.
        """
        if name == "anew":
            each = np.array([self.times[method][one] for one, method in enumerate(self.methods_anew)])
        else:
            each = self.times[name]
        return typical(each, self.counts)


def leave_each_out(
    evidence: FrfEvidence,
    fitted: Fitted,
    *,
    sliding: tuple[str, ...] = (),
    advance: Callable[[], None] = lambda: None,
) -> LeftOut:
    """Leave every posture out in turn: of the fit of the physics, and of what is learnt beside it.

    Args:
        evidence: a robot's FRFs in three postures or more.
        fitted: to all of them, where the other fits begin.
        sliding: names of prismatic joints.
        advance: called after each posture.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    panel = panel_of(evidence.observations)
    seen, numbers = panel.observations, tuple(np.unique(panel.observations.posture).tolist())
    of_posture = seen.posture[seen.of_record]
    weight = np.array([float(seen.records.weight[of_posture == number].sum()) for number in numbers])
    standing = standings([seen.postures[number].q for number in numbers])
    counts = weight * standing

    judge = _Judge(seen, numbers, counts)
    told = _each_by_others(evidence, fitted, panel, numbers, sliding, advance)
    found = {name: np.array(seen.value) for name in METHODS}
    for number, known in told.items():
        here = seen.posture == number
        found["physics"][here], found["mean"][here] = known.physics[here], known.mean[panel.place[here]]
    moving = [with_cross_motion(found["physics"], found["mean"], part, seen.posture) for part in PARTS]
    by_part = np.stack([judge.gaps(value) for value in moving], axis=1)
    without = np.array(seen.value)
    for place, number in enumerate(numbers):
        here, others = seen.posture == number, np.arange(len(numbers)) != place
        known = replace(told[number], beside=best_part(by_part[others], counts[others], PARTS))
        rows, resonances = panel.of_posture(number), known.resonances[number]
        asked = known, seen.postures[number].q, known.physics[rows], panel.place[rows], resonances
        for name, value in predicted_by_all(*asked).items():
            found[name][here] = value
        without[here] = predicted_by_all(*asked, share=0.0)["hybrid"]

    more = log_ratio(found["hybrid"], without)
    found["hybrid"], share = judge.taken(without, more, USUAL)
    more = log_ratio(found["process"], found["hybrid"])
    found["hybrid"], mix = judge.taken(found["hybrid"], more, ALONE)
    floor = gap(seen, found["physics"]).noise_floor
    gaps = {name: judge.gaps(found[name]) for name in METHODS}
    controls = {"fitted": _physics(evidence, fitted.x), "shuffled": _shuffled(evidence)}
    right, wrong = (judge.gaps(value) for value in controls.values())
    times = {name: _times(seen, value, numbers) for name, value in {**found, **controls}.items()}
    own = tuple(told[k].resonances[k] if k in told else np.zeros(0) for k in range(len(seen.postures)))
    return LeftOut(
        panel, numbers, found, gaps, weight, floor, own, right, wrong, times,
        standing, share, mix, best_part(by_part, counts, PARTS),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Judge:
    """Postures that were left out, and what each counts for."""

    seen: Observations
    numbers: tuple[int, ...]
    counts: Float[np.ndarray, " posture"]

    def gaps(self, value: Complex[np.ndarray, "observation line"]) -> Float[np.ndarray, " posture"]:
        """Of receptances of every observation [m/N]."""
        return np.array([gap(self.seen, value, self.seen.posture == one).value for one in self.numbers])

    def taken(
        self,
        base: Complex[np.ndarray, "observation line"],
        more: Complex[np.ndarray, "observation line"],
        usual: float,
    ) -> tuple[Complex[np.ndarray, "observation line"], float]:
        """The base times e^(s more), s for each posture by what the others tell; and what all tell."""
        gaps = np.stack([self.gaps(base * np.exp(share * more)) for share in SHARES], axis=1)
        value = np.array(base)
        for place, number in enumerate(self.numbers):
            others, here = np.arange(len(self.numbers)) != place, self.seen.posture == number
            own = best_share(gaps[others], self.counts[others], usual)
            value[here] = base[here] * np.exp(own * more[here])
        return value, best_share(gaps, self.counts, usual)


def _each_by_others(
    evidence: FrfEvidence,
    fitted: Fitted,
    panel: Panel,
    numbers: tuple[int, ...],
    sliding: tuple[str, ...],
    advance: Callable[[], None],
) -> dict[int, Known]:
    """What the others tell of each posture, by its number."""
    told = {}
    for number in numbers:
        apart = evidence.keeping(evidence.observations.posture != number)
        x = apart.fit(fitted.x, warm=True, settled=SETTLED).x
        told[number] = known_by(evidence, panel, x, tuple(one for one in numbers if one != number), sliding)
        advance()
    return told


def _times(
    seen: Observations, value: Complex[np.ndarray, "observation line"], numbers: tuple[int, ...]
) -> Float[np.ndarray, " posture"]:
    """Distance of each posture over that of the noise of its averages."""
    each = [seen.posture == number for number in numbers]
    return np.array([over_noise(seen.keeping(here), value[here]) for here in each])


def _physics(evidence: FrfEvidence, x: Float[np.ndarray, " parameter"]) -> Complex[np.ndarray, "row line"]:
    """The model's receptances of every observation [m/N]."""
    from flexmodal.identification import predict

    return predict(evidence.model, x, evidence.observations)


def _shuffled(evidence: FrfEvidence) -> Complex[np.ndarray, "row line"]:
    """The same by a quick fit while every posture bears another's angles."""
    wrong = replace(evidence, observations=shuffled(evidence.observations))
    return _physics(wrong, wrong.fit(quick=True).x)


def known_by(
    evidence: FrfEvidence,
    panel: Panel,
    x: Float[np.ndarray, " parameter"],
    postures: tuple[int, ...],
    sliding: tuple[str, ...],
) -> Known:
    """What some postures tell of any in the panel.

    Args:
        evidence: whose model it is.
        panel: measured postures, perhaps with one more.
        x: coordinates of a fit to those postures.
        postures: numbers of those that may be looked at.
        sliding: names of prismatic joints.
    """
    seen = panel.observations
    model = evidence.model
    resonances = [natural_frequencies(model, x, one.q) for one in seen.postures]  # type: ignore[arg-type]
    physics = _physics(replace(evidence, observations=seen), x)
    return Known(panel, postures, physics, resonances, sliding)
