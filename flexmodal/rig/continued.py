"""A simulated campaign that goes on: one more measurement on the same hidden robot, struck as before."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import flexmodal
from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, Trial, read_campaign
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.analyser import RATIO, Analyser
from flexmodal.rig.asked import Asked
from flexmodal.rig.believed import known_robot
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.hide import Hide, check_hides
from flexmodal.rig.hidden.placement import put_in
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.result import RigResult
from flexmodal.rig.robot_folder import CARD
from flexmodal.rig.simulate import make_stand, struck_campaign
from flexmodal.rig.truth import Truth, truth_path
from flexmodal.text.frozen import FrozenDict
from flexmodal.text.words import FaultList, listing

_RECORDS = "one campaign of the virtual rig, with FRFs"
_SAME = 1e-9
"""Largest difference of angles in one posture [rad, m]."""
_AGAIN = 1_000_003
"""Between the seeds of what is struck later in a posture that was struck before."""


def continued(
    folder: str | Path, asked: Asked | Mapping[str, float], *, advance: Callable[[], None] = lambda: None
) -> RigResult:
    """Take one more measurement on the simulated arm of a campaign.

    Args:
        folder: of a campaign of the virtual rig; its truth lies beside it.
        asked: what to measure, or the angles of the commanded joints [rad, m] for every point, reference and
            trial that the campaign has; joints left out stay at 0.
        advance: called once for each point.

    Returns:
        The whole campaign with what is new last.

    Raises:
        InvalidRequest: no campaign of the rig, a joint or point that there is not, a truth that cannot be
            read.
    """
    place = Path(folder)
    campaign, truth = read_campaign(place), read_truth(truth_path(place))
    robot = flexmodal.load(str(place / CARD))
    return measured_besides(campaign, truth, robot, asked, source=str(place), advance=advance)


def measured_besides(
    campaign: Campaign,
    truth: Truth,
    robot: Robot,
    asked: Asked | Mapping[str, float],
    *,
    source: str = "campaign",
    advance: Callable[[], None] = lambda: None,
) -> RigResult:
    """The same of a campaign in memory.

    Args:
        campaign: of the rig.
        truth: what is hidden in it.
        robot: as its card says.
        asked: see `continued`.
        source: what faults name.
        advance: called once for each point.

    Raises:
        InvalidRequest: see `continued`.
    """
    one = asked if isinstance(asked, Asked) else Asked(asked)
    plan = _plan(campaign, source)
    add = _addition(campaign, robot, plan, one, source)
    conduct = Conduct(truth.noise, truth.scatter, truth.seed)
    before = make_stand(robot, plan, known_robot(robot, truth.factors))
    every = (*plan.points, *add.points)
    stand = replace(before, plan=replace(plan, postures=(add.posture,), points=every))
    wanted = [Hide(one.effect, one.where, dict(one.parameters), form=one.form) for one in truth.effects]
    check_hides(robot, plan.points, wanted, truth.noise)
    hidden, _, _ = put_in(stand, wanted, conduct)
    struck = replace(conduct, seed=conduct.seed + _AGAIN * len(campaign.frfs or ())) if add.again else conduct
    there = replace(stand, plan=add.plan)
    more = struck_campaign(robot, there, hidden, struck, time=bool(campaign.blows), advance=advance)
    frfs, blows = more.frfs, more.blows
    sensed = _sensed(campaign) if one.response is None else [one.response[0]]
    if frfs is not None:
        frfs = frfs.take(np.flatnonzero(np.isin(frfs.response[:, 0], sensed)))
    blows = tuple(blow for blow in blows if blow.channels[0][0] in sensed)
    postures = campaign.postures if add.again else (*campaign.postures, add.posture)
    known = {trial.id for trial in campaign.trials}
    whole = replace(
        campaign,
        postures=postures,
        points=(*campaign.points, *add.points),
        trials=(*campaign.trials, *(trial for trial in add.plan.trials if trial.id not in known)),
        frfs=None if campaign.frfs is None or frfs is None else campaign.frfs.joined(frfs),
        blows=(*campaign.blows, *blows),
    )
    plan = replace(plan, postures=whole.postures, points=(*plan.points, *add.points))
    return RigResult(whole, truth, robot, plan, replace(stand, plan=plan), tuple(hidden))


@dataclass(frozen=True, eq=False)
class _Addition:
    """What is struck."""

    posture: CampaignPosture
    again: bool
    """Whether the robot stood there before."""
    points: tuple[CampaignPoint, ...]
    """New ones."""
    plan: HammerPlan


def _addition(campaign: Campaign, robot: Robot, plan: HammerPlan, asked: Asked, source: str) -> _Addition:
    """Posture, points and trials of a measurement; every fault of what is asked for at once."""
    faults = FaultList(Path(source))
    new = _new_points(campaign, robot, asked, faults)
    points = {point.id: point for point in (*campaign.points, *new)}
    for name, place in (("response", asked.response), ("reference", asked.reference)):
        if place is not None and place[0] not in points:
            faults.add(name, f"the point {place[0]}", f"one of {listing(map(str, points))}, or a new point")
    springs = [name for name, joint in robot.joints.items() if not joint.pseudo]
    if strange := sorted(set(asked.locked) - set(springs)):
        faults.add("locked", listing(map(repr, strange)), f"flexible joints: {listing(springs)}")
    names = {point.name for point in points.values()}
    if strange := sorted(set(asked.masses) - names):
        faults.add("masses", listing(map(repr, strange)), f"points: {listing(sorted(names))}")
    if faults.faults:
        raise InvalidRequest(faults.faults)
    trials = _trials(campaign, asked.force_peak)
    used = tuple(points[place[0]] for place in (asked.response, asked.reference) if place is not None)
    used += tuple(one for one in points.values() if one.name in asked.masses)
    posture, again = _posture(campaign, robot, asked, {trial.id for trial in trials})
    there = replace(
        plan,
        postures=(posture,),
        points=(*plan.points, *(one for one in dict.fromkeys(used) if one not in plan.points)),
        references=plan.references if asked.reference is None else (asked.reference,),
        axes=plan.axes if asked.response is None else (abs(asked.response[1]),),
        trials=trials,
    )
    return _Addition(posture, again, new, there)


def _new_points(
    campaign: Campaign, robot: Robot, asked: Asked, faults: FaultList
) -> tuple[CampaignPoint, ...]:
    """Points of the card under the ids that were asked for, their axes fixed to what the others' are."""
    found = []
    for number, name in asked.new_points.items():
        if any(number == one.id and name == one.name for one in campaign.points):
            continue  # asked for and taken before
        taken = [one for one in campaign.points if number == one.id or name == one.name]
        if taken or name not in robot.points:
            free = [one for one in robot.points if all(one != other.name for other in campaign.points)]
            allowed = f"a new id, and one of {listing(free) or 'no point: all are there'}"
            faults.add(f"new_points.{number}", repr(name), allowed)
            continue
        point = robot.points[name]
        x, y, z = (float(value) for value in point.xyz)
        found.append(CampaignPoint(number, name, point.link, (x, y, z), frame=campaign.points[0].frame))
    return tuple(found)


def _trials(campaign: Campaign, peak: float | None) -> tuple[Trial, ...]:
    """Those of the kind of blow that was asked for, a pair of new ones if there is none."""
    if peak is None:
        return campaign.trials
    same = tuple(one for one in campaign.trials if math.isclose(one.force_peak, peak, rel_tol=1e-6))
    if same:
        return same
    last = max(one.id for one in campaign.trials)
    like = replace(campaign.trials[-1], force_peak=peak)
    return replace(like, id=last + 1, repeat_of=None), replace(like, id=last + 2, repeat_of=last + 1)


def _posture(
    campaign: Campaign, robot: Robot, asked: Asked, trials: set[int]
) -> tuple[CampaignPosture, bool]:
    """Where it stands, and whether it stood there before and this was not measured then."""
    angles, masses = _angles(robot, asked.posture), FrozenDict(asked.masses)
    for one in campaign.postures:
        away = [abs(_angles(robot, one.q)[name] - value) for name, value in angles.items()]
        same = max(away, default=0.0) <= _SAME and set(one.locked) == set(asked.locked)
        if same and dict(one.masses) == dict(masses) and not _is_there(campaign, one, asked, trials):
            return one, True
    number = max(one.id for one in campaign.postures) + 1
    return CampaignPosture(number, _name(campaign, number), FrozenDict(angles), asked.locked, masses), False


def _is_there(campaign: Campaign, posture: CampaignPosture, asked: Asked, trials: set[int]) -> bool:
    """Whether a posture has the FRF that is asked for; if none is named, any."""
    frfs = campaign.frfs
    if frfs is None:
        return False
    there = (frfs.posture == posture.id) & np.isin(frfs.trial, sorted(trials))
    for table, place in ((frfs.response, asked.response), (frfs.reference, asked.reference)):
        if place is not None:
            there &= (table[:, 0] == place[0]) & (np.abs(table[:, 1]) == abs(place[1]))
    return bool(there.any())


def read_truth(path: Path) -> Truth:
    """What is hidden in a simulated campaign.

    Args:
        path: of `DIR.truth.toml`.

    Raises:
        InvalidRequest: it is not there or not what the rig writes.
    """
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        return Truth.of_table(table)
    except OSError as error:
        found = error.strerror or "a file that cannot be read"
    except (ValueError, KeyError, TypeError) as error:
        found = f"a file that cannot be read ({error})"
    allowed = "the truth that the rig wrote beside its campaign"
    raise InvalidRequest(Fault(str(path), "", found, allowed))


def _plan(campaign: Campaign, source: str) -> HammerPlan:
    frfs = campaign.frfs
    if frfs is None or not campaign.trials or any(not one.force_peak for one in campaign.trials):
        raise InvalidRequest(Fault(source, "", "no FRFs, or trials without force_peak", _RECORDS))
    references = dict.fromkeys((int(a), int(b)) for a, b in frfs.reference)
    axes = dict.fromkeys(abs(int(axis)) for axis in frfs.response[:, 1])
    length = campaign.trials[0].record_length or 1 / float(frfs.frequency[1] - frfs.frequency[0])
    rate = RATIO * campaign.band[1]
    return HammerPlan(
        postures=campaign.postures,
        points=campaign.points,
        references=tuple(references),
        axes=tuple(axes),
        trials=campaign.trials,
        band=campaign.band,
        analyser=Analyser(rate, round(length * rate)),
    )


def _sensed(campaign: Campaign) -> list[int]:
    """Ids of the points that bore a sensor."""
    return [] if campaign.frfs is None else np.unique(campaign.frfs.response[:, 0]).tolist()


def _name(campaign: Campaign, number: int) -> str:
    taken = {one.name for one in campaign.postures}
    name = f"asked_{number}"
    while name in taken:
        name += "_"
    return name


def _angles(robot: Robot, posture: Mapping[str, float]) -> dict[str, float]:
    found = robot.posture(dict(posture)).values
    return {joint: float(found.get(joint, 0.0)) for joint in robot.commanded}
