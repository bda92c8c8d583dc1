"""Sentences of a diagnosis from modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.identification.evidence.likelihood.errors import errors, figures
from flexmodal.identification.evidence.likelihood.shapes import ModeShapes
from flexmodal.text.words import enumeration

Key = tuple[str, str]


def named(key: Key) -> str:
    """An explanation in words."""
    effect, where = key
    if effect == UNSTRUCTURED:
        return "a mode that has no place in the robot"
    if effect == NONE:
        return "nothing added"
    return f"{effect.replace('_', ' ')} at {where}"


def hertz(modes: Sequence[tuple[int, float]]) -> str:
    """Frequencies of modes."""
    return f"{enumeration([f'{frequency:.3g}' for _, frequency in modes])} Hz"


def modal_words(facts: Facts, *, explained: bool) -> list[str]:
    """What is missing, or that nothing is; with the ties, the shapes and what is left.

    Args:
        facts: what the verdict goes by.
        explained: whether nothing is left.
    """
    found = facts.modal
    assert found is not None
    if facts.steps:
        added = (named((step.effect, step.where)) for step in facts.steps)
        why = "as asked, " if found.told else ""
        said = [f"Added, {why}{' and '.join(added)}.", _gain_words(facts, found)]
        tie = tie_words(found) if found.tied else ""
        return [missing_words(found), *said, tie, shape_words(found), left_words(found)]
    if not facts.open_:
        if found.missing:
            look = f"Nothing that was tried earns its parameters: look near {hertz(found.missing)}."
            return [missing_words(found), *facts.refused, look]
        return ["Nothing is missing that these modes could show.", missing_words(found), *facts.refused]
    head = "A mode is missing." if found.missing else "Something is missing."
    best = found.comparison.models[found.comparison.order[0]].key
    tie = tie_words(found) if found.tied else f"Best is {named(best)}."
    return [head, missing_words(found), *facts.refused, tie, shape_words(found), left_words(found)]


def _gain_words(facts: Facts, found: Findings) -> str:
    """What the first step gains over nothing added."""
    step, comparison = facts.steps[0], found.comparison
    chosen = next(
        (k for k, one in enumerate(comparison.models) if one.key == (step.effect, step.where)), None
    )
    if chosen is None:
        return ""  # found again beside another
    gained = comparison.table[chosen] - comparison.table[0]
    low, middle, high = (f"{v:.0f}".replace("-", "−") for v in (gained.min(), gained[0], gained.max()))
    what = "The first gains" if len(facts.steps) > 1 else "It gains"
    return f"{what} {middle} nats ({low} to {high} under other priors)."


def missing_words(found: Findings) -> str:
    """What the measurement has and the robot lacks."""
    before = figures(errors(found.modes.before))
    total = len(found.modes.measured.modes)
    says = (
        f"The robot re-tuned meets {total - before.missing} of the {total} measured modes"
        f" ({100 * before.frequency:.1f} % in frequency)"
    )
    if found.missing:
        says += (
            f"; the one{'s' if len(found.missing) > 1 else ''} near {hertz(found.missing)} it has no mode for"
        )
    return f"{says}."


def tie_words(found: Findings) -> str:
    """What cannot be told apart."""
    return (
        "These data cannot say what it is: under one reasonable set of priors or another, "
        f"{enumeration([named(key) for key in found.tied])} come within 5 nats of the best."
    )


def shape_words(found: Findings) -> str:
    """Why shapes do not decide; nothing where there is nothing to compare."""
    if not found.shapes or found.compared is None:
        return ""
    telling = most_telling(found.shapes)
    says_so, clean = sum(s.says for s in found.shapes), sum(s.clean for s in found.shapes)
    one, other = (named(key) for key in found.compared)
    says = (
        f"Between {one} and {other} the measured shapes say {abs(says_so):.1f} nats for the "
        f"{'first' if says_so >= 0 else 'second'}; shapes that follow one of the two, measured carefully at "
        f"the same places, would say up to {clean:.0f}."
    )
    return (
        f"{says} Most could be told by the mode near {telling.frequency:.3g} Hz, whose two predicted shapes "
        f"have a MAC of {telling.alike:.2f}; its measured shapes meet them by {telling.met[0]:.2f} and "
        f"{telling.met[1]:.2f}{_between(telling)}."
    )


def _between(shape: ModeShapes) -> str:
    return f", and each other by {shape.measured:.2f} between postures" if np.isfinite(shape.measured) else ""


def most_telling(shapes: Sequence[ModeShapes]) -> ModeShapes:
    """The mode whose predicted shapes differ most."""
    return max(shapes, key=lambda s: s.clean)


def left_words(found: Findings) -> str:
    """What is left unexplained."""
    if not found.left:
        return ""
    parts, measured = [], found.modes.measured
    for number, frequency in found.left:
        here = [m.posture for m in measured.modes if m.number == number]
        parts.append(f"near {frequency:.3g} Hz (in {len(here)} of {len(measured.postures)} postures)")
    return f"No partner is left for the peak{'s' if len(parts) > 1 else ''} {enumeration(parts)}."
