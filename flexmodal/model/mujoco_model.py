"""A robot in a posture as a MuJoCo model; springs, dampers, armatures of a MuJoCo model as joints of a card.

MuJoCo's joint is what a card's joint is: a spring `stiffness` about `springref`, a damper `damping` and an
`armature` that is added to the mass matrix. Its springs do not couple joints, and have no loss factor.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from flexmodal.cards import FrozenDict, JointCard
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.files import whole_file
from flexmodal.model.build import pinocchio
from flexmodal.model.chain import FlexibleChain
from flexmodal.model.posture import Pose
from flexmodal.text.extras import extra


def mujoco_text(robot: FlexibleChain, pose: Pose) -> str:
    """The robot as MJCF, its springs at rest in a posture; without gravity, shapes and contacts.

    Rigid joints, which a card leaves out, are fixed where the posture has them. The keyframe "posture" puts
    the model there; its linearisation is the robot's mass, damping and stiffness.

    Args:
        robot: without couplings and loss factors.
        pose: where its springs are at rest.

    Raises:
        InvalidPosture: see `Robot.posture`.
        InvalidRequest: springs that MuJoCo does not have.
    """
    _refuse(robot)
    pin, model = pinocchio(), robot.pinocchio
    values = np.array([robot.posture(pose).values.get(name, 0.0) for name in robot.moving])
    data = model.createData()
    pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), values))
    root = etree.Element("mujoco", model=robot.name)
    etree.SubElement(root, "compiler", angle="radian", autolimits="false", balanceinertia="false")
    etree.SubElement(root, "option", gravity="0 0 0", integrator="implicit")
    bodies = {0: etree.SubElement(root, "worldbody")}
    for joint, name in enumerate(list(model.names)[1:], start=1):
        flexible = robot.joints.get(name)
        place = model.jointPlacements[joint]
        if flexible is None:  # stands still where the posture has it
            place = data.oMi[int(model.parents[joint])].actInv(data.oMi[joint])
        body = etree.SubElement(bodies[int(model.parents[joint])], "body", name=robot.moving[name].child)
        body.set("pos", _numbers(place.translation))
        body.set("quat", _quaternion(place.rotation))
        bodies[joint] = body
        _inertial(body, model.inertias[joint])
        if flexible is not None:
            _joint(body, model, joint, name, flexible, float(values[joint - 1]))
    _tool(robot, bodies, data)
    rest = [value for value, name in zip(values, robot.moving, strict=True) if name in robot.joints]
    keyframe = etree.SubElement(root, "keyframe")
    etree.SubElement(keyframe, "key", name="posture", qpos=_numbers(np.array(rest)))
    etree.indent(root)
    return str(etree.tostring(root, encoding="unicode")) + "\n"


def write_mujoco(robot: FlexibleChain, pose: Pose, path: Path, *, overwrite: bool = False) -> None:
    """Write `mujoco_text` to a file.

    Args:
        robot: as for `mujoco_text`.
        pose: likewise.
        path: a new `.xml` file.
        overwrite: replace a file that stands there.

    Raises:
        InvalidRequest: see `mujoco_text`.
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    text = mujoco_text(robot, pose)
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def joints_of_mujoco(path: str | os.PathLike[str]) -> Mapping[str, JointCard]:
    """Stiffness, damping and rotor inertia of the joints of a MuJoCo model that have a spring, by name.

    MuJoCo itself reads the model, so that its defaults and includes count.

    Args:
        path: of an MJCF file, or a URDF that MuJoCo reads.

    Raises:
        InvalidRequest: MuJoCo cannot read it, or no joint in it has a spring.
        MissingExtra: MuJoCo is not installed.
    """
    mujoco = extra("mujoco", "mujoco", "joints_of_mujoco")
    try:
        model = mujoco.MjModel.from_xml_path(os.fspath(path))
    except ValueError as error:
        raise InvalidRequest(Fault(str(path), "", str(error).strip(), "a model MuJoCo can read")) from None
    kinds = {int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)}
    found = {}
    for number in range(model.njnt):
        joint, place = model.joint(number), int(model.jnt_dofadr[number])
        if int(model.jnt_type[number]) not in kinds:
            continue
        stiffness = float(np.ravel(model.jnt_stiffness[number])[0])
        if stiffness > 0:
            damping = float(np.ravel(model.dof_damping[place])[0])
            armature = float(model.dof_armature[place])
            found[str(joint.name)] = JointCard(stiffness, damping, rotor_inertia=armature)
    if not found:
        raise InvalidRequest(Fault(str(path), "joint", "none with a stiffness above 0", "at least one"))
    return FrozenDict(found)


def _refuse(robot: FlexibleChain) -> None:
    faults = []
    if robot.couplings:
        allowed = "none: MuJoCo has no such spring"
        faults.append(Fault(robot.name, "coupling", "springs across joints", allowed))
    lossy = [name for name, joint in robot.joints.items() if joint.loss_factor]
    if lossy:
        allowed = "none: MuJoCo's springs have no loss factor"
        faults.append(Fault(robot.name, "loss_factor", f"of {', '.join(lossy)}", allowed))
    if faults:
        raise InvalidRequest(faults)


def _joint(body: Any, model: Any, joint: int, name: str, card: JointCard, rest: float) -> None:
    axis = np.array(model.joints[joint].createData().S).reshape(
        6
    )  # (linear, angular) of the joint's own frame
    slides = bool(np.any(axis[:3]))
    etree.SubElement(
        body, "joint", name=name, type="slide" if slides else "hinge",
        axis=_numbers(axis[:3] if slides else axis[3:]), stiffness=repr(float(card.stiffness)),
        damping=repr(float(card.damping)), armature=repr(float(card.rotor_inertia)), springref=repr(rest),
    )  # fmt: skip


def _inertial(body: Any, inertia: Any) -> None:
    """Mass of everything rigidly on the body; about its mass centre, along the axes of the body."""
    if inertia.mass <= 0:
        return
    moment = np.array(inertia.inertia)
    order = [moment[0, 0], moment[1, 1], moment[2, 2], moment[0, 1], moment[0, 2], moment[1, 2]]
    etree.SubElement(
        body, "inertial", pos=_numbers(np.array(inertia.lever)), mass=repr(float(inertia.mass)),
        fullinertia=_numbers(np.array(order)),
    )  # fmt: skip


def _tool(robot: FlexibleChain, bodies: Mapping[int, Any], data: Any) -> None:
    """A site at the end-effector."""
    frame = robot.pinocchio.frames[robot.frame_of(robot.tool)]
    place = frame.placement
    site = etree.SubElement(bodies[int(frame.parentJoint)], "site", name=robot.tool)
    site.set("pos", _numbers(place.translation))
    site.set("quat", _quaternion(place.rotation))


def _numbers(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)


def _quaternion(rotation: np.ndarray) -> str:
    x, y, z, w = pinocchio().Quaternion(np.array(rotation)).coeffs()
    return _numbers(np.array([w, x, y, z]))
