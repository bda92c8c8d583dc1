"""From rounds of weighing to a diagnosis: gaps, verdict, steps, the next measurement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexmodal.diagnosis.modes.elsewhere import restricted
from flexmodal.diagnosis.modes.evidence import ModalFit
from flexmodal.diagnosis.modes.findings import Findings
from flexmodal.diagnosis.modes.fit import COARSE
from flexmodal.diagnosis.modes.gap import errors, figures, mean_of_others, noise_floor
from flexmodal.diagnosis.modes.held_out import HeldOut
from flexmodal.diagnosis.modes.next_measurement import next_frf
from flexmodal.diagnosis.modes.regions import regions
from flexmodal.diagnosis.modes.search import unmatched
from flexmodal.diagnosis.modes.shapes import compare_shapes
from flexmodal.diagnosis.modes.weigh import Candidate, Scales
from flexmodal.diagnosis.modes.words import hertz, left_words, missing_words, named, shape_words, tie_words
from flexmodal.diagnosis.outcome import (
    NONE,
    UNKNOWN,
    UNSTRUCTURED,
    Diagnosis,
    Gaps,
    NextMeasurement,
    Step,
    Verdict,
    Weighed,
)
from flexmodal.diagnosis.provenance import provenance
from flexmodal.identification import predict
from flexmodal.identification.evidence.modal_gap import gap_of_errors

if TYPE_CHECKING:
    from flexmodal.diagnosis.modes.workflow import Round, _Course

EVERYWHERE = "arm"
"""Where something sits that cannot be placed."""


def conclude(course: _Course, root: ModalFit, rounds: Sequence[Round]) -> Diagnosis:
    """Put everything together."""
    course.advance("what to measure next", 0.5)
    first = rounds[0].scales
    added = [r.scales.candidates[r.chosen] for r in rounds if r.chosen is not None]
    final = added[-1] if added else first.candidates[0]
    worth_it = bool(added) or _significant(first)
    compared = _two_structured(first, rounds[0].chosen) if worth_it else None
    best = added[-1] if added else first.candidates[first.order[0]]
    findings = _findings(course, root, first, best, compared, worth_it)
    explained = _explained(course, first, rounds, findings)
    shown = course.everywhere(final.fit)
    model, x = shown.explanation.hypothesis, shown.x
    count = len(model.space)
    stages = {"believed": np.zeros(len(course.base)), "before": root.x}
    bare = root.explanation.hypothesis
    return Diagnosis(
        campaign=course.whole.campaign.title,
        robot=course.scene.robot.name,
        gaps=_gaps(course, first.candidates[0], final),
        disagreement=regions(course.everywhere(root)),
        remaining=regions(shown),
        steps=tuple(_step(course, r.scales, r.chosen) for r in rounds if r.chosen is not None),
        verdict=_verdict(course, rounds, findings, explained),
        next_measurement=_next(course, compared, findings),
        untestable=course.untestable,
        left_out=course.moved,
        held_out=_held_ids(course),
        model=model,
        x=x[:count],
        deviation=np.sqrt(np.maximum(np.diag(shown.covariance)[:count], 0.0)),
        observations=course.whole.stand_in,
        predicted={
            **{name: predict(bare, at, course.whole.stand_in) for name, at in stages.items()},
            "after": predict(model, x[:count], course.whole.stand_in),
        },
        refused=() if added else _weighed(course, first, None),
        provenance=provenance(course.whole.campaign, course.scene.robot, course.seed),
        modal=findings,
    )


def _findings(
    course: _Course,
    root: ModalFit,
    scales: Scales,
    best: Candidate,
    compared: tuple[Candidate, Candidate] | None,
    worth_it: bool,
) -> Findings:
    free = next((one for one in scales.candidates if one.key[0] == UNSTRUCTURED), None)
    tied = tuple(scales.candidates[k].key for k in scales.tied)
    return Findings(
        measured=course.whole,
        before=course.everywhere(root),
        after=course.everywhere(best.fit),
        held_before=scales.candidates[0].held,
        held_after=best.held,
        scales=scales,
        free=None if free is None else course.everywhere(free.fit),
        held_free=None if free is None else free.held,
        mean=mean_of_others(course.whole),
        tied=tied if worth_it and len(tied) > 1 else (),
        missing=tuple(unmatched(root).items()),
        left=tuple(unmatched(best.fit if worth_it else root).items()),
        shapes=() if compared is None else compare_shapes(compared[0].fit, compared[1].fit),
        compared=None if compared is None else (compared[0].key, compared[1].key),
        told=course.asked is not None,
    )


def _two_structured(scales: Scales, chosen: int | None) -> tuple[Candidate, Candidate] | None:
    """What was added, or the best with structure, and the best of another kind or place tied with it."""
    found = [
        scales.candidates[k] for k in scales.tied if scales.candidates[k].key[0] not in (NONE, UNSTRUCTURED)
    ]
    if chosen is not None:
        one = scales.candidates[chosen]
        found = [one, *(other for other in found if other is not one)]
    if len(found) < 2:
        return None
    lacks = [sum(partner < 0 for partner in one.fit.pairs) for one in found]
    return found[0], next(
        (one for one, n in zip(found[1:], lacks[1:], strict=True) if n == lacks[0]), found[1]
    )


def _explained(course: _Course, scales: Scales, rounds: Sequence[Round], found: Findings) -> bool:
    """Whether every mode has a partner, and nothing is tied or would gain."""
    if rounds[0].chosen is not None:
        return not found.left and not found.tied
    return not found.missing and not _significant(scales)


def _significant(scales: Scales) -> bool:
    """Whether anything at all gains enough."""
    from flexmodal.diagnosis.modes.workflow import needed

    return any(needed(scales, k) for k in range(1, len(scales.candidates)))


# gaps


def _held_gap(held: HeldOut | None) -> float | None:
    return None if held is None else gap_of_errors(held.errors)


def _gaps(course: _Course, before: Candidate, after: Candidate) -> Gaps:
    fits = [course.everywhere(one.fit) for one in (before, after)]
    tables = [errors(fit) for fit in fits]
    believed = _believed(course, before.fit)
    return Gaps(
        before=figures(tables[0]).gap,
        after=figures(tables[1]).gap,
        held_out_before=_held_gap(before.held),
        held_out_after=_held_gap(after.held),
        noise_floor=noise_floor(course.whole, tables[1]),
        believed=believed,
    )


def _believed(course: _Course, tuned: ModalFit) -> float:
    """Of the card as it came, which may be far off and still have the modes."""
    card = replace(tuned, x=np.zeros(len(tuned.x)))
    return figures(errors(restricted(card, course.whole, COARSE[0]))).gap


# steps


def _weighed(course: _Course, scales: Scales, but: int | None) -> tuple[Weighed, ...]:
    base = len(scales.candidates[0].fit.explanation.space)
    probability, table = scales.probability, scales.table
    found = []
    for k in scales.order:
        one = scales.candidates[k]
        if k == but:
            continue
        effect, where = (NONE, "") if k == 0 else one.key
        found.append(
            Weighed(
                effect, where, figures(errors(course.everywhere(one.fit))).gap, _held_gap(one.held),
                float(table[k, 0]), float(probability[k]), len(one.fit.explanation.space) - base,
            )
        )  # fmt: skip
    return tuple(found)


def _step(course: _Course, scales: Scales, chosen: int) -> Step:
    one = scales.candidates[chosen]
    parameters, units, deviations = _parameters(one.fit)
    return Step(
        effect=one.key[0],
        where=one.key[1],
        parameters=parameters,
        units=units,
        uncertainty=deviations,
        confidence=float(scales.probability[chosen]),
        gaps=_gaps(course, scales.candidates[0], one),
        alternatives=_weighed(course, scales, chosen),
        ties=tuple(scales.candidates[k].key for k in scales.tied if k not in (0, chosen)),
    )


def _parameters(fit: ModalFit) -> tuple[dict[str, float], dict[str, str], dict[str, float]]:
    """Physical parameters of the effect added last, their units and standard errors."""
    hypothesis = fit.explanation.hypothesis
    placed, scene, space = hypothesis.placed[-1], hypothesis.context, hypothesis.space
    own = {p.name: p.unit for p in placed.effect.parameters(scene, placed.where)}

    def physical(x: np.ndarray) -> dict[str, float]:
        values = hypothesis.values_of(placed, space.values(x))
        found = placed.effect.physical(scene, placed.where, values)
        return {k: v for k, v in found.items() if k in own or "." not in k}

    x = fit.x[: len(space)]
    here = physical(x)
    slopes = np.array(
        [
            (np.array(list(physical(x + 1e-5 * unit).values())) - list(here.values())) / 1e-5
            for unit in np.eye(len(x))
        ]
    ).T
    size = len(x)
    sure = np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", slopes, fit.covariance[:size, :size], slopes), 0.0))
    units = {name: placed.effect.units.get(name, own.get(name, "")) for name in here}
    return here, units, dict(zip(here, sure.tolist(), strict=True))


# the end


def _verdict(course: _Course, rounds: Sequence[Round], found: Findings, explained: bool) -> Verdict:
    scales = rounds[0].scales
    added = [r.scales.candidates[r.chosen].key for r in rounds if r.chosen is not None]
    says = [missing_words(found)]
    if added:
        why = "as asked, " if found.told else ""
        says.append(f"Added, {why}{' and '.join(named(key) for key in added)}.")
        gained = rounds[0].scales.table[rounds[0].chosen] - rounds[0].scales.table[0]
        low, middle, high = (f"{v:.0f}".replace("-", "−") for v in (gained.min(), gained[0], gained.max()))
        what = "The first gains" if len(added) > 1 else "It gains"
        says.append(f"{what} {middle} nats ({low} to {high} under other priors).")
        if found.tied:
            says.append(tie_words(found))
        says += [shape_words(found), left_words(found)]
        return Verdict(tuple(added), explained, _joined(says))
    says += _refused(course, scales)
    if not _significant(scales):
        if found.missing:
            says.append(f"Nothing that was tried earns its parameters: look near {hertz(found.missing)}.")
            return Verdict(((UNKNOWN, _place(found)),), False, _joined(says))
        return Verdict((), True, _joined(["Nothing is missing that these modes could show.", *says]))
    says = ["A mode is missing." if found.missing else "Something is missing.", *says]
    says.append(
        tie_words(found) if found.tied else f"Best is {named(scales.candidates[scales.order[0]].key)}."
    )
    says += [shape_words(found), left_words(found)]
    return Verdict(((UNKNOWN, _place(found)),), False, _joined(says))


def _refused(course: _Course, scales: Scales) -> list[str]:
    """Why what was asked for by its place was not added."""
    from flexmodal.diagnosis.modes.workflow import undecided

    if course.asked is None:
        return []
    said = []
    for k in scales.order:
        name, where = scales.candidates[k].key
        if k and where in course.asked.get(name, ()):
            gain = scales.first_gain(k)
            gained = f"{gain:.0f}".replace("-", "−")
            what = "which leaves it undecided" if undecided(gain) else "which is a tie with nothing added"
            said.append(f"Asked for, {named((name, where))} gains {gained} nats, {what}.")
    return said


def _joined(parts: Sequence[str]) -> str:
    return " ".join(part for part in parts if part)


def _place(found: Findings) -> str:
    """The one place that everything tied points at; the arm as a whole where there is none."""
    places = {where for effect, where in found.tied or (found.after.explanation.key,) if effect != NONE}
    return places.pop() or EVERYWHERE if len(places) == 1 else EVERYWHERE


def _next(
    course: _Course, compared: tuple[Candidate, Candidate] | None, found: Findings
) -> NextMeasurement | None:
    if compared is None or not found.tied:
        return None
    return next_frf(compared[0].fit, compared[1].fit, course.seed)


def _held_ids(course: _Course) -> tuple[int, ...]:
    if course.held is None:
        return ()
    modes = course.whole.observed.modes
    numbers = sorted({mode.posture for mode, out in zip(modes, course.held, strict=True) if out})
    return tuple(course.whole.observed.postures[k].id for k in numbers)
