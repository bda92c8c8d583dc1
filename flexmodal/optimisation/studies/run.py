"""Running a study."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmodal.frf import PointDirection
from flexmodal.model import Robot, load
from flexmodal.optimisation.frequency import Tuning, fixed_gain_descent, tune
from flexmodal.optimisation.optimise import optimise
from flexmodal.optimisation.outcome import Outcome
from flexmodal.optimisation.studies.study import Study

_GAIN = 20.0
"""Gain of the fixed-gain descents [Hz²], so large that some hop."""

Advance = Callable[[], None]


@dataclass(frozen=True)
class StudyResult:
    """Ours beside what is printed; which fields are filled depends on the kind."""

    study: Study
    unit: str
    start: float | None = None
    """Value in this model at the printed start."""
    printed: float | None = None
    """Value in this model at the printed final posture."""
    best: float | None = None
    """The best value found."""
    at: float | None = None
    """Parameter [rad] or frequency [Hz] of the best."""
    ends: tuple[float, ...] = ()
    """Values at the ends of a sweep, or the frequencies that the slope leads down to, 0 and ∞ too [Hz]."""
    pole_sum: tuple[float, ...] = ()
    """Of a sweep |Σ 1/(iω − λ)| over all poles at its ends, the thesis's prediction above 46 Hz."""
    minima: tuple[float, ...] = ()
    """All minima of a frequency study [Hz]."""
    hops: tuple[str, ...] = ()
    """Steps of a large gain over a maximum, in words."""
    outcome: Outcome | None = None
    tuning: Tuning | None = None

    @property
    def better(self) -> float | None:
        """How many times better the best is than the printed final posture, both in this model."""
        if self.printed is None or self.best is None:
            return None
        ratio = (
            (self.best, self.printed) if self.study.objective == "stiffness" else (self.printed, self.best)
        )
        return float("inf") if ratio[1] == 0 else ratio[0] / ratio[1]


def run_study(
    study: Study, *, starts: int | None = None, seed: int = 0, advance: Advance = lambda: None
) -> StudyResult:
    """Compute a study again.

    Args:
        study: which.
        starts: of the global search of a posture study, the printed start included.
        seed: of its random starts.
        advance: called once a start.

    Raises:
        FlexmodalError: what `flexmodal.load`, `flexmodal.optimise` and `flexmodal.tune` raise.
    """
    robot = load(study.robot)
    if study.kind == "frequency":
        return _frequency(study, robot)
    if study.kind == "sweep":
        return _sweep(study, robot)
    problem = study.problem(robot)
    found = optimise(problem, start=study.start, starts=starts, seed=seed, advance=advance)
    printed = problem.objective.value(robot.at(study.printed)) if study.printed else None
    return StudyResult(
        study,
        problem.objective.unit,
        start=None if found.compared is None else found.compared.objective,  # as it was printed
        printed=printed,
        best=found.best.objective,
        outcome=found,
    )


def _sweep(study: Study, robot: Robot) -> StudyResult:
    problem, family = study.problem(robot), robot.family(study.family)
    found = optimise(problem, family=family)
    ends, sums = [], []
    for parameter in (family.start, family.stop):
        values = {family.parameter: parameter} | {
            joint: factor * parameter for joint, factor in family.follow.items()
        }
        posed = robot.at(values)
        ends.append(problem.objective.value(posed))
        poles = posed.modes().expanded()[0]
        sums.append(float(abs(np.sum(1 / (2j * np.pi * study.frequency - poles)))))
    return StudyResult(
        study,
        problem.objective.unit,
        best=found.best.objective,
        at=found.best.posture.values[family.parameter],
        ends=tuple(ends),
        pole_sum=tuple(sums),
        outcome=found,
    )


def _frequency(study: Study, robot: Robot) -> StudyResult:
    along = PointDirection.parse(study.direction)
    posed = robot.at(study.posture)
    low, high = study.band
    found = tune(posed, (low, high), response=along)
    ends, hops = [], []
    for start in study.starts:
        ends.append(_downhill(found, start))
        large = fixed_gain_descent(posed, start, gain=_GAIN, ceiling=high, direction=along)
        hops += [f"{start:g} Hz: {a:.1f} to {b:.1f} Hz" for a, b in large.hops(found)]
    return StudyResult(
        study,
        "rad/(N·m)" if along.is_rotation else "m/N",
        best=found.best.receptance,
        at=found.best.frequency,
        ends=tuple(ends),
        minima=tuple(one.frequency for one in found.minima),
        hops=tuple(hops),
        tuning=found,
    )


def _downhill(found: Tuning, start: float) -> float:
    """The minimum that the slope leads to from a frequency; 0 or infinite where it leads out of the band."""
    places = [(one.frequency, True) for one in found.minima]
    places += [(one.frequency, False) for one in found.maxima]
    above = min((place for place in places if place[0] >= start), default=(np.inf, False))
    below = max((place for place in places if place[0] < start), default=(0.0, True))
    return above[0] if above[1] or not below[1] else below[0]
