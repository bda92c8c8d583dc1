"""The verdict: one rule for every kind of evidence.

Explained is what is noise. Where the data have a noise floor it decides; where the scatter is inferred along
nothing may be left that gains enough, and nothing that is tied. A mode that was measured and that the model
lacks leaves it open in any case. Where a floor shows that the model is not there, the name of its effect
stands only if a law-free look points to the same place and class and the effect takes the larger part of the
disagreement; what remains is told as unknown beside it, at the places to which the look points besides, or
where the disagreement is largest. Where there is no floor, what was added stands beside what is left.
"""

from __future__ import annotations

from flexmodal.diagnosis.names import UNKNOWN
from flexmodal.diagnosis.outcome import Remaining, Verdict
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_thresholds import CLOSE
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.frf_words import frf_words
from flexmodal.diagnosis.verdict.modal_words import modal_words

DOUBTED = 0.01
"""Confidence of an effect below which it has to leave clearly nothing but noise to explain anything."""
BORDER = "How far the model is from the measurements lies at the border of what counts as noise."


def verdict(facts: Facts) -> Verdict:
    """Nothing is missing, something is and what, or something and nobody knows what."""
    floor = facts.over_noise is not None
    open_ = bool(facts.lacking) or facts.tied or (facts.open_ and not floor)
    explained = facts.reached > Answer.NO and not open_ and not facts.contradicted and not _doubted(facts)
    added = tuple((step.effect, step.where) for step in facts.steps)
    sure = added if explained or not floor else facts.standing
    besides = () if explained or not floor else facts.lacking_at or (facts.place,)
    effects = (*sure, *((UNKNOWN, where) for where in besides))
    undecided = (*facts.undecided, *facts.cut_off)
    if explained and facts.reached is Answer.UNDECIDED:
        undecided = (*undecided, BORDER)
    words = frf_words if facts.modal is None else modal_words
    says = " ".join(part for part in (*words(facts, explained=explained), *undecided) if part)
    share = facts.share if sure else None
    remaining = None
    if not explained and facts.over_noise is not None:
        remaining = Remaining(facts.over_noise, (*facts.lacking_at, facts.place)[0], facts.kind)
    named = effects if sure or explained else ((UNKNOWN, facts.place),)
    return Verdict(named, explained, says, undecided, share, remaining)


def _doubted(facts: Facts) -> bool:
    """Whether what leaves more than clearly nothing but noise is hardly more than impossible."""
    over = facts.over_noise
    least = min((step.confidence for step in facts.steps), default=1.0)
    return over is not None and over > CLOSE and least < DOUBTED
