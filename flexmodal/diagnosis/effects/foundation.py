"""A foundation: the motions it gives the root link, where its springs meet, how stiff each of them is."""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.structure.arm import crossed

Spring = tuple[str, np.ndarray, float, float]
"""Name and motion of a coordinate, its stiffness and damping."""
SIDEWAYS = {"base y": "sideways", "base ry": "tilt"}
"""Coordinates in space that have ratios to those along and about x."""


def motions(normal: np.ndarray | None) -> tuple[list[str], np.ndarray]:
    """Names and motions [6, coordinate]: along, up, tilt; or x, y, z, rx, ry, rz."""
    names, motion = _motions(None if normal is None else tuple(normal.tolist()))
    return list(names), motion


@lru_cache(maxsize=64)
def _motions(normal: tuple[float, ...] | None) -> tuple[tuple[str, ...], np.ndarray]:
    """The same of a normal by its numbers; every evaluation of an effect asks for them."""
    names: tuple[str, ...]
    if normal is None:
        names, motion = ("base x", "base y", "base z", "base rx", "base ry", "base rz"), np.eye(6)
    else:
        across = np.array(normal)
        level = crossed(across, np.array([0.0, 0.0, 1.0]))
        level = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-9 else np.array([1.0, 0.0, 0.0])
        names, motion = ("base x", "base z", "base tilt"), np.zeros((6, 3))
        motion[:3, 0], motion[:3, 1], motion[3:, 2] = level, crossed(level, across), across
    motion.setflags(write=False)
    return names, motion


def terms(context: Context) -> list[tuple[int, int]]:
    """Coordinates of the foundation that have a compliance, by themselves or between two.

    Where springs do not meet at the root's origin a force there also tilts it: in a plane along and up with
    the tilt, in space along x with ry and along y with rx.
    """
    count = len(motions(context.normal)[0])
    return [(k, k) for k in range(count)] + ([(0, 2), (1, 2)] if count == 3 else [(0, 4), (1, 3)])


def every_term(context: Context) -> list[tuple[int, int]]:
    """Any two of the coordinates: several springs and masses, each about an axis of its own."""
    return list(combinations_with_replacement(range(len(motions(context.normal)[0])), 2))


def sizes(context: Context) -> tuple[float, float]:
    """A tilt and a translational stiffness that the stiffest joint and the length of the arm suggest."""
    tilt = 10 * max(float(joint.stiffness) for joint in context.robot.joints.values())
    return tilt, 3 * tilt / length_of(context) ** 2


def length_of(context: Context) -> float:
    """Of all links together [m]."""
    return max(sum(float(np.linalg.norm(context.reach(link))) for link in context.links), 1e-3)


def centre_of(placement: Placement) -> np.ndarray:
    """Where the springs meet, in the world [m]; the root's origin is at 0."""
    return aside_of(placement) - placement["below"] * np.array([0.0, 0.0, 1.0])


def aside_of(placement: Placement) -> np.ndarray:
    """The upright axis that the springs are about, in the world [m]; the root's origin is at 0."""
    return _level(placement, "aside", "ahead")


def _level(placement: Placement, aside: str, ahead: str) -> np.ndarray:
    """A level place by parameters, the second of which an arm in a plane lacks."""
    if placement.context.normal is not None:
        return placement[aside] * motions(placement.context.normal)[1][:3, 0]
    return np.array([placement[aside], placement[ahead], 0.0])


def _turn(angle: float) -> np.ndarray:
    """Level axes of six motions turned about the upright one."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = np.eye(6)
    for first in (0, 3):
        turned[first : first + 2, first : first + 2] = [[cosine, -sine], [sine, cosine]]
    return turned


def springs(placement: Placement) -> list[Spring]:
    """Of each coordinate."""
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


def mass_centre(placement: Placement) -> np.ndarray:
    """Of the foundation, in the world [m]; the root's origin is at 0."""
    beside = _level(placement, "mass_aside", "mass_ahead")
    return aside_of(placement) + beside - placement["mass_below"] * np.array([0.0, 0.0, 1.0])


def inertias(placement: Placement) -> np.ndarray:
    """Of the foundation along and about the directions of its coordinates, at its centre [kg, kg·m²]."""
    _, motion = motions(placement.context.normal)
    turning = placement["mass"] * placement["gyration"] ** 2
    return np.where(motion[3:].any(axis=0), turning, placement["mass"])
