"""What is done to an arm for the length of a measurement: joints locked, known masses bolted on.

Both change what a hammer test can tell: a locked joint takes its spring out of every mode, a mass of known
size lowers each mode by how much its place moves in it. A lock holds one link to the next, so that it acts on
the joint's own coordinate, whatever drives the joint.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.campaign import CampaignPoint, CampaignPosture
from flexmodal.model import Robot
from flexmodal.structure.arm import Arm, Body
from flexmodal.structure.assembly import Assembly

LOCK = 1e4
"""Stiffness of a lock over that of the joint's own spring: what gives beside it moves 10⁻⁴ as far."""


def arm_in(robot: Robot, posture: CampaignPosture, points: Sequence[CampaignPoint]) -> Arm:
    """A robot as it stood in one posture of a campaign.

    Args:
        robot: as believed.
        posture: with what was locked and bolted on.
        points: of the campaign.
    """
    places = {point.name: (point.link, point.xyz) for point in points}
    bolted = tuple((*places[name], float(mass)) for name, mass in posture.masses.items())
    return Arm(robot, dict(posture.q), posture.locked, bolted)


def add_fixtures(assembly: Assembly) -> None:
    """Put what is locked and bolted on into a structure, each in the postures that have it.

    Args:
        assembly: with all motions added.
    """
    arms = assembly.arm
    one = isinstance(arms, Arm)
    locked, bolted = ([arms.locked], [arms.bolted]) if isinstance(arms, Arm) else (arms.locked, arms.bolted)

    def sizes(found: Sequence[float]) -> float | np.ndarray:
        return found[0] if one else np.array(found)

    for name in dict.fromkeys(joint for some in locked for joint in some):
        stiffness = LOCK * assembly.robot.joints[name].stiffness
        held = sizes([stiffness if name in some else 0.0 for some in locked])
        assembly.add_spring(assembly.row(name), held)
    for link, xyz in dict.fromkeys((load[0], load[1]) for some in bolted for load in some):
        each = [sum(mass for *where, mass in some if tuple(where) == (link, xyz)) for some in bolted]
        assembly.add_body(link, Body(sizes(each), np.array(xyz), np.zeros((3, 3))))  # type: ignore[arg-type]
