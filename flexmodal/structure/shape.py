"""Parameters of shape: mass centres, where a pseudo-joint sits in its link, payload.

The mass matrix is of second degree in each of them and the rows of points are of first degree, so that
central differences of both are their derivatives but for rounding, whatever the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.model import Robot
from flexmodal.structure.arm import Arm, Arms, Body, far_end, moved_bodies
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.parameter import Parameter
from flexmodal.structure.robot_terms import put_together

KINDS = ("mass_centre", "position", "payload")
TRUST = {"mass_centre": 0.05, "position": 0.1, "payload": 0.1}
"""Standard deviation: of a factor; part of the length of both halves of the link; part of the arm's mass."""
STEPS = {"mass_centre": 0.1, "position": 0.01, "payload": 1.0}
"""Of the differences, in the unit of the value."""
WIDEST = 3.0
"""Bounds of a mass centre's factor, and of a payload over the arm's mass."""
KEPT = 0.1
"""Part of either half of a link that a pseudo-joint does not come closer to its end."""


def shape_parameters(robot: Robot, kind: str) -> list[Parameter]:
    """The parameters of one kind that a robot has.

    `mass_centre.LINK` is a factor on the place of the mass centre in the frame of the link, `position.JOINT`
    [m] how much farther out a pseudo-joint sits than the card says, everything else staying in place, and
    `payload.LINK` [kg] a point mass at the tool.

    Args:
        robot: whose parameters.
        kind: one of `KINDS`.
    """
    if kind == "mass_centre":
        links = [name for name in moved_bodies(robot) if np.any(robot.urdf.link_by_name[name].com)]
        return [Parameter(f"{kind}.{name}", "", 1.0, TRUST[kind], 1 / WIDEST, WIDEST) for name in links]
    if kind == "position":
        inside = [name for name, joint in robot.joints.items() if joint.pseudo and _before(robot, name)]
        return [_position(robot, name) for name in inside]
    mass = sum(float(robot.urdf.link_by_name[name].mass or 0.0) for name in moved_bodies(robot))
    most = WIDEST * mass
    return [Parameter(f"{kind}.{robot.tool}", "kg", 0.0, TRUST[kind] * mass, 0.0, most, log=False)]


def outwards(robot: Robot, joint: str) -> Float[np.ndarray, "3"]:
    """Unit vector along which a pseudo-joint's position counts, in the frame of the link it sits in.

    Args:
        robot: with the joint.
        joint: name of the pseudo-joint.
    """
    return robot.urdf.joint_by_name[joint].xyz / _before(robot, joint)


def _before(robot: Robot, joint: str) -> float:
    return float(np.linalg.norm(robot.urdf.joint_by_name[joint].xyz))


def _position(robot: Robot, name: str) -> Parameter:
    before = _before(robot, name)
    after = float(np.linalg.norm(far_end(robot, robot.urdf.joint_by_name[name].child)))
    spread, kept = TRUST["position"] * (before + after), 1 - KEPT
    return Parameter(f"position.{name}", "m", 0.0, spread, -kept * before, kept * after, log=False)


def assembled(arm: Arm | Arms, values: Mapping[str, float]) -> Assembly:
    """The robot in a posture at these parameter values, to be closed.

    Args:
        arm: the robot in one posture or in several.
        values: of parameters by name, in their units.
    """
    assembly = Assembly(arm)
    robot = arm.robot
    for name in robot.joints:
        if out := values.get(f"position.{name}", 0.0):
            parent = robot.urdf.joint_by_name[name].parent
            assembly.move_pivot(name, out * (assembly.axes(parent) @ outwards(robot, name)))
    put_together(assembly, values, {link: _moved(body, link, values) for link, body in arm.bodies.items()})
    if load := values.get(f"payload.{robot.tool}", 0.0):
        assembly.add_body(robot.tool, Body(load, np.zeros(3), np.zeros((3, 3))))
    return assembly


def _moved(body: Body, link: str, values: Mapping[str, float]) -> Body:
    factor = values.get(f"mass_centre.{link}", 1.0)
    return body if factor == 1.0 else replace(body, centre=factor * body.centre)
