"""Which measurement leaves least doubt between explanations (`information`).

First every posture, with sensor and hammer where the campaign has them. In the best of these, and in those
where the robot stood already, the sensor or the hammer elsewhere or turned. In the best of all, each joint
locked and a mass bolted on at each point. The best few of each kind are then looked at once more, the
explanations being fitted to each other (`refit`), and the one that leaves least doubt then is chosen; a
kind that costs more only where those before leave some.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np

from flexmodal.campaign import Campaign, CampaignPosture
from flexmodal.diagnosis.effects.context import Context, Place
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.next_measurement.information import Predicted, doubt_left
from flexmodal.diagnosis.next_measurement.predicted import Sure, predicted_by, relative
from flexmodal.diagnosis.next_measurement.refit import At, not_made_up_for
from flexmodal.diagnosis.next_measurement.setups import Bench, Plan, postures_to_try
from flexmodal.diagnosis.outcome import NextMeasurement
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.identification import Observations
from flexmodal.identification.gap import gap
from flexmodal.structure.structure import Axis, receptance

NOISE = 0.05
"""Relative noise of a line at a point that moves as points typically do, where no FRF was measured."""
LINES = 48
"""Of the FRF."""
CLOSER = 3
"""Postures looked at with other places and fixtures; measurements of each kind looked at again."""
NO_DOUBT = 1e-3
"""Expected doubt that nobody would pay more for: what costs more, a lock or a mass, is left out then, and
what hides least of the arm is measured."""
TOGETHER = 8
"""Postures that are looked at together: bounds the memory for many places in each."""
REFITTED = 3
"""Explanations that are fitted to each other."""


@dataclass(frozen=True, eq=False)
class Option:
    """The best of the measurements in one posture."""

    posture: CampaignPosture
    response: Place
    reference: Place
    force_peak: float
    doubt: float
    """ln of what it leaves."""
    gain: float
    """Information between the first two explanations [nat]."""
    lines: int


def next_among_fits(
    observations: Observations,
    models: Sequence[tuple[FittedFrfs, float]],
    covariance: Callable[[FittedFrfs], np.ndarray],
    seed: int = 0,
) -> NextMeasurement:
    """The same of models that were compared, each with its weight.

    Args:
        observations: the campaign's.
        models: see `next_among_records`.
        covariance: of a model's coordinates.
        seed: of the random postures.
    """
    every = [Sure(fit.hypothesis, fit.x, covariance(fit), weight) for fit, weight in models]
    left = min(gap(observations, fit.predicted).value for fit, _ in models)
    return next_among_records(observations, every, left, seed)


def next_among_records(
    observations: Observations, models: Sequence[Sure], left: float = 0.0, seed: int = 0
) -> NextMeasurement:
    """The best of all that could be measured beside FRFs that were.

    Args:
        observations: the campaign's.
        models: explanations, two or more, the first two those that are told.
        left: relative distance of the best of them from the measurements: none is right to better than that.
        seed: of the random postures.
    """
    bench = Bench.of(observations, models[0].hypothesis.context)
    stride = max(1, len(observations.axis) // LINES)
    lines = slice(stride // 2, None, stride)
    floor = gap(observations, observations.value).noise_floor
    noise = max(floor if floor > 0 else NOISE, left)
    by_force = any(one.hypothesis.by_force for one in models)
    levels = bench.levels(by_force=by_force)

    def seen_together(some: Sequence[Plan]) -> list[Option]:
        options = list[Option]()
        planned, there = bench.planned(some, levels)
        found = [predicted_by(one, there, planned, lines) for one in models]
        for number, (posture, rows) in enumerate(some):
            here = planned.posture == number
            peaks = [planned.peak(int(level)) for level in planned.level[here]]
            told = [(u, v) for u, v in rows for _ in levels]
            options += _options(posture, told, peaks, [one.keeping(here) for one in found], models, noise)
        return options

    def seen(plans: Sequence[Plan]) -> list[Option]:
        full = [plan for plan in plans if plan[1]]
        blocks = [full[begin : begin + TOGETHER] for begin in range(0, len(full), TOGETHER)]
        return [option for found in parallel_map(seen_together, blocks) for option in found]

    def not_measured(posture: CampaignPosture, rows: Sequence[tuple[Place, Place]]) -> Plan:
        return posture, _not_measured(bench, posture, rows)

    standing = [_standing(bench.context, q) for q in postures_to_try(bench.context, seed)]
    plain = seen([not_measured(posture, bench.rows) for posture in standing])
    elsewhere = seen([(option.posture, bench.other_rows) for option in _best(plain, CLOSER)])
    elsewhere += seen([not_measured(own, bench.other_rows) for own in bench.context.postures])
    held = seen(
        [
            (replace(option.posture, locked=locked, masses=masses), [(option.response, option.reference)])
            for option in _best([*plain, *elsewhere], CLOSER)
            for locked, masses in bench.fixtures
        ]
    )
    new = {point.id: point.name for point in bench.new}
    judged: list[Option] = []
    for kind in (plain, elsewhere, held):
        again = partial(_refitted, bench=bench, models=models, lines=lines, noise=noise)
        judged += parallel_map(again, _best(kind, CLOSER))
        if judged and _best(judged, 1)[0].doubt < math.log(NO_DOUBT):
            break
    return _told(_best(judged, 1)[0], models, new)


def _refitted(option: Option, bench: Bench, models: Sequence[Sure], lines: slice, noise: float) -> Option:
    """A measurement judged with the explanations fitted to each other."""
    level = next(
        number
        for number in bench.levels(by_force=any(one.hypothesis.by_force for one in models))
        if math.isclose(bench.peak(number), option.force_peak)
    )
    planned, there = bench.planned([(option.posture, [(option.response, option.reference)])], [level])

    def at(one: Sure) -> At:
        moved = Hypothesis(there, one.hypothesis.base, one.hypothesis.placed)
        low, high = moved.space.bounds

        def found(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            seen = predicted_by(replace(one, x=np.clip(x, low, high)), there, planned, lines)
            return seen.value[0], seen.slopes[:, 0]

        return found

    some = models[:REFITTED]
    here = [at(one) for one in some]
    values = [found(one.x)[0] for found, one in zip(here, some, strict=True)]
    pairs = list(combinations(range(len(some)), 2))
    each = [
        min(
            not_made_up_for(values[i], here[j], some[j].x, some[j].covariance, noise),
            not_made_up_for(values[j], here[i], some[i].x, some[i].covariance, noise),
        )
        for i, j in pairs
    ]
    total = sum(one.weight for one in some)
    weights = [one.weight / total for one in some]
    share = np.log([2 * weights[i] * weights[j] for i, j in pairs])
    doubt = float(np.logaddexp.reduce(share - np.array(each) / 4))
    return replace(option, doubt=doubt, gain=each[0])


def next_frf(campaign: Campaign, direction: int, models: Sequence[Sure], seed: int = 0) -> NextMeasurement:
    """The best FRF where modes alone were measured, every point as sensor and every point as hammer point.

    Args:
        campaign: of modes, whose points there are.
        direction: of sensor and hammer, 1, 2 or 3.
        models: explanations, two or more, the first two those that are told.
        seed: of the random postures.
    """
    context = models[0].hypothesis.context
    places = [(point.id, direction) for point in context.points]
    pairs = np.array([(u, v) for v in range(len(places)) for u in range(len(places))])
    axis = Axis(np.linspace(*context.band, LINES), context.middle)
    peaks = [trial.force_peak for trial in campaign.trials]
    peak = float(np.mean(peaks)) if peaks else 0.0
    rows = [(places[u], places[v]) for u, v in pairs.tolist()]

    def seen(fit: Sure, there: Context) -> Predicted:
        moved = Hypothesis(there, fit.hypothesis.base, fit.hypothesis.placed)
        (structure,) = moved.structures(fit.x, places, places, slopes=True)
        value, slopes = receptance(structure, axis, pairs, moved.space.names)
        return relative(value, slopes, fit)

    options: list[Option] = []
    for number, q in enumerate(postures_to_try(context, seed), start=1):
        posture = CampaignPosture(number, f"planned_{number}", q)
        there = replace(context, postures=(posture,))
        found = [seen(one, there) for one in models]
        options += _options(posture, rows, [peak] * len(rows), found, models, NOISE)
    return _told(_best(options, 1)[0], models, {})


def _options(
    posture: CampaignPosture,
    rows: Sequence[tuple[Place, Place]],
    peaks: Sequence[float],
    found: Sequence[Predicted],
    models: Sequence[Sure],
    noise: float,
) -> list[Option]:
    """The best of some rows in a posture."""
    total = sum(one.weight for one in models)
    doubt, gain = doubt_left(found, [one.weight / total for one in models], noise)
    row = int(np.argmin(doubt))
    lines = found[0].value.shape[1]
    return [Option(posture, *rows[row], peaks[row], float(doubt[row]), float(gain[row]), lines)]


def _best(options: Iterable[Option], count: int) -> list[Option]:
    return sorted(options, key=lambda one: one.doubt)[:count]


def _standing(context: Context, q: Mapping[str, float]) -> CampaignPosture:
    """The campaign's own posture of these angles without fixtures, or a new one."""
    for one in context.postures:
        if dict(one.q) == dict(q) and not (one.locked or one.masses):
            return one
    return CampaignPosture(max(one.id for one in context.postures) + 1, "planned", q)


def _not_measured(
    bench: Bench, posture: CampaignPosture, rows: Sequence[tuple[Place, Place]]
) -> list[tuple[Place, Place]]:
    """Rows without those that were measured in this posture."""
    seen = bench.observations
    here = np.array([one.id == posture.id for one in seen.postures])[seen.posture]
    table = np.column_stack([seen.response, seen.reference])[here].tolist()
    return [row for row in rows if [*row[0], *row[1]] not in table]


def _told(best: Option, models: Sequence[Sure], new: Mapping[int, str]) -> NextMeasurement:
    posture = best.posture
    there = {best.response[0], best.reference[0]}
    used = {number: name for number, name in new.items() if number in there or name in posture.masses}
    return NextMeasurement(
        posture=dict(posture.q),
        response=best.response,
        reference=best.reference,
        separates=(_label(models[0].hypothesis), _label(models[1].hypothesis)),
        expected=float(np.sqrt(best.gain / best.lines)),
        force_peak=best.force_peak,
        gain=best.gain,
        new_points=used,
        locked=posture.locked,
        masses=dict(posture.masses),
    )


def _label(hypothesis: Hypothesis) -> str:
    return "@".join(hypothesis.keys[-1]) if hypothesis.placed else NONE
