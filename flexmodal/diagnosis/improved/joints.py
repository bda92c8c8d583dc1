"""Joints that effects add to a URDF."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.cards import UrdfJoint

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
