"""Tables of the report, as rows of text."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Diagnosis, NextMeasurement, Region, Step, Weighed
from flexmodal.diagnosis.report.words import (
    effect_words,
    error,
    figure,
    parameter_words,
    percent,
    placed,
    plain,
    posture_words,
    size,
)
from flexmodal.structure import Parameter

_WIDE = 0.5
"""Change of a parameter, on a logarithmic scale, at which its bar ends."""


@dataclass(frozen=True)
class WeighedRow:
    """One explanation on the scales."""

    name: str
    where: str
    says: str
    parameters: str
    gap: str
    held_out: str
    score: str
    probability: str
    width: float
    """Of the bar [%]."""
    chosen: bool
    tied: bool


@dataclass(frozen=True)
class ParameterRow:
    """One parameter beside the card."""

    name: str
    card: str
    value: str
    error: str
    change: str
    left: float
    """Where the bar of its interval begins, 50 being the card [%]."""
    width: float
    place: float
    """Where the value itself is."""


@dataclass(frozen=True)
class RegionRow:
    """One region of disagreement."""

    share: str
    width: float
    kind: str
    says: str


def weighing_rows(diagnosis: Diagnosis, step: Step) -> list[WeighedRow]:
    """The step's explanation, and everything that was weighed against it."""
    words = effect_words(diagnosis)
    key = (step.effect, step.where)
    found = next((p for p in diagnosis.model.placed if p.key == key), None)
    count = "–"
    if found is not None:
        count = str(len(found.effect.parameters(diagnosis.model.context, step.where)))
    chosen = WeighedRow(
        plain(step.effect), step.where, words.get(step.effect, ""), count, size(step.gaps.after),
        size(step.gaps.held_out_after), "0", percent(step.confidence), 100 * step.confidence, True, False,
    )  # fmt: skip
    return [
        chosen,
        *(_weighed(one, words, (one.effect, one.where) in step.ties) for one in step.alternatives),
    ]


def refused_rows(diagnosis: Diagnosis) -> list[WeighedRow]:
    """What was weighed last without being added; what stays as it is counts as chosen."""
    words = effect_words(diagnosis)
    return [replace(_weighed(one, words, tied=False), chosen=one.effect == NONE) for one in diagnosis.refused]


def _weighed(one: Weighed, words: dict[str, str], tied: bool) -> WeighedRow:
    return WeighedRow(
        plain(one.effect), one.where, words.get(one.effect, ""), str(one.parameters), size(one.gap),
        size(one.held_out_gap), f"{one.evidence:.1f}".replace("-", "−"), percent(one.confidence),
        100 * one.confidence, False, tied,
    )  # fmt: skip


def region_rows(regions: tuple[Region, ...]) -> list[RegionRow]:
    """Regions, the largest first."""
    return [RegionRow(percent(one.share), 100 * one.share, one.kind, one.says) for one in regions]


def base_rows(diagnosis: Diagnosis) -> list[ParameterRow]:
    """Parameters of the robot itself beside the card."""
    space = diagnosis.model.space
    count = len(diagnosis.model.base)
    rows = []
    for parameter, x, deviation in zip(
        space.parameters[:count], diagnosis.x[:count], diagnosis.deviation[:count], strict=True
    ):
        rows.append(_beside_card(parameter, float(x), float(deviation)))
    return rows


def _beside_card(parameter: Parameter, x: float, deviation: float) -> ParameterRow:
    value = parameter.value(x)
    ratio = value / parameter.card if parameter.card else math.inf
    low, high = (_percent_of_bar(x + sign * deviation) for sign in (-1, 1))
    return ParameterRow(
        name=parameter_words(parameter.name),
        card=figure(parameter.card, parameter.unit),
        value=figure(value, parameter.unit),
        error=error(deviation * value if parameter.log else deviation, parameter.unit),
        change=f"{100 * (ratio - 1):+.1f} %".replace("-", "−") if ratio < 10 else f"× {ratio:.3g}",
        left=low,
        width=max(high - low, 0.5),
        place=_percent_of_bar(x),
    )


def _percent_of_bar(x: float) -> float:
    if not math.isfinite(x):
        return 100.0 if x > 0 else 0.0
    return 50 + 50 * min(max(x / _WIDE, -1.0), 1.0)


def effect_rows(step: Step) -> list[tuple[str, str, str]]:
    """Parameters of an effect: name, value, standard error."""
    return [
        (
            parameter_words(name),
            figure(value, step.units.get(name, "")),
            error(step.uncertainty.get(name), step.units.get(name, "")),
        )
        for name, value in step.parameters.items()
    ]


def next_words(diagnosis: Diagnosis, measurement: NextMeasurement) -> dict[str, str]:
    """What to do next, part by part."""
    context, robot = diagnosis.model.context, diagnosis.model.context.robot
    sliding = [name for name, joint in robot.commanded.items() if joint.is_prismatic]
    pairs = (explanation.partition("@")[::2] for explanation in measurement.separates)
    one, other = (placed(effect, where) for effect, where in pairs)
    sensor = context.direction(measurement.response)
    if measurement.point is not None:
        sensor = f"a new sensor at {measurement.point}, along {sensor.partition(':')[2]}"
    return {
        "one": one,
        "other": other,
        "posture": posture_words(measurement.posture, sliding),
        "sensor": sensor,
        "hammer": f"{context.direction(measurement.reference)}, about {measurement.force_peak:.3g} N",
        "expected": f"{measurement.expected:.1f}",
    }
