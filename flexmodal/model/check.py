"""Is a URDF or a card sound? Everything that loading would find, gathered instead of raised."""

from __future__ import annotations

from pathlib import Path

from flexmodal.cards import check_consistency, find, gripper_joints, read_card, read_urdf
from flexmodal.errors import Fault, InvalidInput, Report
from flexmodal.model.load import load
from flexmodal.model.posture import middle


def check(path: Path) -> Report:
    """Examine a card with its URDF, or a bare URDF.

    Raises:
        RobotNotFound: there is nothing at that path or of that name.
    """
    file = find(str(path))
    faults: list[Fault] = []
    warnings: list[str] = []
    try:
        if file.suffix == ".urdf":
            urdf = read_urdf(file, fixed=gripper_joints(file))
            warnings += urdf.warnings
            robot = load(file, stiffness=1.0)  # any will do: it has no part in what is checked
        else:
            card = read_card(file)
            urdf = read_urdf(card.urdf)
            warnings += urdf.warnings
            check_consistency(card, urdf)
            robot = load(file)
        for posture in robot.postures or [middle(robot.commanded)]:
            robot.at(posture)
    except InvalidInput as error:
        faults += error.faults
    return Report(str(path), tuple(dict.fromkeys(faults)), tuple(warnings))
