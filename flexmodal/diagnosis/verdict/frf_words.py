"""Sentences of a verdict on FRFs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.report.words import percent, times_noise
from flexmodal.text.words import enumeration


def frf_words(facts: Facts, *, explained: bool) -> list[str]:
    """Nothing is missing, something of the catalogue is, or something else.

    Args:
        facts: what the verdict goes by.
        explained: whether what is left is noise.
    """
    reached = times_noise(facts.over_noise or math.nan)
    silent = f"Of {', '.join(facts.untestable)} these data cannot tell." if facts.untestable else ""
    look = "" if facts.look is None else facts.look.says
    if not explained and facts.standing:
        return [_partly(facts), look, *facts.refused, silent]
    if not explained and facts.contradicted:
        return [_contradicted(facts), look, *facts.refused, silent]
    if not explained:
        return [_unknown(facts), look, *facts.refused, silent]
    if not facts.steps:
        fits = f"Nothing is missing: re-tuned, the robot meets the data to {reached}."
        return [fits, *facts.refused, silent]
    words = " and ".join(f"{facts.says[step.effect]} ({step.where})" for step in facts.steps)
    tied = [_named(*tie) for step in facts.steps for tie in step.ties]
    tail = f"These data cannot tell it from {', '.join(tied)}." if tied else ""
    return [f"Missing: {words}.", tail, f"With it the model meets the data to {reached}.", *facts.refused]


def stand_in_words(effects: Sequence[tuple[str, str]], gaps: Gaps) -> str:
    """What stands in the improved robot for something that has no name.

    Args:
        effects: names and places.
        gaps: with them.
    """
    names = enumeration([f"{effect} at {where}" for effect, where in effects])
    stands = "stands" if len(effects) == 1 else "stand"
    words = f"In the improved robot {names} {stands} for it, without being named"
    if gaps.held_out_before is None or gaps.held_out_after is None:
        return f"{words}."
    return (
        f"{words}: on postures that no fit has seen the gap goes from {gaps.held_out_before:.3g} to "
        f"{gaps.held_out_after:.3g}."
    )


def _partly(facts: Facts) -> str:
    names = enumeration([f"{facts.says[effect]} ({where})" for effect, where in facts.standing])
    one = len(facts.standing) == 1
    reached = times_noise(facts.over_noise or math.nan)
    if facts.told:
        how = "So says its function" if one else "So say their functions"
        return (
            f"Missing: {names}. {how} without a law, with which everything is explained. By the "
            f"catalogue's law{'' if one else 's'} {'it takes' if one else 'they take'} "
            f"{percent(max(facts.share or 0.0, 0.0))} of the disagreement; the model leaves {reached}."
        )
    why = f"for {'its law is' if one else 'their laws are'} not quite the catalogue's"
    if facts.lacking_at and set(facts.lacking_at) <= {where for _, where in facts.standing}:
        why += f", or something is missing besides at {enumeration(list(facts.lacking_at))}"
    elif facts.lacking_at:
        why = (
            f"for something is missing besides {_nameless(facts)}: look at "
            f"{enumeration(list(facts.lacking_at))}"
        )
    return (
        f"Missing: {names}. {'It takes' if one else 'They take'} {percent(facts.share or 0.0)} of the "
        f"disagreement; the model leaves {reached}, {why}."
    )


def _contradicted(facts: Facts) -> str:
    names = enumeration([f"{step.effect} at {step.where}" for step in facts.steps])
    return (
        f"Something is missing that no single effect of the catalogue explains. {names} together would leave "
        f"{times_noise(facts.over_noise or math.nan)}, but one place alone explains as much, and none of "
        f"them sits there: look at {facts.place}."
    )


def _unknown(facts: Facts) -> str:
    near, strange = "", [one.key for one in facts.unlike]
    if facts.steps and (last := facts.steps[-1]) and (last.effect, last.where) not in strange:
        near = f" Nearest comes {last.effect} at {last.where}, which is not enough."
    modes = ""
    if facts.lacking:
        frequencies = enumeration([f"{frequency:.3g}" for frequency in facts.lacking.values()])
        modes = f" It has no mode for those measured near {frequencies} Hz."
    return (
        f"Something is missing {_nameless(facts)}: the model leaves "
        f"{times_noise(facts.over_noise or math.nan)}.{modes} "
        f"Look at {facts.place}.{near}"
    )


def _nameless(facts: Facts) -> str:
    return "that was not named in time" if facts.cut_off else "that nothing in the catalogue explains"


def _named(effect: str, where: str) -> str:
    """A tied explanation in words."""
    plain = {NONE: "nothing added", UNSTRUCTURED: "a mode with no structure"}
    return plain.get(effect, f"{effect} at {where}")
