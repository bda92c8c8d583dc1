"""From a forward selection on modes to a diagnosis: gaps, verdict, steps, the next measurement."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.disagreement.modal_regions import regions
from flexmodal.diagnosis.findings import Findings
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Diagnosis, NextMeasurement
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.search.modal_search import unmatched
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.decision import significant
from flexmodal.diagnosis.selection.modal_selection import ModalSelection
from flexmodal.diagnosis.selection.variants import FittedModes
from flexmodal.diagnosis.verdict.modal_verdict import verdict
from flexmodal.diagnosis.verdict.next_measurement import Sure, next_frf
from flexmodal.identification.evidence.likelihood.errors import errors, mean_of_others
from flexmodal.identification.evidence.likelihood.fit import COARSE
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.predictive import restricted
from flexmodal.identification.evidence.likelihood.shapes import compare_shapes
from flexmodal.identification.evidence.modal_gap import gap_of_errors


def diagnosis_of(selection: ModalSelection, moved: tuple[str, ...], seed: int) -> Diagnosis:
    """Put everything together.

    Args:
        selection: after its run.
        moved: sentences on points that were taken elsewhere.
        seed: of the postures tried for the next measurement.
    """
    selection.advance("what to measure next", 0.5)
    rounds, root = selection.rounds, selection.root.fit
    first = rounds[0].comparison
    final = selection.current
    worth_it = bool(selection.steps) or significant(first)
    compared = _two_structured(first, rounds[0].chosen) if worth_it else None
    best = final if selection.steps else first.models[first.order[0]]
    findings = _findings(selection, root, first, best, compared, worth_it)
    return Diagnosis(
        campaign=selection.whole.campaign.title,
        robot=selection.context.robot.name,
        gaps=replace(selection.gaps(selection.root, final), believed=_believed(selection)),
        disagreement=regions(selection.everywhere(root)),
        remaining=regions(selection.everywhere(final.fit)),
        steps=tuple(selection.steps),
        verdict=verdict(selection, findings),
        next_measurement=_next(selection, compared, findings, seed),
        untestable=selection.untestable,
        left_out=moved,
        held_out=_held_ids(selection),
        model=final.hypothesis,
        x=final.x,
        deviation=np.sqrt(np.maximum(np.diag(final.covariance), 0.0)),
        refused=() if selection.steps else tuple(selection.refused),
        provenance=provenance(selection.whole.campaign, selection.context.robot, seed),
        modal=findings,
    )


def _findings(
    selection: ModalSelection,
    root: ModalFit,
    comparison: Comparison[FittedModes],
    best: FittedModes,
    compared: tuple[FittedModes, FittedModes] | None,
    worth_it: bool,
) -> Findings:
    free = next((one for one in comparison.models if one.key[0] == UNSTRUCTURED), None)
    tied = tuple(comparison.models[k].key for k in comparison.tied)
    return Findings(
        measured=selection.whole,
        before=selection.everywhere(root),
        after=selection.everywhere(best.fit),
        held_before=comparison.models[0].held,
        held_after=best.held,
        comparison=comparison,
        free=None if free is None else selection.everywhere(free.fit),
        held_free=None if free is None else free.held,
        mean=mean_of_others(selection.whole),
        tied=tied if worth_it and len(tied) > 1 else (),
        missing=tuple(unmatched(root).items()),
        left=tuple(unmatched(best.fit if worth_it else root).items()),
        shapes=() if compared is None else compare_shapes(compared[0].fit, compared[1].fit),
        compared=None if compared is None else (compared[0].key, compared[1].key),
        told=selection.asked is not None,
    )


def _two_structured(
    comparison: Comparison[FittedModes], chosen: int | None
) -> tuple[FittedModes, FittedModes] | None:
    """What was added, or the best with structure, and the best of another kind or place tied with it."""
    found = [
        comparison.models[k]
        for k in comparison.tied
        if comparison.models[k].key[0] not in (NONE, UNSTRUCTURED)
    ]
    if chosen is not None:
        one = comparison.models[chosen]
        found = [one, *(other for other in found if other is not one)]
    if len(found) < 2:
        return None
    lacks = [sum(partner < 0 for partner in one.fit.pairs) for one in found]
    return found[0], next(
        (one for one, n in zip(found[1:], lacks[1:], strict=True) if n == lacks[0]), found[1]
    )


def _believed(selection: ModalSelection) -> float:
    """Gap of the card as it came, which may be far off and still have the modes."""
    tuned = selection.root.fit
    card = replace(tuned, x=np.zeros(len(tuned.x)))
    return gap_of_errors(errors(restricted(card, selection.whole, COARSE[0])))


def _next(
    selection: ModalSelection,
    compared: tuple[FittedModes, FittedModes] | None,
    found: Findings,
    seed: int,
) -> NextMeasurement | None:
    if compared is None or not found.tied:
        return None
    one, other = (Sure(fitted.hypothesis, fitted.x, fitted.covariance) for fitted in compared)
    return next_frf(selection.whole.campaign, selection.whole.responses[0][1], one, other, seed)


def _held_ids(selection: ModalSelection) -> tuple[int, ...]:
    if selection.held is None:
        return ()
    modes = selection.whole.modes
    numbers = sorted({mode.posture for mode, out in zip(modes, selection.held, strict=True) if out})
    return tuple(selection.whole.postures[k].id for k in numbers)
