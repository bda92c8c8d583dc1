"""The improved robot: URDF and card with what a diagnosis found in them, its parameters re-tuned.

What they cannot hold is said in a note: effects of sensors, which are not of the robot, and effects that
depend on the force of the blow.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

import numpy as np
from lxml import etree

from flexmodal.cards import mesh_path
from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.hypothesis import Placed
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.errors import InvalidPosture
from flexmodal.model import Robot
from flexmodal.text.words import is_card_name, safe_name
from flexmodal.text.write_toml import toml_text

CARD = "robot.toml"


@dataclass(frozen=True, eq=False)
class Extension:
    """A robot as files that are not written yet."""

    robot: Robot
    """As it was believed to be."""
    urdf: etree._Element
    card: dict[str, Any]
    notes: tuple[str, ...]
    """What the files do not hold, or hold differently."""

    def write(self, folder: Path, *, home: Path | None = None) -> Path:
        """Write `robot.toml` and the URDF into an existing folder.

        Args:
            folder: where to.
            home: where the folder will stand in the end, for the addresses of meshes.

        Returns:
            The path of the card.
        """
        urdf = _with_meshes(self.urdf, self.robot, (home or folder).absolute())
        text = etree.tostring(urdf, encoding="unicode")
        (folder / str(self.card["urdf"])).write_text(
            f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n', encoding="utf-8"
        )
        head = "".join(f"# {_line(note)}\n" for note in self.notes)
        path = folder / CARD
        path.write_text(f"{head}\n{toml_text(self.card)}" if head else toml_text(self.card), encoding="utf-8")
        return path


def extend(diagnosis: Diagnosis) -> Extension:
    """Put the parameters and effects of a diagnosis' final model into the robot."""
    model, scene = diagnosis.model, diagnosis.model.context
    values = model.space.values(diagnosis.x)
    draft = Draft(scene.robot, {name: values[name] for name in model.base.names})
    for placed in model.placed:
        if placed.effect.extend is None:
            draft.notes.append(_left_out(placed, model.values_of(placed, values), scene))
        else:
            placed.effect.extend(draft, Placement.still(scene, placed.where, model.values_of(placed, values)))
    urdf = draft.finish()
    etree.indent(urdf)
    return Extension(scene.robot, urdf, _card(draft, diagnosis), tuple(draft.notes))


def _left_out(placed: Placed, values: Mapping[str, float], scene: Context) -> str:
    """Why an effect is not in the files, and what it amounts to."""
    effect = placed.effect
    if effect.read is not None or effect.turn is not None or "response" in effect.variants:
        why = "is of the sensors, not of the robot"
    elif effect.by_force:
        why = "depends on the force of the blow; the joint is here as it is without"
    else:
        why = "says nothing of how it changes the files of a robot"
    own = {p.name for p in effect.parameters(scene, placed.where)}
    found = effect.physical(scene, placed.where, values)
    numbers = ", ".join(f"{k} {v:.4g}" for k, v in found.items() if k in own or "." not in k)
    return f"{effect.name} at {placed.where} ({numbers}) {why}"


def _card(draft: Draft, diagnosis: Diagnosis) -> dict[str, Any]:
    """The card as a table."""
    robot = draft.robot
    found = " and ".join(f"{placed.effect.name} at {placed.where}" for placed in diagnosis.model.placed)
    source = f"the card {robot.name}, re-tuned on the campaign {diagnosis.campaign}"
    card: dict[str, Any] = {
        "format": 1,
        "name": f"{safe_name(robot.name)}_diagnosed",
        "title": robot.title,
        "urdf": f"{safe_name(robot.name)}_diagnosed.urdf",
        "tool": draft.place_of(robot.tool, np.zeros(3))[0],
        "source": f"{source}; with {found}" if found else source,
    }
    if draft.loss_frequency is not None:
        card["loss_frequency"] = draft.loss_frequency
    card["joint"] = draft.joints
    if draft.couplings:
        card["coupling"] = {name: {"stiffness": k} for name, k in draft.couplings.items()}
    card["point"] = _points(draft, diagnosis)
    card["posture"] = {**{name: dict(q) for name, q in robot.postures.items()}, **_postures(robot, diagnosis)}
    card["family"] = {
        name: {"parameter": one.parameter, "from": one.start, "to": one.stop, "follow": dict(one.follow)}
        for name, one in robot.families.items()
    }
    return card


def _points(draft: Draft, diagnosis: Diagnosis) -> dict[str, dict[str, Any]]:
    """The card's points and those of the campaign that it lacks, on the halves where they sit."""
    places = {name: (point.link, point.xyz) for name, point in draft.robot.points.items()}
    for point in diagnosis.model.context.points:
        if is_card_name(point.name):
            places.setdefault(point.name, (point.link, point.xyz))
    found = {}
    for name, (link, xyz) in places.items():
        carrier, place = draft.place_of(link, np.array(xyz, dtype=float))
        found[name] = {"link": carrier, "xyz": [float(value) for value in place]}
    return found


def _postures(robot: Robot, diagnosis: Diagnosis) -> dict[str, dict[str, float]]:
    """Postures of the campaign that the card lacks."""
    found = {}
    for posture in diagnosis.model.context.postures:
        if posture.name in robot.postures or not is_card_name(posture.name):
            continue
        try:
            robot.posture(dict(posture.q))
        except InvalidPosture:
            continue
        found[posture.name] = {name: float(value) for name, value in posture.q.items()}
    return found


def _with_meshes(urdf: etree._Element, robot: Robot, home: Path) -> etree._Element:
    """The URDF with mesh files that were given relative to the old one given relative to its new folder."""
    copied = etree.fromstring(etree.tostring(urdf))
    for mesh in copied.iter("mesh"):
        address = str(mesh.get("filename", ""))
        if urlparse(address).scheme or os.path.isabs(address):
            continue
        found = mesh_path(address, robot.urdf.path)
        if isinstance(found, Path):
            mesh.set("filename", Path(os.path.relpath(found, home)).as_posix())
    return copied


def _line(text: str) -> str:
    """One line of a comment."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
