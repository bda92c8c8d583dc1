"""Tables of the report, and what to do next."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flexmodal.campaign import named_direction
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Compared, Diagnosis, NextMeasurement, Region, Step
from flexmodal.diagnosis.report.words import effect_words, parameter_words, placed, plain, posture_words
from flexmodal.report import Cell, Column, Facts, Heading, Part, Table, Task
from flexmodal.report.words import error, figure, fixed, minus, percent, size
from flexmodal.structure import Parameter

_WIDE = 0.5
"""Change of a parameter, on a logarithmic scale, at which its bar ends."""
COMPARISON = (
    Column("explanation", words=True), Column("place", words=True), Column("adds"), Column("gap"),
    Column("held out"), Column("evidence", "nat"), Column("probability", words=True),
)  # fmt: skip


def comparison_table(diagnosis: Diagnosis, step: Step) -> Table:
    """The step's explanation, and everything that was compared against it."""
    words = effect_words(diagnosis)
    found = next((p for p in diagnosis.model.placed if p.key == (step.effect, step.where)), None)
    count = "–"
    if found is not None:
        count = str(len(found.effect.parameters(diagnosis.model.context, step.where)))
    chosen: list[str | Cell] = [
        Cell(plain(step.effect), note=words.get(step.effect, "")), step.where or "–", count,
        size(step.gaps.after), size(step.gaps.held_out_after), "0",
        Cell(percent(step.confidence), bar=step.confidence),
    ]  # fmt: skip
    others = [_compared(one, words, (one.effect, one.where) in step.ties) for one in step.alternatives]
    return Table(COMPARISON, [chosen, *others], chosen=frozenset({0}))


def refused(diagnosis: Diagnosis) -> Table:
    """What was compared last without being added; what stays as it is counts as chosen."""
    words = effect_words(diagnosis)
    rows = [_compared(one, words, tied=False) for one in diagnosis.refused]
    kept = frozenset(k for k, one in enumerate(diagnosis.refused) if one.effect == NONE)
    return Table(COMPARISON, rows, chosen=kept)


def _compared(one: Compared, words: dict[str, str], tied: bool) -> list[str | Cell]:
    return [
        Cell(plain(one.effect), note=words.get(one.effect, ""), tag="tie" if tied else ""), one.where or "–",
        str(one.parameters), size(one.gap), size(one.held_out_gap), fixed(one.evidence, 1),
        Cell(percent(one.confidence), bar=one.confidence),
    ]  # fmt: skip


def regions(found: Sequence[Region]) -> Table:
    """Regions, the largest first."""
    names = (
        Column("share", words=True),
        Column("kind", words=True),
        Column("what an engineer sees", words=True),
    )
    rows: list[list[str | Cell]] = [
        [Cell(percent(one.share), bar=one.share), one.kind, one.says] for one in found
    ]
    return Table(names, rows)


def remaining(found: Sequence[Region]) -> list[str]:
    """Regions that are left, as sentences."""
    return [f"{one.says} ({percent(one.share)} of the rest)" for one in found]


def parameters(diagnosis: Diagnosis) -> list[Part]:
    """What was added, step by step, and the robot itself beside its card."""
    parts: list[Part] = []
    for step in diagnosis.steps:
        named = (Column("parameter", words=True), Column("value"), Column("± standard error"))
        parts += [Heading(placed(step.effect, step.where)), Table(named, _of_effect(step))]
    return [*parts, Heading("The robot itself, beside its card"), beside_card(diagnosis)]


def beside_card(diagnosis: Diagnosis) -> Table:
    """Parameters of the robot itself beside the card."""
    space, count = diagnosis.model.space, len(diagnosis.model.base)
    found = zip(space.parameters[:count], diagnosis.x[:count], diagnosis.deviation[:count], strict=True)
    names = (
        Column("parameter", words=True), Column("card"), Column("now"), Column("± standard error"),
        Column("change"), Column("−40 % … card … +65 %", words=True),
    )  # fmt: skip
    return Table(names, [_row(parameter, float(x), float(deviation)) for parameter, x, deviation in found])


def _row(parameter: Parameter, x: float, deviation: float) -> list[str | Cell]:
    value = parameter.value(x)
    ratio = value / parameter.card if parameter.card else math.inf
    low, middle, high = ((x + sign * deviation) / _WIDE if math.isfinite(deviation) or not sign else sign
                         for sign in (-1, 0, 1))  # fmt: skip
    return [
        parameter_words(parameter.name),
        figure(parameter.card, parameter.unit),
        figure(value, parameter.unit),
        error(deviation * value if parameter.log else deviation, parameter.unit),
        minus(f"{100 * (ratio - 1):+.1f} %") if ratio < 10 else f"× {ratio:.3g}",
        Cell("", interval=(low, middle, high)),
    ]


def _of_effect(step: Step) -> list[list[str]]:
    """Name, value and standard error of each parameter of an effect."""
    return [
        [
            parameter_words(name),
            figure(value, step.units.get(name, "")),
            error(step.uncertainty.get(name), step.units.get(name, "")),
        ]
        for name, value in step.parameters.items()
    ]


def next_task(diagnosis: Diagnosis, measurement: NextMeasurement, why: str) -> Task:
    """What to measure next, part by part; `why` comes before how far the two models differ there."""
    context = diagnosis.model.context
    sliding = [name for name, joint in context.robot.commanded.items() if joint.is_prismatic]
    one, other = (placed(*found.partition("@")[::2]) for found in measurement.separates)
    sensor, hammer = (
        _direction(context, measurement, at) for at in (measurement.response, measurement.reference)
    )
    if measurement.point is not None:
        sensor = f"a new sensor at {measurement.point}, along {sensor.partition(':')[2]}"
    hammer = f"{hammer}, about {measurement.force_peak:.3g} N"
    says = f"To tell {one} from {other}, {why.format(measurement.expected)}"
    posture = posture_words(measurement.posture, sliding)
    more = {}
    if measurement.locked:
        more["locked, link to link"] = ", ".join(measurement.locked)
    if measurement.masses:
        more["bolted on"] = ", ".join(f"{mass:.3g} kg at {name}" for name, mass in measurement.masses.items())
    return Task(says, Facts({"posture": posture, **more, "hammer": hammer, "sensor": sensor}))


def _direction(context: Context, measurement: NextMeasurement, place: tuple[int, int]) -> str:
    """A place by name, one of the card's that the campaign has not used among them."""
    name = measurement.new_points.get(place[0])
    return (
        context.direction(place)
        if name is None
        else f"{named_direction(place, {place[0]: name})}, a new point"
    )
