"""The robot as the tester believes it to be, as files: `robot/robot.toml` and its URDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from flexmodal.campaign import CampaignPoint, CampaignPosture
from flexmodal.cards import FrozenDict, PointCard
from flexmodal.cards.write import UrdfDraft
from flexmodal.cards.write import write_robot as write_files
from flexmodal.model import Robot
from flexmodal.model.written import card_of
from flexmodal.rig.believed import base_body

CARD = "robot/robot.toml"


def write_robot(
    robot: Robot, folder: Path, postures: Sequence[CampaignPosture], points: Sequence[CampaignPoint]
) -> None:
    """Write the believed robot into a new folder `robot/` inside `folder`.

    Its base has mass, and meshes that lie beside the original are left out.

    Args:
        robot: the robot.
        folder: of the campaign.
        postures: of the campaign; they take the place of the card's.
        points: likewise.

    Raises:
        OutputExists, NotWritten, InvalidCard: see `flexmodal.cards.write.write_robot`.
    """
    place = folder / "robot"
    place.mkdir()
    source = f"the card {robot.name}, as the tester of a simulated campaign believes it to be"
    card = replace(
        card_of(robot, place, source=source),
        points=FrozenDict({point.name: PointCard(point.link, point.xyz) for point in points}),
        postures=FrozenDict({posture.name: FrozenDict(posture.q) for posture in postures}),
    )
    urdf = UrdfDraft(robot.urdf)
    urdf.drop_meshes()
    base = base_body(robot)
    if base is not None:
        urdf.set_body(robot.urdf.root, base.mass, base.com, base.inertia)
    write_files(card, urdf)
