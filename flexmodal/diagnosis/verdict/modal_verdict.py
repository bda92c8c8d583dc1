"""The verdict on modes, in words."""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import NONE, UNKNOWN
from flexmodal.diagnosis.outcome import Verdict
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.decision import significant, undecided
from flexmodal.diagnosis.selection.modal_selection import ModalSelection
from flexmodal.diagnosis.selection.variants import FittedModes
from flexmodal.diagnosis.verdict.modal_words import (
    hertz,
    left_words,
    missing_words,
    named,
    shape_words,
    tie_words,
)

EVERYWHERE = "arm"
"""Where something sits that cannot be placed."""


def verdict(selection: ModalSelection, found: Findings) -> Verdict:
    """Nothing is missing, something is and what, or something and nobody knows what.

    Args:
        selection: after its run.
        found: what came of it.
    """
    first = selection.rounds[0]
    comparison, chosen = first.comparison, first.chosen
    added = [(step.effect, step.where) for step in selection.steps]
    says = [missing_words(found)]
    if chosen is not None:
        why = "as asked, " if found.told else ""
        says.append(f"Added, {why}{' and '.join(named(key) for key in added)}.")
        gained = comparison.table[chosen] - comparison.table[0]
        low, middle, high = (f"{v:.0f}".replace("-", "−") for v in (gained.min(), gained[0], gained.max()))
        what = "The first gains" if len(added) > 1 else "It gains"
        says.append(f"{what} {middle} nats ({low} to {high} under other priors).")
        if found.tied:
            says.append(tie_words(found))
        says += [shape_words(found), left_words(found)]
        return Verdict(tuple(added), not found.left and not found.tied, _joined(says))
    says += _refused(selection, comparison)
    if not significant(comparison):
        if found.missing:
            says.append(f"Nothing that was tried earns its parameters: look near {hertz(found.missing)}.")
            return Verdict(((UNKNOWN, _place(found)),), False, _joined(says))
        return Verdict((), True, _joined(["Nothing is missing that these modes could show.", *says]))
    says = ["A mode is missing." if found.missing else "Something is missing.", *says]
    says.append(
        tie_words(found) if found.tied else f"Best is {named(comparison.models[comparison.order[0]].key)}."
    )
    says += [shape_words(found), left_words(found)]
    return Verdict(((UNKNOWN, _place(found)),), False, _joined(says))


def _refused(selection: ModalSelection, comparison: Comparison[FittedModes]) -> list[str]:
    """Why what was asked for by its place was not added."""
    if selection.asked is None:
        return []
    said = []
    for k in comparison.order:
        name, where = comparison.models[k].key
        if k and where in selection.asked.get(name, ()):
            gain = comparison.first_gain(k)
            gained = f"{gain:.0f}".replace("-", "−")
            what = "which leaves it undecided" if undecided(gain) else "which is a tie with nothing added"
            said.append(f"Asked for, {named((name, where))} gains {gained} nats, {what}.")
    return said


def _joined(parts: Sequence[str]) -> str:
    return " ".join(part for part in parts if part)


def _place(found: Findings) -> str:
    """The one place that everything tied points at; the arm as a whole where there is none."""
    places = {where for effect, where in found.tied or (found.after.model.key,) if effect != NONE}
    return places.pop() or EVERYWHERE if len(places) == 1 else EVERYWHERE
