"""Is a URDF or a card sound? Everything that loading would find, gathered instead of raised."""

from __future__ import annotations

from pathlib import Path

from flexmodal.cards import (
    RobotCard,
    Urdf,
    check_consistency,
    find,
    gripper_joints,
    read_card,
    read_urdf,
    urdf_named_in,
)
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
            card, urdf = _card_and_urdf(file)
            warnings += urdf.warnings
            check_consistency(card, urdf)
            robot = load(file)
        for posture in robot.postures or [middle(robot.commanded)]:
            robot.at(posture)
    except InvalidInput as error:
        faults += error.faults
    return Report(str(path), tuple(dict.fromkeys(faults)), tuple(warnings))


def _card_and_urdf(file: Path) -> tuple[RobotCard, Urdf]:
    """Both, or the faults of both: a fault of the card does not hide those of its URDF.

    Raises:
        InvalidInput: with every fault of the two files.
    """
    faults: list[Fault] = []
    card, urdf = None, None
    try:
        card = read_card(file)
    except InvalidInput as error:
        faults += error.faults
    address = urdf_named_in(file) if card is None else card.urdf
    if address is not None:
        try:
            urdf = read_urdf(address)
        except InvalidInput as error:
            faults += error.faults
    if card is None or urdf is None:
        raise InvalidInput(faults)
    return card, urdf
