"""The card that a loaded robot has, to be changed and written."""

from __future__ import annotations

import os
from pathlib import Path

from flexmodal.cards import RobotCard
from flexmodal.model.robot import Robot
from flexmodal.text.words import is_card_name, safe_name

CARD = "robot.toml"


def card_of(robot: Robot, folder: Path, *, name: str = "", source: str) -> RobotCard:
    """The card of a robot, with the paths that its files are to have.

    Args:
        robot: as it was loaded.
        folder: where the files are to stand.
        name: of the card; that of the robot if none.
        source: where its numbers come from.
    """
    place = Path(os.path.abspath(folder))
    name = name or (robot.name if is_card_name(robot.name) else safe_name(robot.name))
    return RobotCard(
        name=name,
        title=robot.title or robot.name,
        urdf=place / f"{safe_name(name)}.urdf",
        tool=robot.tool,
        source=source,
        joints=robot.joints,
        points=robot.points,
        postures=robot.postures,
        families=robot.families,
        path=place / CARD,
        couplings=robot.couplings,
        loss_frequency=robot.loss_frequency,
        tolerance=robot.tolerance,
        obstacles=robot.obstacles,
        srdf=robot.srdf,
    )
