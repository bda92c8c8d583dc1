"""`check_soundness`: every finding on a campaign, of its blows, of its FRFs, and beside a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import Campaign, FrfRecords, estimate_frfs
from flexmodal.errors import InvalidInput
from flexmodal.identification import Observations, RobotModel, observe
from flexmodal.identification.compatibility import unmentioned
from flexmodal.identification.model import predict
from flexmodal.model import Robot
from flexmodal.soundness.blows import blow_findings
from flexmodal.soundness.finding import Finding, FindingKind
from flexmodal.soundness.hypotheses import (
    angle_hypotheses,
    frame_hypotheses,
    in_radians,
    record_hypotheses,
)
from flexmodal.soundness.low_corner import corner_findings
from flexmodal.soundness.readings import Models
from flexmodal.soundness.records import record_findings
from flexmodal.soundness.silent import with_silent
from flexmodal.soundness.suspicion import Accepted, accepted
from flexmodal.structure import robot_space
from flexmodal.text.words import listing

_NAMED = 4
_REMEDY: dict[FindingKind, str] = {
    "sign": "turn the sense of this channel in its records, or mount it as its label says",
    "axes swapped": "exchange the two labels in the records, or measure again",
    "points swapped": "exchange the two labels in the records, or measure again",
    "hammer positions swapped": "exchange the two labels in the records, or strike again",
    "scale": "multiply these records, or set the sensitivity right and export again",
    "postures exchanged": "exchange their angles in campaign.toml, after looking at the protocol",
    "joint sign": "turn the sign of this joint in campaign.toml; the controller may count it the other way",
    "axes in another frame": 'say in campaign.toml what they are fixed to: axes = "link" where they turn '
    "with the link, none for the world's; a hammer that struck otherwise than the sensor sat gets a point of "
    "its own",
    "degrees for radians": "angles of campaign.toml are in rad: multiply by π/180",
}


def check_soundness(campaign: Campaign, robot: Robot | None = None) -> tuple[Finding, ...]:
    """Look for everything that goes wrong in a laboratory; nothing is changed.

    Args:
        campaign: what was measured.
        robot: as its card says, to compare with; without it, or where links or joints of the campaign are
            none of its own, only the data by themselves are looked at.
    """
    found = list(blow_findings(campaign))
    if robot is not None and not _belongs(campaign, robot):
        robot = None
    if robot is not None:
        found += _left_out(campaign, robot)
    records = _records(campaign)
    if records is None:
        return tuple(found)
    told = record_findings(campaign, records)
    found += told
    if any(one.kind == "FRFs against blows" for one in told):
        campaign = replace(campaign, frfs=None)  # the blows are nearer to what was measured
    if robot is None:
        return tuple(found)
    observations = _observed(campaign)
    if observations is not None:
        every = _records(campaign) or records
        found += beside_model(with_silent(observations, every), robot)
    return tuple(found)


def beside_model(observations: Observations, robot: Robot) -> list[Finding]:
    """Errors of labels, scales and angles that would bring the records to the model.

    Args:
        observations: what was measured.
        robot: as its card says; not fitted, so that no fit can hide an error.
    """
    model = RobotModel(robot, robot_space(robot))
    card = np.zeros(len(model.space))
    found: list[Finding] = []
    turned = in_radians(observations)
    if turned is not None:
        found.append(_degrees(observations))
        observations = turned
    models = Models(lambda reading: predict(model, card, reading.applied(observations)))
    hypotheses = [
        *angle_hypotheses(observations), *record_hypotheses(observations), *frame_hypotheses(observations)
    ]  # fmt: skip
    explained, told = accepted(observations, models, hypotheses)
    return [*found, *map(_finding, explained), *corner_findings(observations, told)]


def _finding(one: Accepted) -> Finding:
    guess = one.hypothesis
    return Finding(
        guess.kind,
        guess.where,
        f"so read, these records come from {one.before:.2g} to {one.after:.2g} (|ln|) of the card's model",
        "a fit takes it for stiffness, damping or mass",
        _REMEDY[guess.kind],
    )


def _degrees(observations: Observations) -> Finding:
    """Angles that no robot's joint has."""
    most = max(abs(value) for posture in observations.postures for value in posture.q.values())
    return Finding(
        "degrees for radians",
        "all postures",
        f"angles up to {most:.4g}, where a whole turn is 6.28 rad; what follows takes them for degrees",
        "every posture is another one",
        _REMEDY["degrees for radians"],
    )


def _left_out(campaign: Campaign, robot: Robot) -> list[Finding]:
    """Joints that some postures do not mention."""
    found = []
    for joint in robot.commanded:
        silent = [posture.name for posture in campaign.postures if joint not in posture.q]
        if silent:
            found.append(
                Finding(
                    "joint left out",
                    f"{joint} in posture {listing(silent[:_NAMED])}"
                    + (", …" if len(silent) > _NAMED else ""),
                    "campaign.toml does not say where it stood; it is taken to stand at 0, as in a card",
                    "where it did not, every posture is another one",
                    "write every joint that the robot is posed by, those at 0 too",
                )
            )
    return found


def _belongs(campaign: Campaign, robot: Robot) -> bool:
    """Whether the robot has every link and every joint that the campaign names."""
    joints = {name for posture in campaign.postures for name in posture.q}
    links = {point.link for point in campaign.points}
    strange = unmentioned(campaign, robot)
    return not strange and joints <= set(robot.commanded) and links <= set(robot.urdf.link_by_name)


def _records(campaign: Campaign) -> FrfRecords | None:
    if campaign.frfs is not None:
        return campaign.frfs
    if not campaign.blows:
        return None
    try:
        return estimate_frfs(campaign)
    except InvalidInput:
        return None


def _observed(campaign: Campaign) -> Observations | None:
    """What can be compared; None where nothing says how noisy it is, or nothing is above the noise."""
    try:
        return observe(campaign)
    except InvalidInput:
        return None
