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
from flexmodal.prediction.judging import SHARES, best, best_share, standings, together, typical
from flexmodal.prediction.methods import METHODS, Known, predicted_by_all
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
    found = {name: np.array(seen.value) for name in METHODS}
    learnt = np.zeros(seen.value.shape, dtype=complex)
    resonances: list[np.ndarray] = [np.zeros(0) for _ in seen.postures]
    for number in numbers:
        here = seen.posture == number
        x = evidence.keeping(~here).fit(fitted.x, warm=True, settled=SETTLED).x
        known = known_by(evidence, panel, x, tuple(one for one in numbers if one != number), sliding)
        resonances[number] = known.resonances[number]
        rows = panel.of_posture(number)
        made = predicted_by_all(
            known, seen.postures[number].q, known.physics[rows], panel.place[rows], known.resonances[number]
        )
        for name, value in made.items():
            found[name][here] = value
        learnt[here] = _ratio(found["hybrid"][here], found["physics"][here])
        advance()
    of_posture = seen.posture[seen.of_record]
    weight = np.array([float(seen.records.weight[of_posture == number].sum()) for number in numbers])

    def gaps_of(value: Complex[np.ndarray, "observation line"]) -> Float[np.ndarray, " posture"]:
        return np.array([gap(seen, value, seen.posture == number).value for number in numbers])

    by_share = np.stack([gaps_of(found["physics"] * np.exp(share * learnt)) for share in SHARES], axis=1)
    standing = standings([seen.postures[number].q for number in numbers])
    counts = weight * standing
    for place, number in enumerate(numbers):
        others = np.arange(len(numbers)) != place
        own = best_share(by_share[others], counts[others])
        here = seen.posture == number
        found["hybrid"][here] = found["physics"][here] * np.exp(own * learnt[here])
    floor = gap(seen, found["physics"]).noise_floor
    gaps = {name: gaps_of(found[name]) for name in METHODS}
    share = best_share(by_share, counts)
    controls = {"fitted": _physics(evidence, fitted.x), "shuffled": _shuffled(evidence)}
    right, wrong = (gaps_of(value) for value in controls.values())
    times = {name: _times(seen, value, numbers) for name, value in {**found, **controls}.items()}
    return LeftOut(
        panel, numbers, found, gaps, weight, floor, tuple(resonances), right, wrong, times,
        standing, share,
    )  # fmt: skip


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


def _ratio(
    value: Complex[np.ndarray, "some line"], base: Complex[np.ndarray, "some line"]
) -> Complex[np.ndarray, "some line"]:
    """The logarithm of value / base, 0 where there is nothing to divide by."""
    there = (base != 0) & (value != 0)
    return np.log(np.where(there, value, 1.0) / np.where(there, base, 1.0))


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
