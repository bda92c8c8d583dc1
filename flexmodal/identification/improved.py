"""The identified robot as a card with its URDF, which loads like any other; never over the old one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lxml import etree

from flexmodal.cards import mesh_path
from flexmodal.errors import Fault, OutputExists
from flexmodal.files import whole_file
from flexmodal.identification.arm import moved_bodies
from flexmodal.model import Robot
from flexmodal.text.words import safe_name
from flexmodal.text.write_toml import toml_text

CARD = "robot.toml"


def write_improved(
    robot: Robot, values: Mapping[str, float], folder: Path, *, source: str, overwrite: bool = False
) -> Path:
    """Write a robot with other numbers.

    Args:
        robot: the one they were found for.
        values: `stiffness.JOINT`, `damping.JOINT`, `mass.LINK`, `inertia.LINK`; what is missing stays.
        folder: gets `robot.toml` and the URDF; made if it is not there.
        source: where the numbers come from, for the card.
        overwrite: replace files that stand there.

    Returns:
        Path of the card.

    Raises:
        OutputExists: a file is there, or the folder is the one that the URDF came from.
    """
    if folder.resolve() == robot.urdf.path.parent.resolve():
        raise OutputExists(Fault(str(folder), "", "the folder of the card's own URDF", "another folder"))
    folder.mkdir(parents=True, exist_ok=True)
    name = f"{safe_name(robot.name)}.urdf"
    card, urdf = folder / CARD, folder / name
    present = [path for path in (card, urdf) if path.exists() and not overwrite]
    if present:
        raise OutputExists([Fault(str(p), "", "an existing file", "a new name, or --force") for p in present])
    for path, text in (
        (urdf, _urdf(robot, values, folder)),
        (card, toml_text(_card(robot, values, name, source))),
    ):
        with whole_file(path, overwrite=overwrite) as scratch:
            scratch.write_text(text, encoding="utf-8")
    return card


def _card(robot: Robot, values: Mapping[str, float], urdf: str, source: str) -> dict[str, Any]:
    joints = {}
    for name, joint in robot.joints.items():
        entry: dict[str, Any] = {"pseudo": True} if joint.pseudo else {}
        entry["stiffness"] = float(values.get(f"stiffness.{name}", joint.stiffness))
        entry["damping"] = float(values.get(f"damping.{name}", joint.damping))
        if joint.rotor_inertia:
            entry["rotor_inertia"] = joint.rotor_inertia
        entry |= {key: v for key in ("lower", "upper", "scale") if (v := getattr(joint, key)) is not None}
        joints[name] = entry
    couplings = {name: {"stiffness": one.stiffness} for name, one in robot.couplings.items()}
    families = {
        name: {"parameter": one.parameter, "from": one.start, "to": one.stop, "follow": dict(one.follow)}
        for name, one in robot.families.items()
    }
    return {
        "format": 1,
        "name": robot.name,
        "title": robot.title,
        "urdf": urdf,
        "tool": robot.tool,
        "source": source,
        "joint": joints,
        **({"coupling": couplings} if couplings else {}),
        "point": {name: {"link": one.link, "xyz": list(one.xyz)} for name, one in robot.points.items()},
        "posture": {name: dict(one) for name, one in robot.postures.items()},
        "family": families,
    }


def _urdf(robot: Robot, values: Mapping[str, float], folder: Path) -> str:
    """The URDF with new masses; moments grow with the mass and with the factor of their own."""
    root = etree.fromstring(robot.urdf.text)
    links = {link.get("name"): link for link in root.findall("link")}
    for name in moved_bodies(robot):
        card = float(robot.urdf.link_by_name[name].mass or 0.0)
        mass = float(values.get(f"mass.{name}", card))
        grown = mass / card * float(values.get(f"inertia.{name}", 1.0))
        if mass == card and grown == 1.0:
            continue
        inertial = links[name].find("inertial")
        inertial.find("mass").set("value", repr(mass))
        inertia = inertial.find("inertia")
        if inertia is not None:
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
                inertia.set(key, repr(float(inertia.get(key)) * grown))
    for mesh in root.iter("mesh"):
        _redirect(mesh, robot.urdf.path, folder)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + etree.tostring(root, encoding="unicode") + "\n"


def _redirect(mesh: Any, urdf: Path, folder: Path) -> None:
    """Let a mesh that lies beside the old URDF be found from the new one."""
    address = str(mesh.get("filename"))
    if "://" not in address:
        found = mesh_path(address, urdf)
        if isinstance(found, Path):
            mesh.set("filename", os.path.relpath(found.resolve(), folder.resolve()))
