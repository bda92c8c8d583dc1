"""One <link> element to a `UrdfLink`."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards.urdf.urdf import UrdfLink
from flexmodal.cards.urdf.xml import number, one_child, vector
from flexmodal.text.words import FaultList, shown

ROUNDING = 1e-6
"""Relative error of principal moments that the rounding in a CAD export explains."""
NOTHING = 1e-12
"""Moments below this [kg·m²] are what rounding leaves of a point mass."""


def parse_link(element: etree._Element, name: str, faults: FaultList) -> UrdfLink:
    """Read a link; every number that is not one goes to `faults` and counts as missing.

    Args:
        element: the XML element.
        name: of the link.
        faults: where the faults of the file go.
    """
    key = f"link.{name}"
    meshes = [
        str(mesh.get("filename")) for mesh in element.findall("visual/geometry/mesh") if mesh.get("filename")
    ]
    inertial = one_child(element, "inertial", key, faults)
    if inertial is None:
        return UrdfLink(name, None, np.zeros(3), None, tuple(meshes))
    key = f"{key}.inertial"
    origin = one_child(inertial, "origin", key, faults)
    com = vector(origin, "xyz", f"{key}.origin.xyz", faults)
    rpy = vector(origin, "rpy", f"{key}.origin.rpy", faults)
    mass = _mass(inertial, key, faults)
    inertia = _inertia(inertial, key, faults)
    if inertia is not None:
        turn = rotation(rpy)
        inertia = turn @ inertia @ turn.T
    return UrdfLink(name, mass, com, inertia, tuple(meshes))


def _mass(inertial: etree._Element, key: str, faults: FaultList) -> float | None:
    element = one_child(inertial, "mass", key, faults)
    allowed = "a finite mass in kg, 0 or more"
    if element is None:
        faults.add(f"{key}.mass", "nothing", '<mass value="…"/> in kg')
        return None
    mass = number(element, "value", f"{key}.mass", faults, allowed)
    if mass is not None and mass < 0:
        faults.add(f"{key}.mass", shown(element.get("value")), allowed)
    return mass


def _inertia(inertial: etree._Element, key: str, faults: FaultList) -> Float[np.ndarray, "3 3"] | None:
    element = one_child(inertial, "inertia", key, faults)
    if element is None:
        faults.add(f"{key}.inertia", "nothing", "<inertia> with ixx, ixy, ixz, iyy, iyz and izz in kg·m²")
        return None
    found = {
        name: number(element, name, f"{key}.inertia.{name}", faults, "a finite number in kg·m²")
        for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    }
    values = {name: value for name, value in found.items() if value is not None}
    if len(values) < len(found):
        return None
    inertia = np.array(
        [
            [values["ixx"], values["ixy"], values["ixz"]],
            [values["ixy"], values["iyy"], values["iyz"]],
            [values["ixz"], values["iyz"], values["izz"]],
        ]
    )
    _check_physical(inertia, f"{key}.inertia", faults)
    return inertia


def _check_physical(inertia: Float[np.ndarray, "3 3"], key: str, faults: FaultList) -> None:
    size = float(np.abs(inertia).max())
    if size < NOTHING:
        return
    small, middle, large = np.linalg.eigvalsh(inertia / size) * size
    moments = f"principal moments {small:.6g}, {middle:.6g} and {large:.6g} kg·m²"
    if small < -ROUNDING * size:
        faults.add(key, moments, "moments of inertia that are 0 or more")
    elif small + middle < (1 - ROUNDING) * large:
        faults.add(key, moments, "moments of which none exceeds the sum of the other two, as of any body")


def rotation(rpy: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """The rotation matrix of roll, pitch, yaw [rad] about fixed axes, as URDF has it."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x
