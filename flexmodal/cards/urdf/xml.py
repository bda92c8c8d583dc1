"""URDF text to an XML tree, without reading anything but that text, and numbers out of attributes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.errors import Fault, InvalidUrdf
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, shown

LARGEST = 10_000_000
"""The most a URDF may hold [bytes]."""
MOST_ATTRIBUTES = 100
"""The most attributes of one element: the parser behind Pinocchio takes time quadratic in them."""
FURTHEST = 1e4
"""Coordinates of a URDF [m, rad]: no robot reaches ten kilometres."""
MOST_ELEMENTS = 100_000
XACRO = "expand it first: xacro robot.xacro > robot.urdf"
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
"""What both Python and the C++ parsers take for the same number."""


def parse_xml(path: Path) -> etree._ElementTree:
    """Parse a URDF as far as XML goes.

    Raises:
        InvalidUrdf: not a regular file, empty, too large, not XML, with a DTD, or not a <robot>.
    """
    content = read_regular(path, limit=LARGEST, kind="a URDF")
    if isinstance(content, Fault):
        raise InvalidUrdf(content)

    def refuse(found: str, allowed: str) -> InvalidUrdf:
        return InvalidUrdf(Fault(str(path), "", found, allowed))

    if not content.strip():
        raise refuse("an empty file", "a URDF")
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise refuse("a document type declaration", "a URDF without DTD and entities")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        tree = etree.ElementTree(etree.fromstring(content, parser))
    except (etree.XMLSyntaxError, ValueError) as error:
        raise refuse(f"text that is not XML: {error}", "a URDF") from error
    if tree.docinfo.doctype:  # one that was written in UTF-16
        raise refuse("a document type declaration", "a URDF without DTD and entities")
    root = tree.getroot()
    if root.tag != "robot":
        raise refuse(f"the root element <{_short(root.tag)}>", "the root element <robot>")
    _refuse_excess(tree, refuse)
    return tree


def _refuse_excess(tree: etree._ElementTree, refuse: Callable[[str, str], InvalidUrdf]) -> None:
    """Raise where an element has too many attributes, there are too many elements, or xacro is left."""
    xacro, count = "", 0
    for element in tree.iter(etree.Element):
        count += 1
        if len(element.attrib) > MOST_ATTRIBUTES:
            found = f"{len(element.attrib)} attributes on <{_short(element.tag)}> (line {element.sourceline})"
            raise refuse(found, f"at most {MOST_ATTRIBUTES} attributes on an element")
        values = " ".join(str(value) for value in element.attrib.values())
        if element.prefix == "xacro" or "${" in values or "$(" in values:
            xacro = xacro or f"xacro that is not expanded (line {element.sourceline})"
    if xacro:
        raise refuse(xacro, XACRO)
    if count > MOST_ELEMENTS:
        raise refuse(f"{count} elements", f"at most {MOST_ELEMENTS} elements")


def _short(tag: object) -> str:
    text = str(tag)
    return text if len(text) <= 40 else f"{text[:40]}…"


def one_child(element: etree._Element, tag: str, key: str, faults: FaultList) -> etree._Element | None:
    """The child of that tag, if there is one; a fault where there are several.

    Args:
        element: the XML element.
        tag: of the child.
        key: of the element, for the faults.
        faults: where the faults of the file go.
    """
    children = element.findall(tag)
    if len(children) > 1:
        faults.add(f"{key}.{tag}", f"{len(children)} elements <{tag}>", "one")
    return children[0] if children else None


def number(element: etree._Element, name: str, key: str, faults: FaultList, allowed: str) -> float | None:
    """A finite number in an attribute; a fault and None where it is missing or is none.

    Args:
        element: the XML element.
        name: of the attribute.
        key: of the element, for the faults.
        faults: where the faults of the file go.
        allowed: what may stand there, for the faults.
    """
    text = element.get(name)
    if text is None:
        faults.add(key, "nothing", allowed)
        return None
    value = _finite(text)
    if value is None:
        faults.add(key, shown(text), allowed)
    return value


def vector(
    element: etree._Element | None,
    name: str,
    key: str,
    faults: FaultList,
    *,
    default: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Float[np.ndarray, "3"]:
    """Three finite numbers in an attribute; the default where it is missing, also beside a fault.

    Args:
        element: the XML element.
        name: of the attribute.
        key: of the element, for the faults.
        faults: where the faults of the file go.
        default: where there is no attribute.
    """
    text = None if element is None else element.get(name)
    if text is None:
        return np.array(default)
    values = [_finite(part) for part in text.split()]
    numbers = [value for value in values if value is not None]
    if len(values) != 3 or len(numbers) != 3:
        faults.add(key, shown(text), "three finite numbers")
        return np.array(default)
    if max(map(abs, numbers)) > FURTHEST:
        faults.add(key, shown(text), f"three finite numbers of at most {FURTHEST:g}")
        return np.array(default)
    return np.array(numbers)


def _finite(text: str) -> float | None:
    text = text.strip()
    if len(text) > 100 or not NUMBER.fullmatch(text):
        return None
    value = float(text)
    return value if math.isfinite(value) else None
