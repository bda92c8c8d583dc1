"""A name or a path to a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from flexmodal.cards import (
    JointCard,
    RobotCard,
    Urdf,
    check_masses,
    check_together,
    find,
    gripper_joints,
    read_card,
    read_urdf,
)
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model.build import build_model
from flexmodal.model.robot import Robot

PerJoint = float | Mapping[str, float]
"""One number for every joint, or a number for each joint named."""


def load(
    reference: str | Path,
    *,
    stiffness: PerJoint | None = None,
    damping: PerJoint | None = None,
    tool: str | None = None,
    fixed: Sequence[str] = (),
) -> Robot:
    """Load a robot.

    Args:
        reference: name of a shipped card, path to a `robot.toml`, name of an example arm, or path to a
            bare URDF.
        stiffness: only for a bare URDF, joint stiffness [N·m/rad, N/m]: one number for all joints that
            move, or by name; joints left out are rigid.
        damping: only for a bare URDF, joint damping [N·m·s/rad, N·s/m]; undamped if left out.
        tool: URDF link that is the end-effector; for a bare URDF the last link if left out.
        fixed: only for a bare URDF, joints that stay at 0, such as those of a gripper.

    Raises:
        RobotNotFound: nothing answers to that reference.
        InvalidCard, InvalidUrdf, InvalidRequest: what is wrong, all of it.
    """
    path = find(str(reference))
    if path.suffix == ".urdf":
        urdf = read_urdf(path, fixed=(*gripper_joints(path), *fixed))
        card = _card_for(urdf, stiffness, damping, tool)
    else:
        card = read_card(path)
        _refuse_beside_card(path, stiffness=stiffness, damping=damping, fixed=fixed or None)
        urdf = read_urdf(card.urdf)
        check_together(card, urdf)
    return _assemble(card, urdf, tool)


def _refuse_beside_card(path: Path, **given: object) -> None:
    faults = [
        Fault("call", name, "a value", f"nothing: {path} says it, or a bare URDF")
        for name, value in given.items()
        if value is not None
    ]
    if faults:
        raise InvalidRequest(faults)


def _card_for(
    urdf: Urdf, stiffness: PerJoint | None, damping: PerJoint | None, tool: str | None
) -> RobotCard:
    moving = [joint.name for joint in urdf.joints if joint.type != "fixed"]
    if not moving:
        raise InvalidRequest(Fault(str(urdf.path), "joints", "none that moves", "at least one"))
    if stiffness is None:
        asked = "--stiffness NUMBER or joint=number,… (a URDF alone does not say how soft its joints are)"
        raise InvalidRequest(Fault(str(urdf.path), "stiffness", "none", asked))
    values = _per_joint(stiffness, moving, "stiffness", 0.0, strict=True)
    losses = _per_joint(0.0 if damping is None else damping, moving, "damping", 0.0, strict=False)
    joints = {name: JointCard(values[name], losses.get(name, 0.0)) for name in moving if name in values}
    check_masses(urdf, tuple(joints))
    empty: Mapping[str, object] = MappingProxyType({})
    return RobotCard(
        name=urdf.name or urdf.path.stem,
        title=f"{urdf.path.name}, a bare URDF",
        urdf=urdf.path,
        tool=tool or _last_link(urdf),
        source="the URDF; stiffness and damping as given",
        joints=MappingProxyType(joints),
        points=empty,  # type: ignore[arg-type]
        postures=empty,  # type: ignore[arg-type]
        families=empty,  # type: ignore[arg-type]
        path=urdf.path,
    )


def _per_joint(
    given: PerJoint, moving: list[str], key: str, least: float, *, strict: bool
) -> dict[str, float]:
    values = dict(given) if isinstance(given, Mapping) else dict.fromkeys(moving, given)
    allowed = f"a finite number {'>' if strict else '≥'} {least:g}"
    faults = [
        Fault("call", f"{key} of {name}", f"{value!r}", allowed)
        for name, value in values.items()
        if isinstance(value, bool) or not math.isfinite(value) or value < least or (strict and value == least)
    ]
    faults += [
        Fault("call", key, f"unknown joint {name!r}", ", ".join(moving))
        for name in values
        if name not in moving
    ]
    if not values:
        faults.append(Fault("call", key, "no joint", f"at least one of {', '.join(moving)}"))
    if faults:
        raise InvalidRequest(faults)
    return {name: float(value) for name, value in values.items()}


def _last_link(urdf: Urdf) -> str:
    """The one link that carries no other, or the first such after the longest chain of joints."""
    parent = {joint.child: joint.parent for joint in urdf.joints}
    carriers = {joint.parent for joint in urdf.joints}

    def depth(link: str) -> int:
        count = 0
        while link in parent:
            link, count = parent[link], count + 1
        return count

    return max((link.name for link in urdf.links if link.name not in carriers), key=depth)


def _assemble(card: RobotCard, urdf: Urdf, tool: str | None) -> Robot:
    links = {link.name for link in urdf.links}
    if tool is not None and tool not in links:
        raise InvalidRequest(
            Fault("call", "tool", repr(tool), f"a link of {urdf.path}: {', '.join(sorted(links))}")
        )
    rotors = {name: joint.rotor_inertia for name, joint in card.joints.items() if joint.rotor_inertia}
    model = build_model(urdf, card.points, rotors)
    described = {joint.name: joint for joint in urdf.joints}
    moving = {name: described[name] for name in list(model.names)[1:]}
    return Robot(
        name=card.name,
        title=card.title,
        urdf=urdf,
        tool=tool or card.tool,
        joints=MappingProxyType({name: card.joints[name] for name in moving if name in card.joints}),
        points=card.points,
        postures=card.postures,
        families=card.families,
        moving=MappingProxyType(moving),
        pinocchio=model,
    )
