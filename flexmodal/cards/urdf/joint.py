"""One <joint> element to a `UrdfJoint`."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards.urdf.urdf import FIXED, MOVABLE, UrdfJoint
from flexmodal.cards.urdf.xml import number, one_child, vector
from flexmodal.text.words import FaultList, shown

TYPES = "revolute, continuous, prismatic or fixed"
SHORTEST, LONGEST = 1e-6, 1e6
"""Lengths between which an axis is a direction: outside, its square is lost to rounding somewhere."""
FIX = "a gripper's can be fixed: --fix joint,…"
SEVERAL = "split it into revolute and prismatic joints, one degree of freedom each"


def parse_joint(element: etree._Element, name: str, faults: FaultList) -> UrdfJoint | None:
    """Read a joint; None where one of its links is missing, which goes to `faults`.

    Args:
        element: the XML element.
        name: of the joint.
        faults: where the faults of the file go.
    """
    key = f"joint.{name}"
    kind = _type(element, key, faults)
    parent = _end(element, "parent", key, faults)
    child = _end(element, "child", key, faults)
    if element.find("mimic") is not None:
        faults.add(f"{key}.mimic", "a joint that mimics another", f"joints that move by themselves; {FIX}")
    origin = one_child(element, "origin", key, faults)
    xyz = vector(origin, "xyz", f"{key}.origin.xyz", faults)
    rpy = vector(origin, "rpy", f"{key}.origin.rpy", faults)
    axis = np.array([1.0, 0.0, 0.0])
    lower, upper, velocity = -math.inf, math.inf, None
    if kind in MOVABLE:
        axis = _axis(element, key, faults)
        lower, upper, velocity = _limits(element, str(kind), key, faults)
    if parent is None or child is None:
        return None
    return UrdfJoint(name, kind or FIXED, parent, child, axis, xyz, rpy, lower, upper, velocity)


def _type(element: etree._Element, key: str, faults: FaultList) -> str | None:
    kind = element.get("type")
    if kind in (*MOVABLE, FIXED):
        return kind
    if kind in ("floating", "planar", "spherical"):
        faults.add(f"{key}.type", f'"{kind}", which has several degrees of freedom', f"{TYPES}; {SEVERAL}")
    else:
        faults.add(f"{key}.type", "nothing" if kind is None else shown(kind), TYPES)
    return None


def _end(element: etree._Element, tag: str, key: str, faults: FaultList) -> str | None:
    """The link at one end of the joint."""
    end = one_child(element, tag, key, faults)
    link = None if end is None else end.get("link")
    if not link:
        faults.add(f"{key}.{tag}", "nothing", f'<{tag} link="…"/>')
        return None
    return link


def _axis(element: etree._Element, key: str, faults: FaultList) -> Float[np.ndarray, "3"]:
    found = one_child(element, "axis", key, faults)
    axis = vector(found, "xyz", f"{key}.axis", faults, default=(1.0, 0.0, 0.0))
    if not SHORTEST < float(np.abs(axis).max()) < LONGEST:
        text = "" if found is None else str(found.get("xyz"))
        faults.add(f"{key}.axis", shown(text), "a direction: three numbers, not all 0, best of length 1")
        return np.array([1.0, 0.0, 0.0])
    return axis / np.linalg.norm(axis)


def _limits(
    element: etree._Element, kind: str, key: str, faults: FaultList
) -> tuple[float, float, float | None]:
    """Lower and upper limit and speed limit; a continuous joint has no bounds."""
    limit, key = one_child(element, "limit", key, faults), f"{key}.limit"
    if limit is None:
        if kind != "continuous":
            faults.add(key, "nothing", "<limit> with lower, upper, effort and velocity")
        return -math.inf, math.inf, None
    # The format wants both, and Pinocchio refuses the file without them.
    velocity = number(limit, "velocity", f"{key}.velocity", faults, "a finite number")
    number(limit, "effort", f"{key}.effort", faults, "a finite number")
    if kind == "continuous":
        return -math.inf, math.inf, velocity
    lower = _bound(limit, "lower", -math.inf, key, faults)
    upper = _bound(limit, "upper", math.inf, key, faults)
    if lower > upper:
        faults.add(key, f"lower {lower:g} above upper {upper:g}", "lower below upper")
    return lower, upper, velocity


def _bound(limit: etree._Element, name: str, unknown: float, key: str, faults: FaultList) -> float:
    """A limit, which the format takes as 0 where it is left out; `unknown` where it is no number."""
    if limit.get(name) is None:
        return 0.0
    allowed = "a finite number in rad (m for a prismatic joint)"
    value = number(limit, name, f"{key}.{name}", faults, allowed)
    return unknown if value is None else value
