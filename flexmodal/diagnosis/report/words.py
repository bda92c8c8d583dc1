"""What things are called in the report, and how numbers are written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.names import NONE, UNKNOWN, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.identification import Observations

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
    return ", ".join(f"{name} = {value.replace('-', '−')}" for name, value in each.items())


def size(value: float | None) -> str:
    """A gap, with three figures; a dash for none."""
    return "–" if value is None or not math.isfinite(value) else f"{value:#.3g}".rstrip(".")


def figure(value: float, unit: str = "") -> str:
    """A physical number with four figures and its unit."""
    text = f"{value:.4g}" if math.isfinite(value) else "–"
    if "e" in text:
        head, power = text.split("e")
        text = f"{head} × 10{_raised(int(power))}"
    return f"{text} {unit}".strip()


def error(value: float | None, unit: str = "") -> str:
    """A standard error with two figures; a dash where the data do not tell it."""
    if value is None or not math.isfinite(value):
        return "–"
    return figure(float(f"{value:.2g}"), unit)


def percent(part: float) -> str:
    """A part of one; small ones keep a figure, and nothing is rounded to certainty."""
    if part > 0.995:
        return "> 99 %"
    if part < 0.005:
        return "< 1 %"
    return f"{100 * part:.0f} %"


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
