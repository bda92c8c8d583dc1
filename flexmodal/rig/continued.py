"""A simulated campaign that goes on: one more posture on the same hidden robot, struck as before."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import flexmodal
from flexmodal.campaign import Campaign, CampaignPosture, read_campaign
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.analyser import RATIO, Analyser
from flexmodal.rig.believed import known_robot
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.hide import Hide, check_hides
from flexmodal.rig.hidden.placement import put_in
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.result import RigResult
from flexmodal.rig.robot_folder import CARD
from flexmodal.rig.simulate import make_stand, struck_campaign
from flexmodal.rig.truth import Truth, truth_path

_RECORDS = "one campaign of the virtual rig, with FRFs"


def continued(
    folder: str | Path, posture: Mapping[str, float], *, advance: Callable[[], None] = lambda: None
) -> RigResult:
    """Take one more posture on the simulated arm of a campaign: every point, reference and trial it has.

    Args:
        folder: of a campaign of the virtual rig; its truth lies beside it.
        posture: angles of the commanded joints [rad, m]; those left out stay at 0.
        advance: called once for each point.

    Returns:
        The whole campaign with the new posture last.

    Raises:
        InvalidRequest: no campaign of the rig, a joint that there is not, a truth that cannot be read.
    """
    place = Path(folder)
    campaign, truth = read_campaign(place), read_truth(truth_path(place))
    robot = flexmodal.load(str(place / CARD))
    plan = _plan(campaign, place)
    conduct = Conduct(truth.noise, truth.scatter, truth.seed)
    number = max(one.id for one in campaign.postures) + 1
    new = CampaignPosture(number, _name(campaign, number), _angles(robot, posture))
    before = make_stand(robot, plan, known_robot(robot, truth.factors))
    stand = replace(before, plan=replace(plan, postures=(new,)))
    wanted = [Hide(one.effect, one.where, dict(one.parameters), form=one.form) for one in truth.effects]
    check_hides(robot, plan.points, wanted, truth.noise)
    hidden, _, _ = put_in(stand, wanted, conduct)
    more = struck_campaign(robot, stand, hidden, conduct, time=bool(campaign.blows), advance=advance)
    whole = replace(
        campaign,
        postures=(*campaign.postures, new),
        frfs=None if campaign.frfs is None or more.frfs is None else campaign.frfs.joined(more.frfs),
        blows=(*campaign.blows, *more.blows),
    )
    plan = replace(plan, postures=whole.postures)
    return RigResult(whole, truth, robot, plan, replace(stand, plan=plan), tuple(hidden))


def next_posture(path: str | Path) -> dict[str, float]:
    """The posture that a diagnosis asked for.

    Args:
        path: of `diagnosis.json`, or of its `next_measurement` by itself.

    Raises:
        InvalidRequest: no such file, no JSON, no measurement asked for, angles that are no numbers.
    """
    allowed = "diagnosis.json, or its next_measurement with a posture"
    try:
        found = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidRequest(Fault(str(path), "", f"a file that cannot be read ({error})", allowed)) from None
    if isinstance(found, dict) and "next_measurement" in found:
        found = found["next_measurement"]
        if found is None:
            raise InvalidRequest(Fault(str(path), "next_measurement", "null: nothing was asked for", allowed))
    posture = found.get("posture") if isinstance(found, dict) else None
    if not isinstance(posture, dict) or not posture:
        raise InvalidRequest(Fault(str(path), "posture", "none", allowed))
    faults = [
        Fault(str(path), f"posture.{name}", repr(value)[:60], "a finite angle [rad] or way [m]")
        for name, value in posture.items()
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value)
    ]
    if faults:
        raise InvalidRequest(faults)
    return {str(name): float(value) for name, value in posture.items()}


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


def _plan(campaign: Campaign, place: Path) -> HammerPlan:
    frfs = campaign.frfs
    if frfs is None or not campaign.trials or any(not one.force_peak for one in campaign.trials):
        raise InvalidRequest(Fault(str(place), "", "no FRFs, or trials without force_peak", _RECORDS))
    references = dict.fromkeys((int(a), int(b)) for a, b in frfs.reference)
    axes = dict.fromkeys(abs(int(axis)) for axis in frfs.response[:, 1])
    seen = set(frfs.response[:, 0].tolist())
    length = campaign.trials[0].record_length or 1 / float(frfs.frequency[1] - frfs.frequency[0])
    rate = RATIO * campaign.band[1]
    return HammerPlan(
        postures=campaign.postures,
        points=tuple(point for point in campaign.points if point.id in seen),
        references=tuple(references),
        axes=tuple(axes),
        trials=campaign.trials,
        band=campaign.band,
        analyser=Analyser(rate, round(length * rate)),
    )


def _name(campaign: Campaign, number: int) -> str:
    taken = {one.name for one in campaign.postures}
    name = f"asked_{number}"
    while name in taken:
        name += "_"
    return name


def _angles(robot: Robot, posture: Mapping[str, float]) -> dict[str, float]:
    found = robot.posture(dict(posture)).values
    return {joint: float(found.get(joint, 0.0)) for joint in robot.commanded}
