"""Elements of a URDF, written by yourdfpy, with the numbers exactly as they were given.

yourdfpy holds an origin as a matrix, from which roll, pitch and yaw come back rounded, past a pitch of 90° as
other angles, and mixed at it. Origins are therefore put into its elements as numbers that are read back as
they are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards.urdf.urdf import UrdfJoint, UrdfLink

Vector = Float[np.ndarray, "3"]

EFFORT = 1e6
"""Limit of new joints [N·m, N], which the format wants: nothing here comes near it."""


def link_element(link: UrdfLink) -> etree._Element:
    """A link with its mass properties, which stand along its own axes."""
    from yourdfpy import Inertial, Link

    if link.mass is None:
        return _written(Link(link.name))
    inertia = np.zeros((3, 3)) if link.inertia is None else link.inertia
    inertial = Inertial(np.eye(4), float(link.mass), np.asarray(inertia, dtype=float) + 0.0)
    element = _written(Link(link.name, inertial))
    set_origin(element[0], link.com, np.zeros(3))
    return element


def joint_element(joint: UrdfJoint) -> etree._Element:
    """A joint; one that moves has limits and an axis."""
    from yourdfpy import Joint, Limit

    moves: dict[str, object] = {}
    if joint.movable:
        limit = Limit(EFFORT, joint.velocity, float(joint.lower), float(joint.upper))
        moves = {"axis": np.asarray(joint.axis, dtype=float) + 0.0, "limit": limit}
    element = _written(Joint(joint.name, joint.type, joint.parent, joint.child, np.eye(4), **moves))
    set_origin(element, joint.xyz, joint.rpy)
    return element


def _written(part: object) -> etree._Element:
    """A link or a joint as an element."""
    from yourdfpy import URDF, Joint, Robot

    robot = Robot("one", joints=[part]) if isinstance(part, Joint) else Robot("one", links=[part])
    element: etree._Element = URDF(robot=robot, build_scene_graph=False).write_xml().getroot()[0]
    return element


def origin_of(element: etree._Element) -> tuple[Vector, Vector]:
    """Place [m] and roll, pitch, yaw [rad] of a joint, inertial, visual or collision."""
    origin = element.find("origin")
    texts = ["0 0 0", "0 0 0"] if origin is None else [str(origin.get(k, "0 0 0")) for k in ("xyz", "rpy")]
    xyz, rpy = (np.array([float(part) for part in text.split()]) for text in texts)
    return xyz, rpy


def set_origin(element: etree._Element, xyz: Sequence[float] | Vector, rpy: Vector | None = None) -> None:
    """Put a joint, inertial, visual or collision elsewhere.

    Args:
        element: what has an origin, or gets one.
        xyz: place in the frame of the link [m].
        rpy: roll, pitch, yaw [rad]; as it was if not given.
    """
    origin = element.find("origin")
    if origin is None:
        origin = etree.Element("origin")
        element.insert(0, origin)
    for key, values in (("xyz", xyz), ("rpy", rpy)):
        if values is not None:
            origin.set(key, " ".join(repr(float(value) + 0.0) for value in values))
