"""The visual geometry of a URDF: what each link looks like, in the frame of the link."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards import Urdf, mesh_path
from flexmodal.cards.urdf.link import rotation
from flexmodal_viewer.meshfile import load_mesh
from flexmodal_viewer.palette import PLAIN, Colour
from flexmodal_viewer.shapes import Box, Cylinder, Mesh, Shape, Sphere

_LARGEST = 1e4
"""A part larger than this [m] is a slip, and would leave the arm a dot in the picture."""


@dataclass(frozen=True, eq=False)
class Visual:
    """One part of a link."""

    link: str
    shape: Shape
    place: Float[np.ndarray, "4 4"]
    """In the frame of the link."""
    colour: Colour


@dataclass(frozen=True, eq=False)
class Looks:
    """What an arm looks like."""

    visuals: tuple[Visual, ...]
    notes: tuple[str, ...]
    """A sentence for each part that cannot be shown."""


def read_looks(urdf: Urdf) -> Looks:
    """Read every visual of a URDF; what cannot be shown is named, not refused."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    root = etree.fromstring(urdf.text.encode(), parser)
    palette = {
        str(material.get("name")): colour
        for material in root.findall("material")
        if (colour := _rgb(material)) is not None
    }
    visuals: list[Visual] = []
    notes: list[str] = []
    for link in root.findall("link"):
        name = str(link.get("name"))
        for element in link.findall("visual"):
            shown = _read_visual(element, name, urdf, palette)
            if isinstance(shown, str):
                notes.append(f"A part of {name} is not shown: {shown}.")
            else:
                visuals += shown
    return Looks(tuple(visuals), tuple(dict.fromkeys(notes)))


def _read_visual(
    element: etree._Element, link: str, urdf: Urdf, palette: dict[str, Colour]
) -> list[Visual] | str:
    place = _origin(element.find("origin"))
    if place is None:
        return "its origin is not made of finite numbers"
    colour = PLAIN
    material = element.find("material")
    if material is not None:
        colour = _rgb(material) or palette.get(str(material.get("name")), PLAIN)
    geometry = element.find("geometry")
    kinds = [] if geometry is None else [child for child in geometry if isinstance(child.tag, str)]
    if len(kinds) != 1:
        return "it has no geometry, or several"
    if kinds[0].tag == "mesh":
        return _read_mesh(kinds[0], link, urdf, place, colour)
    shape = _primitive(kinds[0])
    return shape if isinstance(shape, str) else [Visual(link, shape, place, colour)]


def _primitive(element: etree._Element) -> Shape | str:
    names = {"box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}
    if element.tag not in names:
        return "its geometry is none of box, cylinder, sphere and mesh"
    count = 3 if element.tag == "box" else 1
    values = [
        value for name in names[element.tag] for value in _numbers(element.get(name), count) or [math.nan]
    ]
    if not all(0 < value < _LARGEST for value in values):
        return "its size is not made of positive numbers"
    if element.tag == "box":
        return Box((values[0], values[1], values[2]))
    return Cylinder(*values) if element.tag == "cylinder" else Sphere(*values)


def _read_mesh(
    element: etree._Element, link: str, urdf: Urdf, place: Float[np.ndarray, "4 4"], colour: Colour
) -> list[Visual] | str:
    address = str(element.get("filename", ""))
    scale = _numbers(element.get("scale", "1 1 1"), 3)
    if scale is None:
        return "the scale of its mesh is not made of finite numbers"
    found = mesh_path(address, urdf.path)
    parts = found if isinstance(found, str) else load_mesh(found)
    if isinstance(parts, str):
        # Its name alone: the folders before it may tell more than the page should.
        return f"mesh {PurePosixPath(address).name[:80]}, {parts}"
    return [
        Visual(link, Mesh(mesh.vertices * np.array(scale), mesh.faces), place, own or colour)
        for mesh, own in parts
    ]


def _origin(element: etree._Element | None) -> Float[np.ndarray, "4 4"] | None:
    place = np.eye(4)
    if element is None:
        return place
    xyz, rpy = _numbers(element.get("xyz", "0 0 0"), 3), _numbers(element.get("rpy", "0 0 0"), 3)
    if xyz is None or rpy is None:
        return None
    place[:3, :3] = rotation(np.array(rpy))
    place[:3, 3] = xyz
    return place


def _rgb(material: etree._Element) -> Colour | None:
    colour = material.find("color")
    values = None if colour is None else _numbers(colour.get("rgba"), 4)
    if values is None:
        return None
    red, green, blue = (min(max(value, 0.0), 1.0) for value in values[:3])
    return red, green, blue


def _numbers(text: str | None, count: int) -> list[float] | None:
    try:
        values = [float(part) for part in (text or "").split()]
    except ValueError:
        return None
    return values if len(values) == count and all(map(math.isfinite, values)) else None
