"""Joints of a URDF and card being changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.cards import JointCard, UrdfJoint
from flexmodal.model import Robot

TURN, SLIDE = 1.0, 0.5
"""Limits of new joints to either side [rad, m]: far beyond what an elastic joint does."""
_SPEED = 1e3
"""Their limit of speed [rad/s, m/s]: none that matters."""

Vector = Float[np.ndarray, "3"]


def new_joint(name: str, kind: str, parent: str, child: str, axis: Vector, xyz: Vector) -> UrdfJoint:
    """A new joint, turned as the link that carries it; with small limits around 0 if it moves.

    Args:
        name: of the joint.
        kind: as in URDFs.
        parent: link that carries it.
        child: link that it carries.
        axis: unit vector in the frame of the joint.
        xyz: where it is, in the frame of the link that carries it [m].
    """
    made = UrdfJoint(name, kind, parent, child, axis, xyz, np.zeros(3), -TURN, TURN, _SPEED)
    return replace(made, lower=-SLIDE, upper=SLIDE) if made.is_prismatic else made


def joint_card(robot: Robot, name: str, values: Mapping[str, float]) -> JointCard:
    """A joint with its new values; bounds and trust are factors of whatever the card says, and stay.

    Args:
        robot: with its card.
        name: of the joint.
        values: stiffness and damping that a fit has found, by `stiffness.JOINT` and `damping.JOINT`.
    """
    joint = robot.joints[name]
    stiffness = float(values.get(f"stiffness.{name}", joint.stiffness))
    damping = float(values.get(f"damping.{name}", joint.damping))
    return replace(joint, stiffness=stiffness, damping=damping)
