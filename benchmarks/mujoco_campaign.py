"""Campaigns whose physics is MuJoCo's: other people's code, integrated in time, written as any campaign.

    python benchmarks/mujoco_campaign.py

prints how far the FRFs of such campaigns are off flexmodal's receptance with nothing hidden, and off the
rig's with the same effects hidden. `simulate_mujoco` can be imported and takes what
`flexmodal.rig.simulate` takes:

    result = simulate_mujoco(robot, hide=["added_mass@link_3"], postures=5, seed=1)
    result.write("test")

From the rig come the plan, the scatter of the blows, the true parameters, and how strong an effect has to
be. From MuJoCo comes the motion: kinematics, masses, springs, dampers and the hidden things are an MJCF
model (see `mujoco_model`), integrated by Runge and Kutta's fourth-order rule on a grid 16 times finer than
the samples, or finer where the model is stiff. The hammer's force stands still during a step, at its value
in the middle; an accelerometer gives the mean acceleration over a step, which is what the velocity changes
by; both then pass scipy's filter and decimator.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np
from mujoco_model import EFFECTS, Spoil, mjcf
from scipy.signal import firwin, resample_poly

import flexmodal
from flexmodal.campaign import (
    Blow,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    estimate_frfs,
)
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig import RigResult, simulate
from flexmodal.rig.believed import true_robot
from flexmodal.rig.blow import Strike, strike
from flexmodal.rig.effects import Stand
from flexmodal.rig.effects.effect import OWN
from flexmodal.rig.hidden.placement import put_in
from flexmodal.rig.request import prepare
from flexmodal.rig.robot_folder import CARD
from flexmodal.rig.simulate import make_stand
from flexmodal.rig.truth import Truth

OVERSAMPLING = 16
"""Steps of the integration in one sample, or a multiple where the model is too stiff for that."""
STABLE = 1.5
"""Highest natural frequency [rad/s] times step; Runge and Kutta's rule is unstable from 2.8 on."""
HALF_FILTER = 20
"""Samples on either side that the decimator's filter reaches."""
TOGETHER = 4
"""Blows integrated by one call."""
FORCE_NOISE = 0.3
"""Of the force cell, relative to that of the accelerometers."""
NOTHING = 1e-12
"""Inertance of an FRF that is zero but for rounding [m/(s²·N)]."""

Struck = tuple[Strike, int, int, tuple[int, int]]
"""A blow: how it fell, its trial, its sequence number, its reference."""


def simulate_mujoco(robot: Robot, **request: Any) -> RigResult:
    """Simulate a hammer test by MuJoCo.

    All points are measured at once, unless the sensor's mass is hidden: then each is measured by its own
    blows.

    Args:
        robot: as the tester believes it to be.
        request: as `flexmodal.rig.simulate` takes it; of the effects those of `EFFECTS`.

    Raises:
        InvalidRequest: an effect that MuJoCo has nothing for, or what `simulate` raises.
    """
    time = request.pop("time", True)
    prepared = prepare(robot, **request)
    missing = [item.effect for item in prepared.wanted if item.effect not in EFFECTS or item.form != OWN]
    if missing:
        raise InvalidRequest([Fault("call", "hide", name, ", ".join(EFFECTS)) for name in missing])
    if robot.couplings or any(joint.loss_factor for joint in robot.joints.values()):
        raise InvalidRequest(Fault("call", "robot", "couplings or loss factors", "plain springs and dampers"))
    conduct, plan = prepared.conduct, prepared.plan
    true = true_robot(robot, prepared.error, np.random.default_rng([conduct.seed, 4]))
    stand = make_stand(robot, plan, true)
    hidden, effects, floor = put_in(stand, prepared.wanted, conduct)
    spoils = [Spoil(effect.name, site.where, site.parameters) for effect, site in hidden]
    blows = [
        blow
        for posture in plan.postures
        for blow in _strike_posture(stand, posture, spoils, conduct.noise, conduct.scatter, conduct.seed)
    ]
    campaign = Campaign(
        title=f"{robot.title}: hammer test simulated by MuJoCo {mujoco.__version__}",
        robot=CARD,
        band=plan.band,
        postures=plan.postures,
        points=plan.points,
        trials=plan.trials,
        blows=tuple(blows),
    )
    campaign = replace(
        campaign, frfs=estimate_frfs(campaign, estimator="H1"), blows=campaign.blows if time else ()
    )
    factors = stand.true.factors
    truth = Truth(robot.name, conduct.seed, conduct.noise, conduct.scatter, floor, effects, factors)
    return RigResult(campaign, truth, robot, plan, stand, tuple(hidden))


def _strike_posture(
    stand: Stand, posture: CampaignPosture, spoils: Sequence[Spoil], noise: float, scatter: float, seed: int
) -> list[Blow]:
    plan = stand.plan
    weighs = [spoil.parameters["mass"] for spoil in spoils if spoil.effect == "sensor_mass"]
    visits: list[tuple[tuple[CampaignPoint, ...], tuple[CampaignPoint, float] | None]]
    visits = [((point,), (point, weighs[0])) for point in plan.points] if weighs else [(plan.points, None)]
    each = [_strikes(stand, posture, visit, scatter, seed) for visit in range(len(visits))]
    records = [
        _records(stand, posture, spoils, measured, carrying, struck)
        for (measured, carrying), struck in zip(visits, each, strict=True)
    ]
    everywhere = float(np.sqrt(np.mean(np.concatenate([part.ravel() for _, part in records]) ** 2)))
    blows = []
    for visit, ((measured, _), struck, (force, response)) in enumerate(
        zip(visits, each, records, strict=True)
    ):
        random = np.random.default_rng([seed, 8, posture.id, visit])
        if noise > 0:
            _add_noise(force, response, everywhere, noise, random)
        channels = tuple((point.id, axis) for point in measured for axis in plan.axes)
        blows += [
            Blow(
                posture.id, trial, sequence, reference, plan.analyser.time, force[n], channels, response[n],
                "acceleration",
            )
            for n, (_, trial, sequence, reference) in enumerate(struck)
        ]  # fmt: skip
    return blows


def _strikes(stand: Stand, posture: CampaignPosture, visit: int, scatter: float, seed: int) -> list[Struck]:
    """The blows of one posture; with a sensor that moves, those of each visit are numbered on."""
    plan, made = stand.plan, []
    for trial in plan.trials:
        each = len(plan.references) * trial.averages
        random = np.random.default_rng([seed, 7, posture.id, trial.id, visit])
        for number in range(each):
            blow = strike(
                trial.force_peak, trial.tip, plan.analyser.trigger, plan.analyser.interval, scatter, random
            )
            made.append(
                (blow, trial.id, visit * each + number + 1, plan.references[number // trial.averages])
            )
    return made


def _records(
    stand: Stand,
    posture: CampaignPosture,
    spoils: Sequence[Spoil],
    measured: Sequence[CampaignPoint],
    carrying: tuple[CampaignPoint, float] | None,
    struck: Sequence[Struck],
) -> tuple[np.ndarray, np.ndarray]:
    """Force [blow, sample] and response [blow, channel, sample], through the analyser's filter."""
    plan = stand.plan
    hammers = list(dict.fromkeys(number for number, _ in plan.references))
    sensed = list({point.id: point for point in (*measured, *(plan.point(n) for n in hammers))}.values())
    step = plan.analyser.interval / OVERSAMPLING
    xml = mjcf(
        stand.robot, stand.true, posture.q, sensed, hammers, spoils=spoils, carrying=carrying, step=step
    )
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    steps_a_sample = OVERSAMPLING * max(1, int(np.ceil(_fastest(model, data) * step / STABLE)))
    model.opt.timestep = step = plan.analyser.interval / steps_a_sample
    steps = plan.analyser.samples * steps_a_sample
    middle = (np.arange(steps) + 0.5) * step
    over = int(np.ceil(max(blow.start + blow.duration for blow, *_ in struck) / step)) + 1
    picked = [3 * k + axis - 1 for k in range(len(measured)) for axis in plan.axes]
    force, response = [], []
    for first in range(0, len(struck), TOGETHER):
        some = struck[first : first + TOGETHER]
        pulses = np.array([blow.force(middle) for blow, *_ in some])
        control = np.zeros((len(some), over, model.nu))
        for n, (blow, *_, reference) in enumerate(some):
            wrench = _wrench(data, model, plan.point(reference[0]), blow, reference)
            place = 6 * hammers.index(reference[0])
            control[n, :, place : place + 6] = pulses[n, :over, None] * wrench
        velocity = _velocities(model, data, control, steps + 1)[..., picked]
        fine = np.diff(velocity, axis=1) / step
        force.append(_sampled(pulses, steps_a_sample))
        response.append(_sampled(np.swapaxes(fine, 1, 2), steps_a_sample))
    return np.concatenate(force), np.concatenate(response)


def _wrench(
    data: Any, model: Any, point: CampaignPoint, blow: Strike, reference: tuple[int, int]
) -> np.ndarray:
    """Force and moment at the marked point of a blow of 1 N that lands beside it, world axes."""
    mujoco.mj_kinematics(model, data)
    site = model.site(f"point {point.id}")
    body = data.xmat[site.bodyid[0]].reshape(3, 3)
    way = blow.tilt @ np.eye(3)[abs(reference[1]) - 1] * np.sign(reference[1])
    return np.concatenate([way, np.cross(body @ blow.offset, way)])


def _velocities(model: Any, data: Any, control: np.ndarray, steps: int) -> np.ndarray:
    """What the velocimeters read as each step begins, [blow, step, 3 × site]: struck, then left alone."""
    mujoco.mj_resetData(model, data)
    spec = int(mujoco.mjtState.mjSTATE_CTRL)
    full = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, start, full)
    states = np.tile(start, (len(control), 1))
    state, struck = mujoco.rollout.rollout(model, data, states, control, control_spec=spec)
    _, free = mujoco.rollout.rollout(
        model, data, np.ascontiguousarray(state[:, -1]), np.zeros((1, 1, model.nu)), control_spec=spec,
        nstep=steps - control.shape[1],
    )  # fmt: skip
    return np.concatenate([struck, free], axis=1)


def _fastest(model: Any, data: Any) -> float:
    """Highest natural frequency [rad/s]."""
    mujoco.mj_forward(model, data)
    root = np.diag(np.sqrt(model.jnt_stiffness))
    moved = np.zeros_like(root)
    mujoco.mj_solveM(model, data, moved, root)  # a row of the root of K at a time, by the mass matrix
    return float(np.sqrt(np.linalg.eigvalsh(moved @ root)[-1]))


def _sampled(fine: np.ndarray, fewer: int) -> np.ndarray:
    """One value of so many, after a filter that is 90 dB down where lines fold back into the band."""
    taps = firwin(2 * HALF_FILTER * fewer + 1, 1 / fewer, window=("kaiser", 9.0))
    return resample_poly(fine, 1, fewer, axis=-1, window=taps)


def _add_noise(
    force: np.ndarray, response: np.ndarray, everywhere: float, level: float, random: np.random.Generator
) -> None:
    own = np.sqrt(np.mean(response**2, axis=-1, keepdims=True))
    response += level * np.hypot(own, 0.1 * everywhere) * random.standard_normal(response.shape)
    cell = FORCE_NOISE * level * np.sqrt(np.mean(force**2, axis=-1, keepdims=True))
    force += cell * random.standard_normal(force.shape)


CHECK = {"postures": 2, "points": 3, "trials": 1, "averages": 1, "peaks": (100.0,), "record_length": 8.0}
QUIET = {"noise": 0.0, "scatter": 0.0, "parameter_error": 0.0}


def off_the_model(result: RigResult) -> tuple[float, float]:
    """How far measured FRFs are off the inertance H of the robot as the card has it.

    Returns:
        The largest ‖FRF − H‖ / ‖H‖ of any FRF over the band, and the 99th percentile of |ln(FRF / H)| of
        its lines.
    """
    frfs, plan = result.campaign.frfs, result.plan
    assert frfs is not None
    inside = _inside(result)
    names = {point.id: point.name for point in plan.points}
    poses = {posture.id: posture for posture in plan.postures}
    norms, logarithms = [], []
    for row in range(len(frfs)):
        response, reference = (
            f"{names[int(point)]}:{'+' if way > 0 else '-'}{'xyz'[abs(int(way)) - 1]}"
            for point, way in (frfs.response[row], frfs.reference[row])
        )
        posed = result.robot.at(dict(poses[int(frfs.posture[row])].q))
        model = posed.frf(frfs.frequency[inside], response=response, reference=reference, form="inertance")
        one, other = frfs.value[row, inside], model.value[:, 0, 0]
        if np.max(np.abs(other)) > NOTHING:
            norms.append(np.linalg.norm(one - other) / np.linalg.norm(other))
            logarithms.append(np.abs(np.log(one / other)))
    return float(max(norms)), float(np.quantile(np.concatenate(logarithms), 0.99))


def apart(one: RigResult, other: RigResult) -> float:
    """Root mean square over the FRFs of two campaigns of one plan of ‖FRF − FRF‖ / ‖FRF‖ in the band."""
    first, second = one.campaign.frfs, other.campaign.frfs
    assert first is not None
    assert second is not None
    inside = _inside(one)
    rows = {_label(second, row): row for row in range(len(second))}
    norms = []
    for row in range(len(first)):
        here, there = first.value[row, inside], second.value[rows[_label(first, row)], inside]
        if min(np.max(np.abs(here)), np.max(np.abs(there))) > NOTHING:
            norms.append(np.linalg.norm(here - there) / np.linalg.norm(there))
    return float(np.sqrt(np.mean(np.square(norms))))


def _inside(result: RigResult) -> np.ndarray:
    frfs, band = result.campaign.frfs, result.plan.band
    assert frfs is not None
    return (frfs.frequency >= band[0]) & (frfs.frequency <= band[1])


def _label(frfs: FrfRecords, row: int) -> tuple[int, ...]:
    places = (*frfs.response[row], *frfs.reference[row])
    return int(frfs.posture[row]), int(frfs.trial[row]), *map(int, places)


def main() -> None:
    from tables import write

    rows = []
    for name in ("fanuc_s360", "six_link", "six_axis"):
        robot = flexmodal.load(name)
        bare = simulate_mujoco(robot, **CHECK, **QUIET)
        norm, most = off_the_model(bare)
        rows.append([name, "nothing", "–", f"{norm:.5f}", f"{most:.5f}", "–", "–"])
        for effect in EFFECTS:
            mine = simulate_mujoco(robot, **CHECK, **QUIET, hide=[effect], seed=3)
            rig = simulate(robot, **CHECK, **QUIET, hide=[effect], seed=3)
            assert mine.truth.effects == rig.truth.effects
            where = mine.truth.effects[0].where
            off = [f"{apart(mine, rig):.5f}", f"{apart(mine, bare):.3f}"]
            rows.append([name, effect, where, "–", "–", *off])
    write(
        "rig_mujoco",
        "Campaigns by MuJoCo beside flexmodal",
        "‖FRF − FRF‖ / ‖FRF‖ over the lines from 2 to 200 Hz, no noise, no scatter, no parameter errors; "
        "records of 8 s. With nothing hidden the largest of all FRFs against the robot's own inertance, "
        "and |ln| of the ratio on 99 % of the lines; else the root mean square over the FRFs, against the"
        " rig with the same numbers of the same effect, and against nothing hidden. A link is a chain of "
        "stiff pieces here and a beam in the rig; friction is Jenkins's element here, Dahl's in the rig. "
        "`python benchmarks/mujoco_campaign.py`.",
        ["robot", "hidden", "where", "off the model", "99 % of lines", "off the rig", "off nothing hidden"],
        rows,
    )


if __name__ == "__main__":
    main()
