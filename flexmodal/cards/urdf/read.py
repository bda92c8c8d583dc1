"""From the text of a URDF to a `Urdf`."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TypeVar

from lxml import etree

from flexmodal.cards.urdf.joint import parse_joint
from flexmodal.cards.urdf.link import parse_link
from flexmodal.cards.urdf.meshes import mesh_warnings
from flexmodal.cards.urdf.tree import find_root
from flexmodal.cards.urdf.urdf import FIXED, Urdf, UrdfJoint, UrdfLink
from flexmodal.cards.urdf.xml import parse_xml
from flexmodal.errors import InvalidUrdf
from flexmodal.text.words import FaultList, listing

MOST_JOINTS = 100
"""The most movable joints: time and memory of the dynamics grow steeply with them."""
MOST_LINKS = 1000

Part = TypeVar("Part", UrdfLink, UrdfJoint)


def read_urdf(path: str | os.PathLike[str], *, fixed: Collection[str] = ()) -> Urdf:
    """Read a URDF.

    Args:
        path: a URDF; xacro has to be expanded.
        fixed: joints to read as fixed where they stand at 0, such as those of a gripper.

    Returns:
        The robot: one tree of links, its numbers finite, its inertias physical.

    Raises:
        InvalidUrdf: with every fault of the file at once.
    """
    file = Path(os.path.abspath(path))
    tree = parse_xml(file)
    faults = FaultList(file)
    root = tree.getroot()
    _fix(root, fixed, faults)
    links = _named(root, "link", parse_link, faults)
    joints = _named(root, "joint", parse_joint, faults)
    _check_counts(links, joints, faults)
    if faults.faults and (len(links) > MOST_LINKS or not links):
        raise InvalidUrdf(faults.faults)
    base = find_root(links, joints, faults)
    if faults.faults:
        raise InvalidUrdf(faults.faults)
    return Urdf(
        path=file,
        text=etree.tostring(tree, encoding="unicode"),
        name=str(root.get("name") or file.stem),
        root=base,
        links=tuple(links.values()),
        joints=tuple(joints.values()),
        warnings=tuple(_warnings(file, links, joints)),
    )


def _fix(root: etree._Element, fixed: Collection[str], faults: FaultList) -> None:
    """Turn joints into fixed ones in the text itself, so that every reader sees the same robot."""
    joints = {str(joint.get("name")): joint for joint in root.findall("joint")}
    for name in fixed:
        if name not in joints:
            faults.add(f"joint.{name}", "no joint of that name to fix", listing(joints))
            continue
        joints[name].set("type", FIXED)
        for tag in ("mimic", "limit", "axis", "dynamics"):
            for element in joints[name].findall(tag):
                joints[name].remove(element)


def _named(
    root: etree._Element,
    tag: str,
    parse: Callable[[etree._Element, str, FaultList], Part | None],
    faults: FaultList,
) -> dict[str, Part]:
    """All elements of a tag by name; faults for those without a name, or with one that is taken."""
    parts: dict[str, Part] = {}
    seen: set[str] = set()
    for element in root.findall(tag):
        name = element.get("name")
        if not name:
            faults.add(tag, f"a <{tag}> without a name (line {element.sourceline})", f"a name for each {tag}")
            continue
        if name in seen:
            found = f"a second {tag} of that name (line {element.sourceline})"
            faults.add(f"{tag}.{name}", found, "different names")
            continue
        seen.add(name)
        part = parse(element, name, faults)
        if part is not None:
            parts[name] = part
    return parts


def _check_counts(links: dict[str, UrdfLink], joints: dict[str, UrdfJoint], faults: FaultList) -> None:
    if not links:
        faults.add("robot", "no <link>", "at least one link")
    if len(links) > MOST_LINKS:
        faults.add("robot", f"{len(links)} links", f"at most {MOST_LINKS}")
    movable = sum(joint.movable for joint in joints.values())
    if movable > MOST_JOINTS:
        faults.add("robot", f"{movable} movable joints", f"at most {MOST_JOINTS}")
    if "universe" in joints:
        faults.add("joint.universe", "a name that Pinocchio keeps for the world", "another name")


def _warnings(file: Path, links: dict[str, UrdfLink], joints: dict[str, UrdfJoint]) -> list[str]:
    """Sentences about locked joints and mesh files that are not there."""
    locked = [
        f"joint {name} cannot move: its limits are both {joint.lower:g}"
        for name, joint in joints.items()
        if joint.lower == joint.upper
    ]
    return locked + mesh_warnings(file, links.values())
