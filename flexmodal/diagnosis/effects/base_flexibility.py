"""The foundation gives: the root link tilts and shifts on springs, all of it at once.

Three coordinates under a planar chain, six under a spatial one. The springs meet somewhere below the root or
beside it, are not equally stiff every way, in space along and about two level axes that may be turned from
those of the root, and carry a foundation with a mass of its own. The inertia of the root link counts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, carried
from flexmodal.structure.assembly import Assembly

SIDEWAYS = {"base y": "sideways", "base ry": "tilt"}
"""Coordinates in space that have ratios to those along and about x."""


def motions(normal: np.ndarray | None) -> tuple[list[str], np.ndarray]:
    """Names and motions [6, coordinate]: along, up, tilt; or x, y, z, rx, ry, rz."""
    if normal is None:
        return ["base x", "base y", "base z", "base rx", "base ry", "base rz"], np.eye(6)
    level = np.cross(normal, np.array([0.0, 0.0, 1.0]))
    level = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-9 else np.array([1.0, 0.0, 0.0])
    motion = np.zeros((6, 3))
    motion[:3, 0], motion[:3, 1], motion[3:, 2] = level, np.cross(level, normal), normal
    return ["base x", "base z", "base tilt"], motion


def sizes(context: Context) -> tuple[float, float]:
    """A tilt and a translational stiffness that the stiffest joint and the length of the arm suggest."""
    tilt = 10 * max(float(joint.stiffness) for joint in context.robot.joints.values())
    return tilt, 3 * tilt / _length(context) ** 2


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Springs and dampers; where they meet, how their stiffness differs by direction, the foundation's mass.

    What a simple foundation does not need stays near its prior's centre: ratios of 1, no offset, next to no
    mass.
    """
    tilt, shift = sizes(context)
    mass, length = context.arm_mass, _length(context)
    found = [
        positive("horizontal_stiffness", "N/m", shift, 2.0, shift / 1e3, shift * 1e4),
        positive("vertical_stiffness", "N/m", shift * 1.5, 2.0, shift / 1e3, shift * 1e4),
        positive("tilt_stiffness", "N·m/rad", tilt, 2.0, tilt / 1e3, tilt * 1e4),
        positive("translation_damping", "N·s/m", shift * 3e-4, 2.0, shift * 1e-8, shift),
        positive("tilt_damping", "N·m·s/rad", tilt * 3e-4, 2.0, tilt * 1e-8, tilt),
        positive("vertical_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
        signed("aside", "m", 0.1 * length, -length, length),
        signed("below", "m", 0.15 * length, -length, length),
        positive("mass", "kg", 0.01 * mass, 2.5, 1e-5 * mass, 50 * mass),
        signed("mass_below", "m", 0.15 * length, -length, length),
        positive("gyration", "m", 0.15 * length, 1.0, 1e-3 * length, 3 * length),
    ]
    if context.normal is None:
        found += [
            positive("twist_stiffness", "N·m/rad", 2 * tilt, 2.0, tilt / 1e3, tilt * 1e4),
            positive("sideways_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("tilt_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("sideways_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("tilt_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("twist_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            signed("ahead", "m", 0.1 * length, -length, length),
            signed("angle", "rad", 0.8, -1.6, 1.6),
        ]
    return tuple(found)


def _length(context: Context) -> float:
    return max(sum(float(np.linalg.norm(context.reach(link))) for link in context.links), 1e-3)


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    tilt, shift = sizes(context)
    grid = [
        (tilting * tilt, shifting * shift, heavy)
        for tilting in (0.03, 0.1, 0.3, 1.0, 5.0, 30.0, 200.0)
        for shifting in (0.1, 0.5, 2.0, 8.0, 40.0, 300.0, 2000.0)
        for heavy in (0.0, 2.0)
    ]
    found: list[Mapping[str, float]] = []
    for turn, across, heavy in grid:
        start = {
            "horizontal_stiffness": across,
            "vertical_stiffness": 1.5 * across,
            "tilt_stiffness": turn,
            "twist_stiffness": 2 * turn,
            "translation_damping": 3e-4 * across,
            "tilt_damping": 3e-4 * turn,
        }
        found.append({**start, "mass": heavy * context.arm_mass} if heavy else start)
    turned = found[::4] if context.normal is None else []
    return found + [{**start, "tilt_ratio": 2.0, "angle": 0.8} for start in turned]


def _shape(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    assembly.move_root(assembly.add_coordinates(names), motion)


def centre_of(placement: Placement) -> np.ndarray:
    """Where the springs meet, in the world [m]; the root's origin is at 0."""
    return aside_of(placement) - placement["below"] * np.array([0.0, 0.0, 1.0])


def aside_of(placement: Placement) -> np.ndarray:
    """The upright axis that the springs are about, in the world [m]; the root's origin is at 0."""
    _, motion = motions(placement.context.normal)
    if placement.context.normal is not None:
        return placement["aside"] * motion[:3, 0]
    return np.array([placement["aside"], placement["ahead"], 0.0])


def _turn(angle: float) -> np.ndarray:
    """Level axes of six motions turned about the upright one."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = np.eye(6)
    for first in (0, 3):
        turned[first : first + 2, first : first + 2] = [[cosine, -sine], [sine, cosine]]
    return turned


def _springs(placement: Placement) -> list[tuple[str, np.ndarray, float, float]]:
    """Name and motion of each coordinate, its stiffness and damping."""
    names, motion = motions(placement.context.normal)
    if placement.context.normal is None:
        motion = motion @ _turn(placement["angle"])
    found = []
    for name, way in zip(names, motion.T, strict=True):
        kind = "tilt" if way[3:].any() else "vertical" if abs(way[2]) > 0.5 else "horizontal"
        upright = placement.context.normal is None and abs(way[5]) > 0.5
        stiffness = placement["twist_stiffness" if upright else f"{kind}_stiffness"]
        damping = placement["tilt_damping" if kind == "tilt" else "translation_damping"]
        if kind == "vertical":
            damping *= placement["vertical_damping_ratio"]
        elif upright:
            damping *= placement["twist_damping_ratio"]
        elif name in SIDEWAYS:
            stiffness *= placement[f"{SIDEWAYS[name]}_ratio"]
            damping *= placement[f"{SIDEWAYS[name]}_damping_ratio"]
        found.append((name, way, stiffness, damping))
    return found


def _act(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    own = np.array([assembly.row(name) for name in names])
    there = carried(motion, centre_of(placement)) @ own
    for _, way, stiffness, damping in _springs(placement):
        row = way @ there
        assembly.add_spring(row, stiffness)
        assembly.add_damper(row, damping)
    middle = _mass_centre(placement)
    inertia = placement["mass"] * placement["gyration"] ** 2
    for row, way in zip(motion.T @ carried(motion, middle) @ own, motion.T, strict=True):
        assembly.add_inertia(row, inertia if way[3:].any() else placement["mass"])


def _mass_centre(placement: Placement) -> np.ndarray:
    return aside_of(placement) - placement["mass_below"] * np.array([0.0, 0.0, 1.0])


def _extend(draft: Draft, placement: Placement) -> None:
    motions = []
    for name, way, stiffness, damping in _springs(placement):
        joint, turns = draft.fresh(name.replace(" ", "_")), bool(way[3:].any())
        motions.append((joint, way[3:] if turns else way[:3], turns))
        draft.flexible(joint, stiffness, damping)
    draft.under_root(motions, centre_of(placement))
    root = draft.robot.urdf.root
    inertia = placement["mass"] * placement["gyration"] ** 2 * np.eye(3)
    body = Body(placement["mass"], _mass_centre(placement), inertia)
    draft.attach(root, body, name="foundation_mass")


EFFECT = Effect(
    name="base_flexibility",
    says="the foundation gives way",
    places=lambda context: ("base",),
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
)
