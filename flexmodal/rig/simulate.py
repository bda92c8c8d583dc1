"""A campaign on a robot that only exists here, with effects hidden in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.campaign import AxisFrame, Blow, Campaign
from flexmodal.model import Robot
from flexmodal.rig.believed import ParameterError, TrueRobot, true_robot
from flexmodal.rig.clean import peaks as clean_peaks
from flexmodal.rig.effects import Stand
from flexmodal.rig.hammer_test import Conduct, Struck, each_posture
from flexmodal.rig.hidden.hide import Hide
from flexmodal.rig.hidden.placement import put_in
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.plant.build import Hidden
from flexmodal.rig.request import Prepared, prepare
from flexmodal.rig.result import RigResult
from flexmodal.rig.robot_folder import CARD
from flexmodal.rig.truth import Truth


def simulate(
    robot: Robot,
    *,
    postures: int | Sequence[str | Mapping[str, float]] = 7,
    points: int | None = None,
    references: int | Sequence[str] = 2,
    axes: str | None = None,
    frame: AxisFrame = "world",
    trials: int = 4,
    averages: int = 3,
    peaks: Sequence[float] = (60.0, 240.0),
    tip: str = "soft",
    band: tuple[float, float] = (2.0, 200.0),
    record_length: float = 4.0,
    hide: Sequence[str | Hide] = (),
    noise: float = 0.01,
    scatter: float = 1.0,
    parameter_error: float | ParameterError = 0.05,
    seed: int = 0,
    time: bool = True,
    workers: int = 1,
    advance: Callable[[], None] = lambda: None,
) -> RigResult:
    """Simulate a hammer test in the time domain.

    Args:
        robot: as the tester believes it to be; the true one is drawn around it.
        postures: how many, or which; a number takes the card's named postures, then random ones.
        points: how many of the card's points carry the sensor; all if None.
        references: how many hammer positions, or which, as "name:+z".
        axes: directions the sensor measures, such as "xz"; the vertical for a planar chain, else xyz.
        frame: whose axes those of sensor and hammer are: the world's, or those of the link they sit on, with
            which they turn.
        trials: kinds of blows; they go through `peaks` in turn, the second time as repeats.
        averages: blows in each FRF.
        peaks: typical peaks of the blows [N].
        tip: soft, medium or hard.
        band: lines of interest [Hz]; the sampling rate is 2.56 times its end.
        record_length: [s].
        hide: effects, as "EFFECT@WHERE" or `Hide`.
        noise: standard deviation of each channel's noise over the root mean square of its record.
        scatter: multiple of the usual scatter of the blows in peak, place and direction.
        parameter_error: how far the true robot is off the card, as standard deviation of a logarithm.
        seed: of everything drawn.
        time: whether the campaign keeps the time records beside the FRFs.
        workers: threads that strike postures side by side; not a bit of the result depends on it.
        advance: called once for each posture and point.

    Raises:
        InvalidRequest, InvalidPosture: an argument out of its range, an unknown effect or place; all at once.
    """
    prepared = prepare(
        robot, postures=postures, points=points, references=references, axes=axes, frame=frame,
        trials=trials, averages=averages, peaks=peaks, tip=tip, band=band, record_length=record_length,
        hide=hide, noise=noise, scatter=scatter, parameter_error=parameter_error, seed=seed, workers=workers,
    )  # fmt: skip
    return _run(prepared, time, workers, advance)


def _run(prepared: Prepared, time: bool, workers: int, advance: Callable[[], None]) -> RigResult:
    robot, plan, conduct = prepared.robot, prepared.plan, prepared.conduct
    true = true_robot(robot, prepared.error, np.random.default_rng([conduct.seed, 4]))
    stand = make_stand(robot, plan, true)
    hidden, effects, floor = put_in(stand, prepared.wanted, conduct)
    campaign = struck_campaign(robot, stand, hidden, conduct, time=time, workers=workers, advance=advance)
    truth = Truth(robot.name, conduct.seed, conduct.noise, conduct.scatter, floor, effects, true.factors)
    return RigResult(campaign, truth, robot, plan, stand, tuple(hidden))


def struck_campaign(
    robot: Robot,
    stand: Stand,
    hidden: Sequence[Hidden],
    conduct: Conduct,
    *,
    time: bool,
    workers: int = 1,
    advance: Callable[[], None] = lambda: None,
) -> Campaign:
    """Strike every posture of a plan.

    Args:
        robot: as the card says.
        stand: the true robot and its plan.
        hidden: effects put in.
        conduct: noise, scatter and seed.
        time: whether the time records are kept.
        workers: postures struck side by side.
        advance: called once for each posture and point.
    """
    blows: list[Blow] = []
    for posture, struck in each_posture(stand, hidden, conduct, workers, advance):
        blows += _blows(stand.plan, posture.id, struck)
    return _campaign(robot, stand.plan, blows, time)


def make_stand(robot: Robot, plan: HammerPlan, true: TrueRobot) -> Stand:
    """The true robot, and how far it moves when it is struck.

    Args:
        robot: as the card says.
        plan: postures, points, references, trials.
        true: what the hammer really meets.
    """
    bare = Stand(robot, true, plan, {}, {})
    found = [clean_peaks(bare, posture) for posture in plan.postures]
    weak, hard = (choose(trial.force_peak for trial in plan.trials) for choose in (min, max))
    deflection = {
        joint: tuple(float(force * np.median([d[joint] for d, _ in found])) for force in (weak, hard))
        for joint in robot.joints
    }
    acceleration = {p.name: float(hard * np.median([a[p.name] for _, a in found])) for p in plan.points}
    return Stand(robot, true, plan, deflection, acceleration)  # type: ignore[arg-type]


def _blows(plan: HammerPlan, posture: int, struck: Struck) -> list[Blow]:
    """One blow after the other: by trial, and in it by reference, point and average."""
    blows = []
    time = plan.analyser.time
    for t, trial in enumerate(plan.trials):
        sequence = 0
        for r, reference in enumerate(plan.references):
            for p, point in enumerate(plan.points):
                for a in range(trial.averages):
                    sequence += 1
                    blows.append(
                        Blow(
                            posture=posture,
                            trial=trial.id,
                            sequence=sequence,
                            reference=reference,
                            time=time,
                            force=struck.force[t, r, p, a],
                            channels=tuple((point.id, axis) for axis in plan.axes),
                            response=struck.response[t, r, p, a],
                            quantity="acceleration",
                        )
                    )
    return blows


def _campaign(robot: Robot, plan: HammerPlan, blows: list[Blow], time: bool) -> Campaign:
    from flexmodal.campaign import estimate_frfs

    campaign = Campaign(
        title=f"{robot.title}: simulated hammer test",
        robot=CARD,
        band=plan.band,
        postures=plan.postures,
        points=plan.points,
        trials=plan.trials,
        blows=tuple(blows),
    )
    frfs = estimate_frfs(campaign, estimator="H1")
    return replace(campaign, frfs=frfs, blows=campaign.blows if time else ())
