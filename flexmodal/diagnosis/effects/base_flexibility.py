"""The foundation gives: the root link tilts and shifts on springs, all of it at once.

Three coordinates under a planar chain, six under a spatial one. The inertia of the root link counts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly


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
    length = sum(float(np.linalg.norm(context.reach(link))) for link in context.links)
    return tilt, 3 * tilt / max(length, 1e-3) ** 2


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    tilt, shift = sizes(context)
    found = [
        positive("horizontal_stiffness", "N/m", shift, 2.0, shift / 1e3, shift * 1e4),
        positive("vertical_stiffness", "N/m", shift * 1.5, 2.0, shift / 1e3, shift * 1e4),
        positive("tilt_stiffness", "N·m/rad", tilt, 2.0, tilt / 1e3, tilt * 1e4),
        positive("translation_damping", "N·s/m", shift * 3e-4, 2.0, shift * 1e-8, shift),
        positive("tilt_damping", "N·m·s/rad", tilt * 3e-4, 2.0, tilt * 1e-8, tilt),
    ]
    if context.normal is None:
        found.append(positive("twist_stiffness", "N·m/rad", 2 * tilt, 2.0, tilt / 1e3, tilt * 1e4))
    return tuple(found)


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    tilt, shift = sizes(context)
    grid = [
        (tilting * tilt, shifting * shift)
        for tilting in (0.03, 0.1, 0.3, 1.0, 5.0, 30.0, 200.0)
        for shifting in (0.1, 0.5, 2.0, 8.0, 40.0, 300.0, 2000.0)
    ]
    return [
        {
            "horizontal_stiffness": across,
            "vertical_stiffness": 1.5 * across,
            "tilt_stiffness": turn,
            "twist_stiffness": 2 * turn,
            "translation_damping": 3e-4 * across,
            "tilt_damping": 3e-4 * turn,
        }
        for turn, across in grid
    ]


def _shape(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    assembly.move_root(assembly.add_coordinates(names), motion)


def _springs(placement: Placement) -> list[tuple[str, np.ndarray, float, float]]:
    """Name and motion of each coordinate, its stiffness and damping."""
    names, motion = motions(placement.context.normal)
    found = []
    for name, way in zip(names, motion.T, strict=True):
        kind = "tilt" if way[3:].any() else "vertical" if abs(way[2]) > 0.5 else "horizontal"
        upright = placement.context.normal is None and abs(way[5]) > 0.5
        stiffness = placement["twist_stiffness" if upright else f"{kind}_stiffness"]
        found.append(
            (name, way, stiffness, placement["tilt_damping" if kind == "tilt" else "translation_damping"])
        )
    return found


def _act(assembly: Assembly, placement: Placement) -> None:
    for name, _, stiffness, damping in _springs(placement):
        assembly.add_spring(assembly.row(name), stiffness)
        assembly.add_damper(assembly.row(name), damping)


def _extend(draft: Draft, placement: Placement) -> None:
    motions = []
    for name, way, stiffness, damping in _springs(placement):
        joint, turns = draft.fresh(name.replace(" ", "_")), bool(way[3:].any())
        motions.append((joint, way[3:] if turns else way[:3], turns))
        draft.flexible(joint, stiffness, damping)
    draft.under_root(motions)


EFFECT = Effect(
    name="base_flexibility",
    says="the foundation gives way",
    looks_like="resonances in which the whole arm moves, posture for posture as the mass above shifts",
    places=lambda context: ("base",),
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
)
