"""The robot as the tester believes it to be, as files: `robot/robot.toml` and its URDF."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lxml import etree

from flexmodal.campaign import CampaignPoint, CampaignPosture
from flexmodal.model import Robot
from flexmodal.rig.believed import base_body
from flexmodal.text.write_toml import toml_text

CARD = "robot/robot.toml"


def write_robot(
    robot: Robot, folder: Path, postures: Sequence[CampaignPosture], points: Sequence[CampaignPoint]
) -> None:
    """Write the believed robot into a new folder `robot/` inside `folder`.

    Args:
        robot: as the card says.
        folder: where `robot/` goes.
        postures: of the campaign.
        points: of the campaign.
    """
    place = folder / "robot"
    place.mkdir()
    (place / f"{_safe(robot.name)}.urdf").write_text(_urdf(robot), encoding="utf-8")
    (place / "robot.toml").write_text(toml_text(_card(robot, postures, points)), encoding="utf-8")


def _safe(name: str) -> str:
    kept = "".join(letter if letter.isalnum() or letter in "_-" else "_" for letter in name)
    return kept[:60] or "robot"


def _card(
    robot: Robot, postures: Sequence[CampaignPosture], points: Sequence[CampaignPoint]
) -> dict[str, Any]:
    joints = {}
    for name, joint in robot.joints.items():
        entry: dict[str, Any] = {"stiffness": joint.stiffness, "damping": joint.damping}
        if joint.pseudo:
            entry = {"pseudo": True, **entry}
        if joint.rotor_inertia:
            entry["rotor_inertia"] = joint.rotor_inertia
        entry |= {k: v for k in ("lower", "upper", "scale") if (v := getattr(joint, k)) is not None}
        joints[name] = entry
    return {
        "format": 1,
        "name": robot.name,
        "title": robot.title,
        "urdf": f"{_safe(robot.name)}.urdf",
        "tool": robot.tool,
        "source": f"the card {robot.name}, as the tester of a simulated campaign believes it to be",
        "joint": joints,
        "point": {point.name: {"link": point.link, "xyz": list(point.xyz)} for point in points},
        "posture": {posture.name: dict(posture.q) for posture in postures},
    }


def _urdf(robot: Robot) -> str:
    """The URDF, with a base that has mass, and without meshes that lie beside the original."""
    root = etree.fromstring(robot.urdf.text)
    for link in root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if mesh is not None and not str(mesh.get("filename")).startswith("package://"):
                link.remove(shape)
    base = base_body(robot)
    if base is not None:
        link = next(link for link in root.findall("link") if link.get("name") == robot.urdf.root)
        for old in link.findall("inertial"):
            link.remove(old)
        inertial = etree.SubElement(link, "inertial")
        etree.SubElement(inertial, "origin", xyz=" ".join(f"{value:.9g}" for value in base.com))
        etree.SubElement(inertial, "mass", value=repr(float(base.mass)))
        moment = repr(float(base.inertia[0, 0]))
        etree.SubElement(inertial, "inertia", ixx=moment, ixy="0", ixz="0", iyy=moment, iyz="0", izz=moment)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + etree.tostring(root, encoding="unicode") + "\n"
