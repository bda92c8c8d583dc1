"""The workflow: re-tune, compare, hypothesise, weigh, add, and again, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.disagreement.compare import disagreement
from flexmodal.diagnosis.disagreement.gaps import gaps_of, left, over_noise
from flexmodal.diagnosis.modal_workflow import diagnose_modes, is_modal
from flexmodal.diagnosis.outcome import Diagnosis, NextMeasurement
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.search.looking import looked_at
from flexmodal.diagnosis.selection.beside_frfs import ModesBeside
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_selection import FLOOR_REACHED, FrfSelection
from flexmodal.diagnosis.setup import Advance, prepare
from flexmodal.diagnosis.verdict.next_measurement import next_measurement
from flexmodal.diagnosis.verdict.verdict import verdict
from flexmodal.identification import gap, uncertainty
from flexmodal.identification.evidence.mode_sources import modes_of_table
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
        campaign: with FRFs, blows to estimate them from, modes, or FRFs and modes, which both count then.
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
        setup = prepare(campaign, robot, hold_out, effects, trust, seed, advance)
        modes = None if campaign.modes is None else ModesBeside(modes_of_table(campaign), setup.fitted)
        selection = FrfSelection(setup, modes)
        selection.run()
        return _diagnosis_of(selection)


def _diagnosis_of(selection: FrfSelection) -> Diagnosis:
    setup = selection.setup
    setup.advance("fitting everything once more", 0.0)
    held_pair = gaps_of(setup, selection.root, selection.current)
    final = selection.current
    if setup.held.any():
        every = setup.observations
        final = looked_at(setup, final.hypothesis, final.x, fitted_to=every)
        before = looked_at(setup, selection.root.hypothesis, selection.root.x, fitted_to=every)
    else:
        before = selection.root
    over = over_noise(setup, final)
    explained = over <= FLOOR_REACHED or (over <= EXPLAINED and left(setup, selection.root, final) <= LEFT)
    if selection.force_matters and not final.hypothesis.by_force:
        explained = False  # nothing linear changes with the force
    lacking = selection.lacking(selection.current)
    explained = explained and not lacking
    everything = gap(setup.observations, selection.believed)
    gaps = replace(
        gaps_of(setup, before, final, everything.value),
        held_out_before=held_pair.held_out_before,
        held_out_after=held_pair.held_out_after,
    )
    named = not explained and not lacking and selection.is_named(selection.current)
    share = 1 - left(setup, selection.root, final)
    says = verdict(
        setup, selection.steps, final, gaps, over, explained=explained, named=named, share=share,
        look=selection.look, lacking=lacking,
    )  # fmt: skip
    sure = uncertainty(final.hypothesis.space, final.fitted.normal, setup.observations)
    setup.advance("what to measure next", 0.5)
    return Diagnosis(
        campaign=setup.observations.campaign.title,
        robot=setup.context.robot.name,
        gaps=gaps,
        disagreement=disagreement(setup.observations, before.predicted),
        remaining=disagreement(setup.observations, final.predicted),
        steps=tuple(selection.steps) if explained or named else (),
        verdict=says,
        next_measurement=_next(selection, final),
        untestable=setup.untestable,
        left_out=setup.observations.silent,
        held_out=tuple(
            setup.observations.postures[int(k)].id for k in np.unique(setup.observations.posture[setup.held])
        ),
        model=final.hypothesis,
        x=final.x,
        deviation=sure.deviation,
        frfs=setup.observations,
        predicted={"believed": selection.believed, "before": before.predicted, "after": final.predicted},
        refused=tuple(selection.refused),
        look=selection.look,
        provenance=provenance(setup.observations.campaign, setup.context.robot, setup.seed),
    )


def _next(selection: FrfSelection, final: FittedFrfs) -> NextMeasurement | None:
    if selection.runner_up is None:
        return None
    return next_measurement(
        selection.setup.observations,
        (final.hypothesis, final.x),
        (selection.runner_up.hypothesis, selection.runner_up.x),
    )
