"""A name or a path to a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from flexmodal.cards import (
    FrozenDict,
    JointCard,
    RobotCard,
    Urdf,
    check_consistency,
    check_masses,
    find,
    find_tool,
    gripper_joints,
    read_card,
    read_urdf,
    shipped_cards,
)
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model.build import build_model
from flexmodal.model.posture import is_number
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
        tool: URDF link that is the end-effector; for a bare URDF the one that its name or place makes it if
            left out. Every robot's end-effector can be called "tool" besides.
        fixed: only for a bare URDF, joints that stay at 0, such as those of a gripper.

    Raises:
        RobotNotFound: nothing answers to that reference.
        InvalidCard, InvalidUrdf, InvalidRequest: what is wrong, all of it.
        MissingExtra: another package stands where Pinocchio should.

    >>> import flexmodal
    >>> robot = flexmodal.load("six_axis")
    >>> robot.tool, list(robot.commanded)
    ('tool', ['q1', 'q2', 'q3', 'q4', 'q5', 'q6'])
    """
    path = find(str(reference))
    if path.suffix == ".urdf":
        urdf = read_urdf(path, fixed=(*gripper_joints(path), *fixed))
        card = _card_for(urdf, stiffness, damping, tool)
    else:
        card = read_card(path)
        _refuse_beside_card(path, stiffness=stiffness, damping=damping, fixed=fixed or None)
        urdf = read_urdf(card.urdf)
        check_consistency(card, urdf)
    return _assemble(card, urdf, tool)


def robots() -> tuple[Robot, ...]:
    """The robots whose cards ship, loaded, in the order of their names.

    Raises:
        InvalidCard, InvalidUrdf, InvalidRequest: see `load`.
    """
    return tuple(load(path) for path in shipped_cards().values())


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
    moving = [joint.name for joint in urdf.joints if joint.movable]
    if not moving:
        raise InvalidRequest(Fault(str(urdf.path), "joints", "none that moves", "at least one"))
    if stiffness is None:
        asked = "--stiffness NUMBER or joint=number,… (a URDF alone does not say how soft its joints are)"
        raise InvalidRequest(Fault(str(urdf.path), "stiffness", "none", asked))
    faults = _faults_of(stiffness, moving, "stiffness", strict=True)
    values = _per_joint(stiffness, moving)
    losses = {} if damping is None else _per_joint(damping, list(values))
    if damping is not None:
        faults += _faults_of(damping, [name for name in moving if name in values], "damping", strict=False)
    if faults:
        raise InvalidRequest(faults)
    joints = {
        name: JointCard(float(values[name]), float(losses.get(name, 0.0)))
        for name in moving
        if name in values
    }
    check_masses(urdf, tuple(joints))
    return RobotCard(
        name=urdf.name or urdf.path.stem,
        title=f"{urdf.path.name}, a bare URDF",
        urdf=urdf.path,
        tool=tool or find_tool(urdf).link,
        source="the URDF; stiffness and damping as given",
        joints=FrozenDict(joints),
        points=FrozenDict(),
        postures=FrozenDict(),
        families=FrozenDict(),
        path=urdf.path,
    )


def _per_joint(given: PerJoint, names: list[str]) -> dict[str, float]:
    return dict(given) if isinstance(given, Mapping) else dict.fromkeys(names, given)


def _faults_of(given: PerJoint, names: list[str], key: str, *, strict: bool) -> list[Fault]:
    """What is wrong with a stiffness of the joints that move, or a damping of those that are flexible."""
    values = _per_joint(given, names)
    allowed = f"a finite number {'above 0' if strict else 'of 0 or more'}"
    kind = "joint that moves" if strict else "flexible joint"
    faults = [
        Fault("call", f"{key} of {name}", f"{value!r}", allowed)
        for name, value in values.items()
        if not is_number(value) or value < 0 or (strict and value == 0)
    ]
    faults += [
        Fault("call", key, f"{name!r}, which is no {kind}", ", ".join(names))
        for name in values
        if name not in names
    ]
    if not values:
        faults.append(Fault("call", key, "no joint", f"at least one of {', '.join(names)}"))
    return faults


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
        joints=FrozenDict({name: card.joints[name] for name in moving if name in card.joints}),
        points=card.points,
        postures=card.postures,
        families=card.families,
        moving=FrozenDict(moving),
        pinocchio=model,
        couplings=card.couplings,
        loss_frequency=card.loss_frequency,
        tolerance=card.tolerance,
        obstacles=card.obstacles,
        srdf=card.srdf,
        path=card.path,
    )
