"""Clean blows: one of each kind, without noise or scatter, measured at every point at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Complex

from flexmodal.campaign import CampaignPosture, Trial
from flexmodal.rig.blow import strike
from flexmodal.rig.effects import Stand
from flexmodal.rig.hammer_test import force_records, reference_rows, response_rows
from flexmodal.rig.integration.linear import Outputs, records
from flexmodal.rig.integration.nonlinear import fine_records
from flexmodal.rig.plant.build import Hidden, build, sensors
from flexmodal.rig.sensing import Sensor


def peaks(stand: Stand, posture: CampaignPosture) -> tuple[dict[str, float], dict[str, float]]:
    """Peak deflection of each joint [rad] and acceleration at each point [m/s²] for a blow of 1 N.

    Args:
        stand: the true robot and its plan.
        posture: in which it is struck.
    """
    plan = stand.plan
    plant = build(stand, posture, [])
    trial = replace(plan.trials[0], force_peak=1.0)
    strikes = [
        (strike(1.0, trial.tip, plan.analyser.trigger, 0.0, 0.0, np.random.default_rng(0)), reference)
        for reference in plan.references
    ]
    pushed = reference_rows(stand, plant, strikes)
    joints = np.eye(plant.dof, len(plant.state_matrix))
    felt = [axis for point in plan.points for axis in response_rows(stand, plant, point, Sensor())]
    by_state = np.vstack([joints, plant.output_row(np.array(felt))])
    direct = np.linalg.solve(plant.mass, pushed.T).T @ np.array(felt).T
    by_force = np.hstack([np.zeros((len(strikes), plant.dof)), direct])
    outputs = Outputs(np.repeat(by_state[None], len(strikes), axis=0), by_force, np.zeros(len(strikes)))
    y = records(
        plant.state_matrix, plant.input_column(pushed), outputs, [s for s, _ in strikes], plan.analyser
    )
    size = np.max(np.abs(y), axis=(0, 2))
    deflection = dict(zip(plant.coordinates, size[: plant.dof].tolist(), strict=True))
    by_point = size[plant.dof :].reshape(len(plan.points), -1).max(axis=1)
    return deflection, dict(zip([p.name for p in plan.points], by_point.tolist(), strict=True))


def strike_all_points(
    stand: Stand, posture: CampaignPosture, hidden: Sequence[Hidden], trials: Sequence[Trial]
) -> Complex[np.ndarray, "trial reference point axis line"]:
    """FRFs from one clean blow a trial and reference, measured at every point at once.

    Args:
        stand: the true robot and its plan.
        posture: in which it is struck.
        hidden: effects put in.
        trials: one blow each.
    """
    plan = stand.plan
    linear = all(effect.linear for effect, _ in hidden)
    mounted = sensors(stand, hidden, posture)
    plant = build(stand, posture, hidden)
    flat = [
        (strike(t.force_peak, t.tip, plan.analyser.trigger, 0.0, 0.0, np.random.default_rng(0)), reference)
        for t in trials
        for reference in plan.references
    ]
    blows = [blow for blow, _ in flat]
    pushed = reference_rows(stand, plant, flat)
    rows = np.concatenate([response_rows(stand, plant, p, mounted[p.name]) for p in plan.points])
    direct = np.linalg.solve(plant.mass, pushed.T).T @ rows.T
    column = plant.input_column(pushed)
    by_state = np.repeat(plant.output_row(rows)[None], len(blows), axis=0)
    outputs = Outputs(by_state, direct, np.zeros(len(blows)))
    if linear:
        y = records(plant.state_matrix, column, outputs, blows, plan.analyser)
    else:
        repeats = len(plan.postures) * len(plan.points)
        fine = fine_records(plant, column, outputs, rows, blows, plan.analyser, repeats=repeats)
        ranges = np.repeat([mounted[p.name].range for p in plan.points], len(plan.axes))[:, None]
        np.clip(fine, -ranges, ranges, out=fine)
        y = plan.analyser.sampled(fine, plan.analyser.weights(), 0, plan.analyser.samples)
    force = np.fft.rfft(force_records(blows, plan.analyser), axis=-1)
    value = np.fft.rfft(y, axis=-1) / force[:, None, :]
    return value.reshape(len(trials), len(plan.references), len(plan.points), len(plan.axes), -1)
