"""Trials: blows of one kind, and which of them repeat each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

MOST_DIGITS = 9_999_999_999
"""Ten digits: what a node or load case field of a UFF record holds."""
MOST_TRIAL = 99_999
"""Five digits: what its version field holds."""

PRETRIGGER = 0.02
"""Part of a record that usually lies before the blow."""
SAMPLING = 2.56
"""Sampling rate over the highest line, as analysers have it."""
PULSES = {"soft": 5e-3, "medium": 2.5e-3, "hard": 1e-3}
"""Usual length of a hammer's pulse of 100 N by its tip [s]; another tip counts as medium."""
USUAL_PEAK = 100.0
"""[N]"""

WindowKind = Literal["force", "exponential"]


@dataclass(frozen=True)
class Window:
    """A window on the time records of a blow.

    `force` keeps the pulse and lets the rest of the force fade as exp(−decay·t) after it. `exponential`
    multiplies force and response alike by exp(−decay·t), which moves every pole by −decay (see
    `without_window`).
    """

    kind: WindowKind
    decay: float
    """[1/s], 0 or more."""


@dataclass(frozen=True)
class Trial:
    """Blows of one kind; several may be averaged into one record."""

    id: int
    """Version number of the records; 1 to 99999."""
    force_peak: float
    """Typical peak of the blow [N]."""
    averages: int
    """Blows averaged into each FRF record."""
    tip: str
    record_length: float | None = None
    """[s]."""
    window: Window | Literal["none"] = "none"
    repeat_of: int | None = None
    """The trial that this one repeats."""


def pulse_length(tip: str, peak: float) -> float:
    """How long a hammer's pulse usually is, T ∝ P^(−1/6) for harder blows [s].

    As for Hertz's contact of a sphere (Johnson, Contact Mechanics, 1985, section 11.4: T ∝ v^(−1/5),
    P ∝ v^(6/5)).

    Args:
        tip: soft, medium or hard; another counts as medium.
        peak: of the force [N].
    """
    return PULSES.get(tip, PULSES["medium"]) * float((peak / USUAL_PEAK) ** (-1 / 6))


def repeat_groups(trials: Sequence[Trial]) -> tuple[tuple[int, ...], ...]:
    """Ids of trials that repeat each other, each trial in one group.

    A trial joins the one it names in `repeat_of`; without that, trials whose force peak and tip are equal
    belong together (file format, section 2).
    """
    group = {trial.id: trial.id for trial in trials}

    def head(trial: int) -> int:
        while group[trial] != trial:
            trial = group[trial]
        return trial

    kinds: dict[tuple[float, str], int] = {}
    for trial in trials:
        other = trial.repeat_of
        if other is None:
            other = kinds.setdefault((trial.force_peak, trial.tip), trial.id)
        if other in group and head(other) != head(trial.id):
            group[head(trial.id)] = head(other)
    members: dict[int, list[int]] = {}
    for trial in trials:
        members.setdefault(head(trial.id), []).append(trial.id)
    return tuple(tuple(ids) for ids in members.values())
