"""From a forward selection to a diagnosis: gaps, verdict, steps, the next measurement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Complex

from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import UNKNOWN, UNSTRUCTURED
from flexmodal.diagnosis.next_measurement.contenders import contenders
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.selection.comparison import M
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.decision import Answer, any_gains
from flexmodal.diagnosis.selection.described import as_found_last
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.selection import ForwardSelection
from flexmodal.diagnosis.verdict.beyond import beyond_words
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.frf_words import stand_in_words
from flexmodal.diagnosis.verdict.undecided import refused_words, undecided_words
from flexmodal.diagnosis.verdict.unlike import unlike
from flexmodal.diagnosis.verdict.verdict import verdict
from flexmodal.identification.setting_up import far_words


def diagnosis_of(
    selection: ForwardSelection[M], *, left_out: tuple[str, ...], warnings: tuple[str, ...], seed: int
) -> Diagnosis:
    """Put everything together.

    Args:
        selection: after its run.
        left_out: sentences on what was not used, or taken elsewhere.
        warnings: sentences on what was taken for granted.
        seed: of everything that was drawn.
    """
    data, late = selection.data, selection.limit.was_hit
    found = data.conclude(selection.root, selection.current, again=not late)
    modal = data.findings(selection.rounds, selection.current, selection.rivals)
    says = verdict(facts_of(selection, found, modal))
    last = selection.current
    open_ = UNKNOWN in (name for name, _ in says.effects)
    search = not (late and last.hypothesis.keys)  # what is there predicts, and the time is up
    if open_ and (better := data.stand_in(last, selection.furthest, search=search)) is not None:
        last, found = better, data.conclude(selection.root, better, again=not late)
    nameless = tuple(key for key in found.after.hypothesis.keys if key not in says.effects)
    if nameless:
        says = replace(says, says=f"{says.says} {stand_in_words(nameless, found.gaps)}")
    shown = data.shown(found)
    data.advance("what to measure next", 0.5)
    standing = contenders(selection.rounds, selection.rivals, open_=open_)
    return Diagnosis(
        campaign=data.campaign.title,
        robot=data.context.robot.name,
        gaps=found.gaps,
        disagreement=found.disagreement,
        remaining=found.remaining,
        stand_in=nameless,
        baselines=data.baselines(last),
        steps=tuple(
            as_found_last(one, found) for one in selection.steps if (one.effect, one.where) in says.effects
        ),
        verdict=says,
        next_measurement=data.next_measurement(standing) if len(standing) > 1 else None,
        untestable=data.untestable,
        left_out=left_out,
        held_out=data.held_out,
        model=found.after.hypothesis,
        x=found.after.x,
        deviation=found.deviation,
        refused=tuple(selection.refused),
        provenance=provenance(data.campaign, data.context.robot, seed),
        modes=data.modes_seen(selection.root, last, found) if modal is None else modal.modes,
        modal=modal,
        over_noise=found.over_noise,
        look=data.look,
        warnings=(*warnings, *far_words(shown.get("moved", ())), *_beyond(found)),
        **_with_steps(selection, shown),
    )


def _beyond(found: Conclusion[M]) -> tuple[str, ...]:
    """Sentences on parameters that the last model takes further off than the card is trusted to be."""
    hypothesis = found.after.hypothesis
    return beyond_words(hypothesis.space, found.after.x, len(hypothesis.base))


def _with_steps(selection: ForwardSelection[M], shown: dict[str, Any]) -> dict[str, Any]:
    """What is shown, and between its first and last model those with some of the effects that are named."""
    fitted = [one for told in selection.rounds for one in told.comparison.models]
    more = steps_between(fitted, [(one.effect, one.where) for one in selection.steps])
    return {**shown, "predicted": {**shown["predicted"], **more}} if more else shown


def steps_between(
    fitted: Sequence[object], keys: Sequence[tuple[str, str]]
) -> dict[str, Complex[np.ndarray, "observation line"]]:
    """What the models with the first effects alone predict, as they were fitted when effects were compared.

    "step 1" has the first effect, "step 2" the first two; the last, with all of them, is not among these. One
    that was never fitted, as after an exchange, is left out.

    Args:
        fitted: every model that was compared, the latest last; those of modes alone predict no FRFs.
        keys: name and place of each effect, in the order in which they were added.
    """
    known = {
        one.hypothesis.keys: one.predicted
        for one in fitted
        if isinstance(one, FittedFrfs) and one.key[0] != UNSTRUCTURED
    }
    steps = {f"step {k}": tuple(keys[:k]) for k in range(1, len(keys))}
    return {name: known[some] for name, some in steps.items() if some in known}


def facts_of(selection: ForwardSelection[M], found: Conclusion[M], modal: Findings | None) -> Facts:
    """What the verdict goes by.

    Args:
        selection: after its run.
        found: its first and last models on everything that was measured.
        modal: what measured modes say besides.
    """
    data, first, last = selection.data, selection.rounds[0].comparison, selection.current
    standing, lacking_at = data.standing(last)
    return Facts(
        steps=tuple(selection.steps),
        says={effect.name: effect.says for effect in data.effects},
        gaps=found.gaps,
        over_noise=found.over_noise,
        reached=found.reached,
        lacking=dict(modal.left) if modal is not None else data.lacking(last),
        open_=not selection.steps and any_gains(first) is Answer.YES,
        standing=standing,
        told=bool(data.told) and set(data.told) == set(last.hypothesis.keys),
        lacking_at=lacking_at,
        contradicted=data.is_contradicted(last),
        unlike=unlike(last.hypothesis, last.x, data.covariance(last)),
        comes_close=any(one.effect.comes_close for one in last.hypothesis.placed),
        kind=found.remaining[0].kind if found.remaining else "",
        share=data.share(selection.root, found.after),
        look=data.look,
        place=data.place(found.after, modal),
        untestable=tuple(data.untestable),
        refused=refused_words(selection.rounds, data.asked),
        undecided=undecided_words(selection.rounds),
        cut_off=selection.limit.words(),
        modal=modal,
    )
