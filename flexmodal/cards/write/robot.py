"""A robot as a folder: `robot.toml` and the URDF that it names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from flexmodal.cards.card import JointCard, ObstacleCard, RobotCard
from flexmodal.cards.read_card import read_card
from flexmodal.cards.write.urdf import UrdfDraft
from flexmodal.errors import Fault, InvalidCard
from flexmodal.files import whole_set
from flexmodal.text.write_toml import toml_text


def write_robot(
    card: RobotCard,
    urdf: UrdfDraft,
    *,
    notes: Sequence[str] = (),
    home: Path | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a card and its URDF, both or neither, and read both again before they take their names.

    Args:
        card: with the paths that the two files are to have.
        urdf: the robot that it is of.
        notes: sentences that go before the card, as comments.
        home: folder in which they will stand in the end, for the addresses of meshes.
        overwrite: replace files that stand there.

    Returns:
        Path of the card.

    Raises:
        OutputExists: one of the files exists.
        InvalidCard: what was written is not a sound card, or another one.
        InvalidUrdf: likewise of the URDF.
        NotWritten: the disk is full, or the folder may not be written.
    """
    text = "".join(f"# {_line(note)}\n" for note in notes) + "\n" * bool(notes) + toml_text(_table(card))
    with whole_set([card.path, card.urdf], overwrite=overwrite) as scratch:
        made = replace(card, path=scratch / card.path.name, urdf=scratch / card.urdf.name)
        made.path.write_text(text, encoding="utf-8")
        urdf.write(made.urdf, home=home or card.path.parent)
        found = read_card(made.path)
        names = [one.name for one in fields(card)]
        wrong = [name for name in names if getattr(found, name) != getattr(made, name)]
        if wrong:
            allowed = "those that were written"
            raise InvalidCard([Fault(str(card.path), key, "other values", allowed) for key in wrong])
    return card.path


def _table(card: RobotCard) -> dict[str, Any]:
    """The card as it stands in the file, without what says nothing."""
    table: dict[str, Any] = {
        "format": 1, "name": card.name, "title": card.title, "urdf": card.urdf.name, "tool": card.tool,
        "source": card.source,
    }  # fmt: skip
    if card.loss_frequency is not None:
        table["loss_frequency"] = float(card.loss_frequency)
    if card.tolerance:
        table["tolerance"] = _floats(card.tolerance)
    if card.srdf is not None:
        table["srdf"] = str(card.srdf)
    table["joint"] = {name: _joint(joint) for name, joint in card.joints.items()}
    if card.couplings:
        table["coupling"] = {k: {"stiffness": float(one.stiffness)} for k, one in card.couplings.items()}
    table["point"] = {
        name: {"link": one.link, "xyz": list(map(float, one.xyz))} for name, one in card.points.items()
    }
    if card.obstacles:
        table["obstacle"] = {name: _obstacle(one) for name, one in card.obstacles.items()}
    table["posture"] = {name: _floats(one) for name, one in card.postures.items()}
    table["family"] = {
        name: {
            "parameter": one.parameter, "from": float(one.start), "to": float(one.stop),
            "follow": _floats(one.follow),
        }
        for name, one in card.families.items()
    }  # fmt: skip
    return {key: value for key, value in table.items() if value != {}}


def _joint(joint: JointCard) -> dict[str, Any]:
    given = {one.name: getattr(joint, one.name) for one in fields(joint)}
    left = {one.name: one.default for one in fields(joint)}
    return {
        key: value if isinstance(value, bool) else float(value)
        for key, value in given.items()
        if key in ("stiffness", "damping") or value != left[key]
    }


def _obstacle(obstacle: ObstacleCard) -> dict[str, Any]:
    given = {one.name: getattr(obstacle, one.name) for one in fields(obstacle)}
    left = {one.name: one.default for one in fields(obstacle)}
    return {key: _plain(value) for key, value in given.items() if value != left[key]}


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [float(one) for one in value]
    return str(value) if isinstance(value, Path) else value


def _floats(values: Mapping[str, float]) -> dict[str, float]:
    return {name: float(value) for name, value in values.items()}


def _line(text: str) -> str:
    """One line of a comment."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
