"""The identified robot as a card with its URDF, which loads like any other; never over the old one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards import mesh_path
from flexmodal.errors import Fault, OutputExists
from flexmodal.files import whole_file
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.structure.arm import moved_bodies
from flexmodal.structure.shape import outwards
from flexmodal.text.words import safe_name
from flexmodal.text.write_toml import toml_text

CARD = "robot.toml"
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def write_improved(
    robot: Robot, values: Mapping[str, float], folder: Path, *, source: str, overwrite: bool = False
) -> Path:
    """Write a robot with other numbers.

    Args:
        robot: the one they were found for.
        values: by name, as `robot_space` has them; what is missing stays.
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
    joints, shifts = {}, _shifts(robot, values)
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
        "point": {
            name: {"link": one.link, "xyz": (np.array(one.xyz) - shifts.get(one.link, 0.0)).tolist()}
            for name, one in robot.points.items()
        },
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
            for key in INERTIA:
                inertia.set(key, repr(float(inertia.get(key)) * grown))
    for name in moved_bodies(robot):
        if (factor := float(values.get(f"mass_centre.{name}", 1.0))) != 1.0:
            _move(links[name].find("inertial"), (factor - 1) * robot.urdf.link_by_name[name].com)
    if load := float(values.get(f"payload.{robot.tool}", 0.0)):
        _hang(links[robot.tool], load)
    _move_pivots(root, robot, values)
    for mesh in root.iter("mesh"):
        _redirect(mesh, robot.urdf.path, folder)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + etree.tostring(root, encoding="unicode") + "\n"


def _shifts(robot: Robot, values: Mapping[str, float]) -> dict[str, Float[np.ndarray, "3"]]:
    """How far the frame of each link behind a moved pseudo-joint moves, in that frame [m]."""
    placed, found = link_placements(robot, {}), {}
    for name in robot.joints:
        if out := float(values.get(f"position.{name}", 0.0)):
            joint = robot.urdf.joint_by_name[name]
            turn = placed[joint.child][:3, :3].T @ placed[joint.parent][:3, :3]
            found[joint.child] = out * (turn @ outwards(robot, name))
    return found


def _move_pivots(root: Any, robot: Robot, values: Mapping[str, float]) -> None:
    """Put pseudo-joints elsewhere, and what their links carry back to where it was."""
    for link, shift in _shifts(robot, values).items():
        owner = next(one for one in root.findall("link") if one.get("name") == link)
        parts = [part for part in owner if part.tag in ("inertial", "visual", "collision")]
        for joint in root.findall("joint"):
            if joint.find("parent").get("link") == link:
                parts.append(joint)
            if joint.find("child").get("link") == link:
                name = str(joint.get("name"))
                _move(joint, float(values[f"position.{name}"]) * outwards(robot, name))
        for part in parts:
            _move(part, -shift)


def _move(element: Any, shift: Float[np.ndarray, "3"]) -> None:
    """Move the origin of an element."""
    origin = element.find("origin")
    if origin is None:
        origin = etree.SubElement(element, "origin")
        element.insert(0, origin)
    place = np.array([float(part) for part in (origin.get("xyz") or "0 0 0").split()]) + shift
    origin.set("xyz", " ".join(repr(float(part)) for part in place))


def _hang(link: Any, load: float) -> None:
    """A point mass at the origin of a link's frame, beside what mass it has."""
    inertial = link.find("inertial")
    if inertial is None:
        inertial = etree.SubElement(link, "inertial")
        etree.SubElement(inertial, "mass", value=repr(load))
        etree.SubElement(inertial, "inertia", {key: "0" for key in INERTIA})
        return
    mass = float(inertial.find("mass").get("value"))
    inertia, origin = inertial.find("inertia"), inertial.find("origin")
    place = (
        np.zeros(3)
        if origin is None
        else np.array([float(part) for part in origin.get("xyz", "0 0 0").split()])
    )
    turn = np.eye(3) if origin is None else _rotation(origin.get("rpy", "0 0 0"))
    # Two masses about their common centre: μ d², μ = m M/(m + M), in the axes that the moments are given in.
    away, reduced = turn.T @ place, mass * load / (mass + load)
    more = reduced * (away @ away * np.eye(3) - np.outer(away, away))
    for key in INERTIA:
        row, column = ("xyz".index(letter) for letter in key[1:])
        inertia.set(key, repr(float(inertia.get(key)) + float(more[row, column])))
    inertial.find("mass").set("value", repr(mass + load))
    _move(inertial, -place * load / (mass + load))


def _rotation(rpy: str) -> Float[np.ndarray, "3 3"]:
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xyz", [float(part) for part in rpy.split()]).as_matrix()


def _redirect(mesh: Any, urdf: Path, folder: Path) -> None:
    """Let a mesh that lies beside the old URDF be found from the new one."""
    address = str(mesh.get("filename"))
    if "://" not in address:
        found = mesh_path(address, urdf)
        if isinstance(found, Path):
            mesh.set("filename", os.path.relpath(found.resolve(), folder.resolve()))
