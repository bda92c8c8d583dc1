"""The parts of the page that modes have."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Diagnosis, Region
from flexmodal.diagnosis.report.arm_picture import draw_arm
from flexmodal.diagnosis.report.modal_pictures import (
    RETUNED,
    draw_evidence,
    draw_frequencies,
    draw_shapes,
    short,
)
from flexmodal.diagnosis.report.modal_tables import (
    COMPARISON,
    SHAPES,
    SUMMARY,
    comparison_rows,
    mode_table,
    shape_rows,
    summary_rows,
)
from flexmodal.diagnosis.report.pictures import draw_descent
from flexmodal.diagnosis.report.words import held_out, placed
from flexmodal.diagnosis.selection.variants import VARIANTS
from flexmodal.diagnosis.verdict.modal_words import left_words, named, shape_words, tie_words
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.report import (
    Gallery,
    Items,
    Part,
    Parts,
    Picture,
    Section,
    Table,
    Text,
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
    "tie: {}. Probabilities are means over them, among what was compared."
)
WHY = (
    "measure an FRF where the two models differ most: {:.1f} times what noise and unsure parameters would "
    "make of it, line by line."
)
SHAPES_TOO = (
    "And shapes of the modes above, at all places in one run, with the sensors' directions written down: "
    "modes have no direction in modes.csv, and the vertical is assumed."
)
NO_PAIR = (
    "FRFs, rather than modes fitted to them: a mode without structure makes no prediction that a measurement "
    "could rule out, but an explanation with structure does."
)
SIZES = "Sizes of residues were not used: they hang on how hard and how straight the hammer fell."
_SHAPES = (
    "MAC, means over postures. As measured: what the shapes say for the first explanation. If careful: what "
    "shapes that follow one of the two would say, measured so that their MAC with the truth is 0.95."
)


def _frequencies(diagnosis: Diagnosis, found: Findings, name: str) -> Parts:
    frequencies = Picture(partial(draw_frequencies, found.modes, name), "Natural frequencies by posture")
    arm = Picture(partial(draw_arm, diagnosis), "The arm with its points")
    table = Table(SUMMARY, summary_rows(found.modes, name))
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


def _compared(diagnosis: Diagnosis, found: Findings) -> Parts:
    pictures = []
    if len(found.comparison.models) > 1:
        pictures.append(Picture(partial(draw_evidence, found), "Evidence of each explanation"))
    if diagnosis.steps:
        pictures.append(Picture(partial(draw_descent, diagnosis), "The gap step by step"))
    note = _EVIDENCE.format("; ".join(variant.name for variant in VARIANTS))
    return [Gallery(pictures), Table(COMPARISON, comparison_rows(found)), Text(note, note=True)]


def _shapes(found: Findings) -> Parts:
    pair, rows = compared_fits(found), shape_rows(found)
    if pair is None or found.compared is None or not rows:
        return ["There are no two explanations with a structure to be compared."]
    one, other = (named(key) for key in found.compared)
    picture = Picture(partial(draw_shapes, found, *pair), "Measured and predicted shapes")
    says = f"{one} against {other}, at the places that were measured:"
    return [says[:1].upper() + says[1:], picture, Table(SHAPES, rows), Text(_SHAPES, note=True)]


def modal_sections(diagnosis: Diagnosis, found: Findings) -> list[Section]:
    """Frequencies, where they disagree, what was compared, what the shapes say, and mode by mode.

    Args:
        diagnosis: what was found.
        found: what of it the modes say.
    """
    name = after_name(diagnosis, found)
    return [
        Section("Frequencies, measured and modelled", _frequencies(diagnosis, found, name)),
        Section("Where they disagree", _disagreement(diagnosis)),
        Section("What was compared", _compared(diagnosis, found)),
        Section("What the shapes say", _shapes(found)),
        Section("Mode by mode", [mode_table(found.modes, name)]),
    ]


def modal_figures(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """The gaps, large."""
    gaps = diagnosis.gaps
    figures = [("re-tuned, nothing added", size(gaps.before), held_out(gaps.held_out_before))]
    if gaps.believed is not None:
        figures.insert(0, ("gap of the card as it came", size(gaps.believed), ""))
    if diagnosis.steps:
        figures.append(("with what was added", size(gaps.after), held_out(gaps.held_out_after)))
    return [*figures, ("scatter over places", size(gaps.noise_floor), "")]


def modal_note(diagnosis: Diagnosis) -> Text:
    """What the gap is, and what was held out."""
    each = "each posture in turn, predicted by the others."
    return Text(_GAP + ("the postures named for it." if diagnosis.held_out else each), note=True)


def modal_headline(diagnosis: Diagnosis, found: Findings) -> str:
    """The verdict in a line."""
    if diagnosis.steps:
        names = enumeration([placed(s.effect, s.where) for s in diagnosis.steps])
        return f"{'Added as asked, not decided' if found.tied else 'Missing'}: {names}"
    if diagnosis.verdict.explained:
        return "Nothing is missing that these modes could show"
    if not found.missing:
        return "Something is missing; these modes do not say what"
    return "A mode is missing; these data do not say what makes it"


def modal_paragraphs(diagnosis: Diagnosis, found: Findings) -> list[Text]:
    """The verdict's sentences by what they are of: the gap, the ties, the shapes, what is left."""
    says = diagnosis.verdict.says
    tie = tie_words(found) if found.tied else ""
    for part in filter(None, (tie, shape_words(found), left_words(found))):
        says = says.replace(part, f"\n{part}\n")
    parts = [one.strip() for one in says.split("\n")]
    return [Text(one, tag="a tie" if one == tie else "") for one in parts if one]


def after_name(diagnosis: Diagnosis, found: Findings) -> str:
    """What the second model of the pictures is."""
    name = short(found.modes.after.model.key)
    if found.modes.after.model.key[0] == NONE:
        return RETUNED
    if diagnosis.steps:
        return f"with {enumeration([placed(s.effect, s.where) for s in diagnosis.steps])}"
    return f"best of what is tied: {name}"


def compared_fits(found: Findings) -> tuple[ModalFit, ModalFit] | None:
    """The two explanations whose shapes are compared."""
    if found.compared is None:
        return None
    table = {one.key: one.fit for one in found.comparison.models}
    return table[found.compared[0]], table[found.compared[1]]
