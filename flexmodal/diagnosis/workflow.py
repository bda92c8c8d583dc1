"""The workflow: re-tune, compare, hypothesise, weigh, add, and again, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.compare import disagreement
from flexmodal.diagnosis.course import FLOOR_REACHED, Course
from flexmodal.diagnosis.figures import gaps_of, left, over_noise
from flexmodal.diagnosis.looking import looked_at
from flexmodal.diagnosis.modes.workflow import diagnose_modes, is_modal
from flexmodal.diagnosis.next_measurement import next_measurement
from flexmodal.diagnosis.outcome import Diagnosis, NextMeasurement
from flexmodal.diagnosis.preparation import Advance, prepare
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.verdict import verdict
from flexmodal.diagnosis.weigh import Weighable
from flexmodal.identification import gap, uncertainty
from flexmodal.model import Robot

EXPLAINED = 2.0
"""Distance of a model from the measurement, over that of the noise, that a strong effect may leave."""
LEFT = 0.03
"""Part of the disagreement above the noise that may be left then."""


def diagnose(
    campaign: Campaign,
    robot: Robot,
    *,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and a campaign of hammer tests on it.

    Args:
        campaign: with FRFs, or blows to estimate them from; with modes alone they are diagnosed (`modes`).
        robot: as it is believed to be.
        hold_out: postures (ids or names) that no weighed fit sees. By default one in four, at least one,
            those on which the re-tuned robot is neither best nor worst; with fewer than three postures none.
        effects: names from the catalogue; all by default.
        trust: standard deviation of ln(true / card) by kind or parameter name.
        seed: of the bootstrap.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no data, unknown effects or postures, a campaign that does not belong to the robot.
    """
    if is_modal(campaign):
        return diagnose_modes(
            campaign, robot, hold_out=hold_out, effects=effects, trust=trust, seed=seed, advance=advance
        )
    with threadpool_limits(1):  # matrices this small only wait for the threads of a BLAS
        course = Course(prepare(campaign, robot, hold_out, effects, trust, seed, advance))
        course.run()
        return _conclude(course)


def _conclude(course: Course) -> Diagnosis:
    bench = course.bench
    bench.advance("fitting everything once more", 0.0)
    held_pair = gaps_of(bench, course.before, course.current)
    final = course.current
    if bench.held.any():
        every = bench.observations
        final = looked_at(bench, final.hypothesis, final.fitted.x, fitted_to=every)
        before = looked_at(bench, course.root, course.before.fitted.x, fitted_to=every)
    else:
        before = course.before
    over = over_noise(bench, final)
    explained = over <= FLOOR_REACHED or (over <= EXPLAINED and left(bench, course.before, final) <= LEFT)
    if course.force_matters and not final.hypothesis.by_force:
        explained = False  # nothing linear changes with the force
    everything = gap(bench.observations, course.believed)
    gaps = replace(
        gaps_of(bench, before, final, everything.value),
        held_out_before=held_pair.held_out_before,
        held_out_after=held_pair.held_out_after,
    )
    says = verdict(bench, course.steps, final, gaps, over, explained=explained)
    sure = uncertainty(final.hypothesis.space, final.fitted.normal, bench.observations)
    bench.advance("what to measure next", 0.5)
    return Diagnosis(
        campaign=bench.observations.campaign.title,
        robot=bench.scene.robot.name,
        gaps=gaps,
        disagreement=disagreement(bench.observations, before.predicted),
        remaining=disagreement(bench.observations, final.predicted),
        steps=tuple(course.steps) if explained else (),
        verdict=says,
        next_measurement=_next(course, final),
        untestable=bench.untestable,
        left_out=bench.observations.silent,
        held_out=tuple(
            bench.observations.postures[int(k)].id for k in np.unique(bench.observations.posture[bench.held])
        ),
        model=final.hypothesis,
        x=final.fitted.x,
        deviation=sure.deviation,
        observations=bench.observations,
        predicted={"believed": course.believed, "before": before.predicted, "after": final.predicted},
        refused=tuple(course.refused),
        provenance=provenance(bench.observations.campaign, bench.scene.robot, bench.seed),
    )


def _next(course: Course, final: Weighable) -> NextMeasurement | None:
    if course.runner_up is None:
        return None
    return next_measurement(
        course.bench.observations,
        (final.hypothesis, final.fitted.x),
        (course.runner_up.hypothesis, course.runner_up.fitted.x),
    )
