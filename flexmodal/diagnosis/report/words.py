"""What things are called in the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.names import NONE, UNKNOWN, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.identification import Observations
from flexmodal.report.words import minus, size

_KINDS = {
    "stiffness": "stiffness of {}",
    "damping": "damping of {}",
    "mass": "mass of {}",
    "inertia": "inertia of {}, relative",
}


def effect_words(diagnosis: Diagnosis) -> dict[str, str]:
    """Name of an effect to what it is, in words; effects of others included."""
    found = {NONE: "the robot re-tuned", UNKNOWN: "something that the catalogue does not know"}
    found[UNSTRUCTURED] = "one more mode, with no structure behind it"
    known = {**catalogue(), **{placed.effect.name: placed.effect for placed in diagnosis.model.placed}}
    return found | {name: effect.says for name, effect in known.items()}


def plain(name: str) -> str:
    """An effect's name as words."""
    return {NONE: "nothing added", UNSTRUCTURED: "mode without structure"}.get(name, name.replace("_", " "))


def placed(effect: str, where: str) -> str:
    """An effect with its place."""
    return f"{plain(effect)} ({where})" if where else plain(effect)


def parameter_words(name: str) -> str:
    """`stiffness.q1` as words; `effect@place.parameter` by its last part."""
    kind, _, where = name.partition(".")
    if where and "@" not in kind and kind in _KINDS:
        return _KINDS[kind].format(where)
    return name.rsplit(".", 1)[-1].replace("_", " ")


def pair(observations: Observations, row: int) -> str:
    """Response and reference of an observation, and the force where there are several."""
    both = " per ".join(
        observations.direction(where) for where in (observations.response[row], observations.reference[row])
    )
    if len(set(observations.level.tolist())) < 2:
        return both
    return f"{both}, {observations.peak(int(observations.level[row])):.3g} N"


def posture_name(observations: Observations, number: int) -> str:
    """Name of a posture by its id."""
    return next((p.name for p in observations.postures if p.id == number), str(number))


def posture_words(q: Mapping[str, float], prismatic: Sequence[str]) -> str:
    """Joint values in degrees, or metres."""
    each = {
        name: f"{value:.3f} m" if name in prismatic else f"{math.degrees(value):.1f}°"
        for name, value in q.items()
    }
    return ", ".join(f"{name} = {minus(value)}" for name, value in each.items())


def state(diagnosis: Diagnosis) -> Literal["found", "nothing", "open"]:
    """Whether something was found, nothing is missing, or something is left open."""
    if not diagnosis.verdict.explained:
        return "open"
    return "found" if diagnosis.verdict.effects else "nothing"


def not_testable(diagnosis: Diagnosis) -> list[str]:
    """Sentences about effects that these data cannot tell of."""
    return [
        f"{name.replace('_', ' ')} could not be tested: {why}." for name, why in diagnosis.untestable.items()
    ]


def held_out(value: float | None) -> str:
    """A remark on a gap."""
    return "" if value is None else f"held out: {size(value)}"
