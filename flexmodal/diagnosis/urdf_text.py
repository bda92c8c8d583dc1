"""Elements of a URDF: links, joints, inertials, origins, and inertias that a body can have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.structure.arm import Body

Vector = Float[np.ndarray, "3"]

TURN, SLIDE = 1.0, 0.5
"""Limits of new joints to either side [rad, m]: far beyond what an elastic joint does."""
_ROUNDING = 1e-9


def add_link(tree: etree._Element, name: str, *, first: bool = False) -> etree._Element:
    """A new link, the last or the first."""
    element = etree.Element("link", name=name)
    links = tree.findall("link")
    place = tree.index(links[0] if first else links[-1]) + (not first)
    tree.insert(place, element)
    return element


def add_joint(
    tree: etree._Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    *,
    xyz: Sequence[float] | Vector = (0.0, 0.0, 0.0),
    rpy: Sequence[float] | Vector = (0.0, 0.0, 0.0),
    axis: Vector | None = None,
    before: etree._Element | None = None,
) -> etree._Element:
    """A new joint: fixed, or one with small limits around 0.

    Args:
        tree: the robot.
        name: of the joint.
        kind: its type.
        parent: link that carries it.
        child: link that it carries.
        xyz: origin in the frame of the parent [m].
        rpy: orientation there [rad].
        axis: unit vector in the frame of the joint; none for a fixed one.
        before: a joint to stand before; the last otherwise.
    """
    element = etree.Element("joint", name=name, type=kind)
    etree.SubElement(element, "parent", link=parent)
    etree.SubElement(element, "child", link=child)
    etree.SubElement(element, "origin", xyz=numbers(xyz), rpy=numbers(rpy))
    if axis is not None:
        reach = repr(SLIDE if kind == "prismatic" else TURN)
        etree.SubElement(element, "axis", xyz=numbers(axis))
        etree.SubElement(element, "limit", lower=f"-{reach}", upper=reach, effort="1e6", velocity="1e3")
    if before is None:
        tree.append(element)
    else:
        tree.insert(tree.index(before), element)
    return element


def set_inertial(link: etree._Element, body: Body) -> None:
    """Give a link mass properties, in place of those it has."""
    for old in link.findall("inertial"):
        link.remove(old)
    inertial = etree.Element("inertial")
    etree.SubElement(inertial, "origin", xyz=numbers(body.centre))
    etree.SubElement(inertial, "mass", value=repr(float(body.mass)))
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    entries = {name: repr(float(body.inertia[place])) for name, place in names.items()}
    etree.SubElement(inertial, "inertia", **entries)
    link.insert(0, inertial)


def shift_origin(element: etree._Element, by: Vector) -> None:
    """Move the origin of a joint, visual or collision in the frame of its link [m]."""
    origin = element.find("origin")
    if origin is None:
        origin = etree.SubElement(element, "origin")
    origin.set("xyz", numbers(origin_of(element) + by))


def origin_of(element: etree._Element) -> Vector:
    """Origin of a joint, visual or collision in the frame of its link [m]."""
    origin = element.find("origin")
    text = "0 0 0" if origin is None else str(origin.get("xyz", "0 0 0"))
    return np.array([float(part) for part in text.split()])


def numbers(values: Sequence[float] | Vector) -> str:
    """Numbers as an attribute, so that they are read back as they are."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def nearest_inertia(
    inertia: Float[np.ndarray, "3 3"], normal: Vector | None
) -> tuple[Float[np.ndarray, "3 3"], bool]:
    """An inertia that a body can have, and whether it differs from the one given where it matters.

    A fit changes moments of inertia by factors and may end where one exceeds the sum of the two others. The
    second moments of the mass, tr(I)/2 − I, are what has to be positive: negative ones become 0. In a planar
    chain only the moment about the normal of the plane counts; it is kept, if it is not negative.

    Args:
        inertia: about the mass centre [kg·m²].
        normal: of the plane of a planar chain, in the frame of the link; none for a spatial one.
    """
    spread = np.trace(inertia) / 2 * np.eye(3) - inertia
    values, vectors = np.linalg.eigh((spread + spread.T) / 2)
    size = float(np.abs(values).max())
    if values[0] >= -_ROUNDING * size:
        return inertia, False
    if normal is not None:
        about = max(float(normal @ inertia @ normal), 0.0)
        return about / 2 * (np.eye(3) + np.outer(normal, normal)), bool(normal @ inertia @ normal < 0)
    kept = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.trace(kept) * np.eye(3) - kept, True
