"""The parts of the page that FRFs have."""

from __future__ import annotations

import math
from functools import partial

from flexmodal.diagnosis.findings import ModesSeen
from flexmodal.diagnosis.names import UNKNOWN
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.arm_picture import draw_arm
from flexmodal.diagnosis.report.free_look import look_parts
from flexmodal.diagnosis.report.joint_pictures import joint_parts
from flexmodal.diagnosis.report.modal_pictures import RETUNED, draw_frequencies
from flexmodal.diagnosis.report.modal_tables import SUMMARY, mode_table, summary_rows
from flexmodal.diagnosis.report.pictures import draw_descent, draw_map, draw_pair, telling_rows
from flexmodal.diagnosis.report.tables import comparison_table, refused, regions, remaining
from flexmodal.diagnosis.report.words import effect_words, held_out, pair, placed, posture_name
from flexmodal.identification.page import BESIDE, BESIDE_NOTE, baseline_cells
from flexmodal.report import (
    Gallery,
    Heading,
    Items,
    Legend,
    Part,
    Parts,
    Picture,
    Section,
    Table,
    Text,
    columns,
)
from flexmodal.report.words import percent, size, times_noise
from flexmodal.text.words import enumeration

_ARM = "Joints are rings, sensors diamonds; what the verdict names is orange."
_BOTH = (
    "The modes that were measured too. Models are fitted to the FRFs; how probable they make these modes "
    "counts in every comparison. The gap of modes is the root mean square of relative errors of natural "
    "frequency, of a tenth of those of damping ratios, and of 1 − MAC; a mode that the model lacks counts as "
    "1, 0.1 and 1."
)
_EVIDENCE = (
    "Adds: how many parameters the explanation has of its own; each costs. Evidence: the logarithm of how "
    "probable it makes the measurements, postures held out included, over that of the best. It is counted in "
    "nats: one is a factor of 2.7 in the odds, five are odds of 150 to 1. Probabilities come from drawing "
    "the measurements anew; they are among what was compared."
)
WHY = "measure where the two models differ most, about {:.1f} times what noise and unsure parameters make:"
NO_PAIR = (
    "No two explanations are left to be told apart; look at the place that the verdict names, and at the "
    "records above that it does not explain."
)


def frf_sections(diagnosis: Diagnosis) -> list[Section]:
    """Where the models disagree, on which FRFs, what was compared, and how the gap came down."""
    look = [] if diagnosis.look is None else [Section("Without a law", look_parts(diagnosis.look))]
    return [
        Section("Where they disagree", _disagreement(diagnosis)),
        *look,
        Section("Measured and modelled", _pairs(diagnosis)),
        *([] if diagnosis.modes is None else [Section("Modes", _modes(diagnosis, diagnosis.modes))]),
        *([Section("In the joints", joints)] if (joints := joint_parts(diagnosis)) else []),
        Section("What was compared", _compared(diagnosis)),
        Section("How the gap came down", _left(diagnosis)),
    ]


def frf_headline(diagnosis: Diagnosis) -> str:
    """The verdict in a line."""
    names = [placed(effect, where) for effect, where in diagnosis.verdict.effects if effect != UNKNOWN]
    head = f"Missing: {enumeration(names)}" if names else "Nothing is missing"
    if not diagnosis.verdict.explained and not names:
        late = diagnosis.verdict.cut_off
        head = f"Something is missing that {'has no name yet' if late else 'the catalogue does not know'}"
    return head


def frf_paragraphs(diagnosis: Diagnosis) -> list[Text]:
    """The verdict's sentences, how sure it is, and its ties."""
    says = [Text(diagnosis.verdict.says)]
    if diagnosis.steps:
        least = percent(min(step.confidence for step in diagnosis.steps))
        says.append(Text(f"Confidence {least}{' of the less certain one' * (len(diagnosis.steps) > 1)}."))
    for step in diagnosis.steps:
        if step.ties:
            others = ", ".join(placed(*tie) for tie in step.ties)
            name = placed(step.effect, step.where)
            says.append(Text(f"These data cannot tell {name} from {others}.", tag="a tie"))
    return says


def frf_figures(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """The gaps, large."""
    gaps = diagnosis.gaps
    found = [
        ("gap of the card as it came", size(gaps.believed), ""),
        ("re-tuned, nothing added", size(gaps.before), held_out(gaps.held_out_before)),
    ]
    if diagnosis.model.placed:
        found.append((_after(diagnosis), size(gaps.after), held_out(gaps.held_out_after)))
    leaves = times_noise(math.nan if diagnosis.over_noise is None else diagnosis.over_noise)
    return [*found, ("noise floor", size(gaps.noise_floor), f"the model leaves {leaves}")]


def frf_note(diagnosis: Diagnosis) -> Text:
    """What the gap is, and what was held out."""
    held = [posture_name(diagnosis.observations, number) for number in diagnosis.held_out]
    last = "No posture was held out."
    if held:
        last = f"Held out: {', '.join(held)}, which no fit of these figures saw."
    return Text(
        "The gap between model and measurement: 0.1 means that on a typical line of an FRF they differ by "
        "about 10 % in size or 6° in phase. The noise floor is the gap that the noise of one record alone "
        f"makes: no model can come nearer. {last}",
        note=True,
    )


def _after(diagnosis: Diagnosis) -> str:
    return "with what was added" if diagnosis.steps else "with the best that was tried"


def _disagreement(diagnosis: Diagnosis) -> Parts:
    parts: list[Part | str] = [
        "Re-tuned, the robot is nowhere further from the measurements than their noise."
    ]
    if diagnosis.disagreement:
        parts = [
            "The robot re-tuned, nothing added, leaves this above the noise:",
            regions(diagnosis.disagreement),
        ]
    maps = {"before": "Re-tuned, nothing added"}
    if diagnosis.model.placed:
        maps["after"] = "With what was added"
    pictures = [
        Picture(partial(draw_map, diagnosis, stage, title), f"Disagreement by posture and frequency: {title}")
        for stage, title in maps.items()
    ]
    arm = Picture(partial(draw_arm, diagnosis), "The arm, with the place marked", _ARM)
    note = "The maps show the disagreement as a multiple of the noise, over all FRFs of a posture."
    held = " * held out." if diagnosis.held_out else ""
    return [*parts, Gallery([*pictures, arm]), Text(note + held, note=True)]


def _pairs(diagnosis: Diagnosis) -> Parts:
    says = (
        "The FRFs that disagreed most. Below each, how far the models are from it, beside twice its noise."
        + " Where the list above names them, the band is shaded." * bool(diagnosis.disagreement)
    )
    names = {"measured": "measured", "noise": "noise, ±2σ", "before": "model re-tuned, nothing added"}
    if diagnosis.model.placed:
        names["after"] = _after(diagnosis)
    pictures = [
        Picture(partial(draw_pair, diagnosis, row), f"FRF {pair(diagnosis.observations, row)}")
        for row in telling_rows(diagnosis)
    ]
    return [says, Legend(names), Gallery(pictures)]


def _modes(diagnosis: Diagnosis, found: ModesSeen) -> Parts:
    name = _after(diagnosis) if diagnosis.model.placed else RETUNED
    picture = Picture(partial(draw_frequencies, found, name), "Natural frequencies by posture")
    return [_BOTH, picture, Table(SUMMARY, summary_rows(found, name)), mode_table(found, name)]


def _compared(diagnosis: Diagnosis) -> Parts:
    words, parts = effect_words(diagnosis), list[Part | str]()
    for number, step in enumerate(diagnosis.steps, start=1):
        head = f"{number}. {placed(step.effect, step.where)}: {words.get(step.effect, '')}"
        parts += [Heading(head), comparison_table(diagnosis, step)]
    if not diagnosis.steps:
        more = "" if diagnosis.verdict.explained else ", or what was added does not explain the measurements"
        parts.append(f"Nothing that was tried gained enough to be added{more}.")
    if diagnosis.refused:
        start = "Then, on top of that" if diagnosis.steps else "Nothing added"
        parts += [Heading(f"{start}: what else was tried did not gain enough"), refused(diagnosis)]
    return [*parts, Text(_EVIDENCE, note=True)] if diagnosis.steps or diagnosis.refused else parts


def _left(diagnosis: Diagnosis) -> Parts:
    left = remaining(diagnosis.remaining)
    descent = Picture(partial(draw_descent, diagnosis), "The gap step by step above the noise floor")
    parts: list[Part | str] = [Gallery([descent])]
    beside = diagnosis.baselines
    if beside is not None:
        table = Table(columns(BESIDE, words=["which"]), baseline_cells(beside))
        parts += [f"Beside what needs no model: {beside.verdict}.", table, Text(BESIDE_NOTE, note=True)]
    if not left:
        return [*parts, "Nothing that is left stands out of the noise."]
    places = f"{len(left)} place{'s' * (len(left) != 1)}"
    return [*parts, f"What is left stands out of the noise in {places}:", Items(left[:6])]
