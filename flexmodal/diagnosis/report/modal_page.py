"""The report of a diagnosis from modes alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Diagnosis, Region
from flexmodal.diagnosis.report.arm_picture import draw_arm
from flexmodal.diagnosis.report.modal_pictures import draw_evidence, draw_frequencies, draw_shapes, short
from flexmodal.diagnosis.report.modal_tables import (
    SHAPES,
    SUMMARY,
    WEIGHING,
    mode_table,
    shape_rows,
    summary_rows,
    weighing_rows,
)
from flexmodal.diagnosis.report.pictures import draw_descent
from flexmodal.diagnosis.report.tables import next_task, parameters
from flexmodal.diagnosis.report.words import held_out, not_testable, placed, state
from flexmodal.diagnosis.selection.variants import VARIANTS
from flexmodal.diagnosis.verdict.modal_words import left_words, named, shape_words, tie_words
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.report import (
    Facts,
    Gallery,
    Items,
    Part,
    Parts,
    Picture,
    Section,
    Table,
    Text,
    Verdict,
    page_text,
)
from flexmodal.report.words import percent, size
from flexmodal.text.words import enumeration

_GAP = (
    "The gap is the root mean square of relative errors of natural frequency, of a tenth of those of damping "
    "ratios, and of 1 − MAC; a measured mode that the model lacks counts as 1, 0.1 and 1. The scatter over "
    "places, in the place of a noise floor, is how much one mode differs from one sensor to the next. Held "
    "out: "
)
_MEANS = (
    "Root mean squares over the modes that have a partner; the mean of the other postures has one for every "
    "mode that they have, and no reason for any of them."
)
_EVIDENCE = (
    "Evidence is the logarithm of how probable an explanation makes these modes, over nothing added; "
    "Laplace's, over parameters and scales of the scatter. It is counted in nats: one is a factor of 2.7 in "
    "the odds, five are odds of 150 to 1. Held out: the logarithm of the predictive density of postures not "
    "fitted, over that of nothing added. Within 5 nats of the best under any of these sets of beliefs is a "
    "tie: {}. Probabilities are means over them, among what was weighed."
)
_SHAPES = (
    "MAC, means over postures. As measured: what the shapes say for the first explanation. If careful: what "
    "shapes that follow one of the two would say, measured so that their MAC with the truth is 0.95."
)


def modal_text(diagnosis: Diagnosis, notes: Sequence[str] = ()) -> str:
    """The page as text."""
    found = diagnosis.modal
    assert found is not None
    name = after_name(diagnosis, found)
    held = (
        "the postures named for it."
        if diagnosis.held_out
        else "each posture in turn, predicted by the others."
    )
    sections = [
        Section("Frequencies, measured and modelled", _frequencies(diagnosis, found, name)),
        Section("Where they disagree", _disagreement(diagnosis)),
        Section("What was weighed", _weighed(diagnosis, found)),
        Section("What the shapes say", _shapes(found)),
        Section("What to measure next", _next(diagnosis, found)),
        Section("Mode by mode", [mode_table(found, name)]),
        Section("Parameters", parameters(diagnosis)),
        Section("What this does not say", [Items(_not_said(diagnosis, notes))]),
        Section("Where it comes from", [Facts(diagnosis.provenance)]),
    ]
    title = f"Diagnosis, from modes alone, of “{diagnosis.campaign}” with the robot {diagnosis.robot}"
    return page_text(title, [_verdict(diagnosis, found), Text(_GAP + held, note=True)], sections)


def _verdict(diagnosis: Diagnosis, found: Findings) -> Verdict:
    gaps = diagnosis.gaps
    figures = [("re-tuned, nothing added", size(gaps.before), held_out(gaps.held_out_before))]
    if gaps.believed is not None:
        figures.insert(0, ("gap of the card as it came", size(gaps.believed), ""))
    if diagnosis.steps:
        figures.append(("with what was added", size(gaps.after), held_out(gaps.held_out_after)))
    figures.append(("scatter over places", size(gaps.noise_floor), ""))
    says = verdict_paragraphs(diagnosis, found)
    return Verdict(state(diagnosis), headline(diagnosis, found), says, figures)


def _frequencies(diagnosis: Diagnosis, found: Findings, name: str) -> Parts:
    frequencies = Picture(partial(draw_frequencies, found, name), "Natural frequencies by posture")
    arm = Picture(partial(draw_arm, diagnosis), "The arm with its points")
    table = Table(SUMMARY, summary_rows(found, name))
    return [Gallery([frequencies, arm]), table, Text(_MEANS, note=True)]


def _disagreement(diagnosis: Diagnosis) -> Parts:
    def items(regions: Sequence[Region]) -> Items:
        return Items([f"{one.says} ({one.kind}, {percent(one.share)})" for one in regions])

    if not diagnosis.disagreement:
        return ["Nowhere by more than the scatter."]
    before: list[Part | str] = ["The robot re-tuned, nothing added:", items(diagnosis.disagreement)]
    if not (diagnosis.steps and diagnosis.remaining):
        return before
    return [*before, "With what was added:", items(diagnosis.remaining)]


def _weighed(diagnosis: Diagnosis, found: Findings) -> Parts:
    pictures = []
    if len(found.comparison.models) > 1:
        pictures.append(Picture(partial(draw_evidence, found), "Evidence of each explanation"))
    if diagnosis.steps:
        pictures.append(Picture(partial(draw_descent, diagnosis), "The gap step by step"))
    note = _EVIDENCE.format("; ".join(variant.name for variant in VARIANTS))
    return [Gallery(pictures), Table(WEIGHING, weighing_rows(found)), Text(note, note=True)]


def _shapes(found: Findings) -> Parts:
    pair, rows = compared_fits(found), shape_rows(found)
    if pair is None or found.compared is None or not rows:
        return ["There are no two explanations with a structure to be compared."]
    one, other = (named(key) for key in found.compared)
    picture = Picture(partial(draw_shapes, found, *pair), "Measured and predicted shapes")
    says = f"{one} against {other}, at the places that were measured:"
    return [says[:1].upper() + says[1:], picture, Table(SHAPES, rows), Text(_SHAPES, note=True)]


def _next(diagnosis: Diagnosis, found: Findings) -> Parts:
    if diagnosis.next_measurement is not None:
        why = (
            "measure an FRF where the two models differ most: {:.1f} times what noise and unsure parameters "
            "would make of it, line by line."
        )
        return [
            next_task(diagnosis, diagnosis.next_measurement, why),
            "And shapes of the modes above, at all places in one run, with the sensors' directions written "
            "down: modes have no direction in modes.csv, and the vertical is assumed.",
        ]
    if found.tied:
        return [
            "FRFs, rather than modes fitted to them: a mode without structure makes no prediction that a "
            "measurement could rule out, but an explanation with structure does."
        ]
    return ["No second explanation is left that another measurement would have to rule out."]


def _not_said(diagnosis: Diagnosis, notes: Sequence[str]) -> list[str]:
    return [
        *not_testable(diagnosis),
        *(f"{one}." for one in diagnosis.left_out),
        *(f"In the improved robot: {note}." for note in notes),
        "What could not be tested may be there all the same.",
        "Sizes of residues were not used: they hang on how hard and how straight the hammer fell.",
    ]


def headline(diagnosis: Diagnosis, found: Findings) -> str:
    """The verdict in a line."""
    if diagnosis.steps:
        names = enumeration([placed(s.effect, s.where) for s in diagnosis.steps])
        return f"{'Added as asked, not decided' if found.tied else 'Missing'}: {names}"
    if diagnosis.verdict.explained:
        return "Nothing is missing that these modes could show"
    if not found.missing:
        return "Something is missing; these modes do not say what"
    return "A mode is missing; these data do not say what makes it"


def verdict_paragraphs(diagnosis: Diagnosis, found: Findings) -> list[Text]:
    """The verdict's sentences by what they are of: the gap, the ties, the shapes, what is left."""
    says = diagnosis.verdict.says
    tie = tie_words(found) if found.tied else ""
    for part in filter(None, (tie, shape_words(found), left_words(found))):
        says = says.replace(part, f"\n{part}\n")
    parts = [one.strip() for one in says.split("\n")]
    return [Text(one, tag="a tie" if one == tie else "") for one in parts if one]


def after_name(diagnosis: Diagnosis, found: Findings) -> str:
    """What the second model of the pictures is."""
    name = short(found.after.model.key)
    if found.after.model.key[0] == NONE:
        return "re-tuned"
    if diagnosis.steps:
        return f"with {enumeration([placed(s.effect, s.where) for s in diagnosis.steps])}"
    return f"best of what is tied: {name}"


def compared_fits(found: Findings) -> tuple[ModalFit, ModalFit] | None:
    """The two explanations whose shapes are compared."""
    if found.compared is None:
        return None
    table = {one.key: one.fit for one in found.comparison.models}
    return table[found.compared[0]], table[found.compared[1]]
