"""Two joints whose controller holds the tool along one direction of the world: each answers to the other.

A stiffness k of the tool along a direction d is JᵀkJ between the joints, J what each moves the tool by along
d (Salisbury, Proc. 19th IEEE Conf. Decision and Control, 1980, 95): another ratio in each posture.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.foundation import motions
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.rod import pairs, size_of, tie
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

WAYS = ("bearing", "elevation")
"""Of the direction: about the upright axis and above the level plane; in a plane the second alone [rad]."""
TURNS, RISES = (-1.2, -0.4, 0.4, 1.2), (-1.2, -0.4, 0.4, 1.2)
SIZES = (0.2, 1.0, 4.0)
"""Stiffness over that of the joints at the tool, from which fits start."""


def stiffness_of(context: Context, where: str) -> float:
    """As stiff as both joints are at the tool where it is about as far off as a link is long [N/m].

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    one, other = (float(context.robot.joints[name].stiffness) for name in where.split("+"))
    return float(np.sqrt(one * other)) / size_of(context) ** 2


def directions(context: Context, where: str) -> tuple[Parameter, ...]:
    """Of the direction.

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    names = WAYS if context.normal is None else WAYS[1:]
    return tuple(signed(name, "rad", 1.0, -1.6, 1.6) for name in names)


def directions_tried(context: Context, where: str) -> list[dict[str, float]]:
    """Where to look for it.

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    if context.normal is not None:
        return [{WAYS[1]: rise} for rise in RISES]
    return [dict(zip(WAYS, both, strict=True)) for both in product(TURNS, RISES)]


def held(assembly: Assembly, placement: Placement) -> Float[np.ndarray, "*posture dof"]:
    """The row of how far both joints together move the tool along the direction [m].

    Args:
        assembly: with all coordinates.
        placement: with the values of `directions`.
    """
    context, tool = placement.context, placement.context.robot.tool
    rise = placement[WAYS[1]]
    if context.normal is None:
        turn = placement[WAYS[0]]
        way = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    else:
        level, up = motions(context.normal)[1][:3, :2].T
        way = np.cos(rise) * level + np.sin(rise) * up
    moved = way @ assembly.motion(tool, context.reach(tool))[..., :3, :]
    joints = placement.where.split("+")
    parts = [moved[..., assembly.number(name), None] * assembly.stretch_of(name) for name in joints]
    return np.asarray(sum(parts))


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = stiffness_of(context, where)
    return (
        positive("held_stiffness", "N/m", k, 2.0, 1e-4 * k, 1e4 * k),
        positive("held_damping_time", "s", 5e-4, 1.5, 1e-8, 0.1),
        *directions(context, where),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    k = stiffness_of(context, where)
    return [{**way, "held_stiffness": size * k} for way in directions_tried(context, where) for size in SIZES]


def _told(context: Context, where: str, free: FreeFunction) -> list[Mapping[str, float]]:
    """The mean stiffness of what holds it without a law."""
    if WAYS[1] not in free.geometry:
        return []
    stiffness = max(float(np.median(free.value[0].real)), 1e-3 * stiffness_of(context, where))
    return [{**free.geometry, "held_stiffness": stiffness}]


def _act(assembly: Assembly, placement: Placement) -> None:
    row, stiffness = held(assembly, placement), placement["held_stiffness"]
    assembly.add_spring(row, stiffness)
    assembly.add_damper(row, placement["held_damping_time"] * stiffness)


def _extend(draft: Draft, placement: Placement) -> None:
    """What it adds to the joints in the mean of the postures: couplings of a card are the same in all."""
    assembly, joints = Assembly(placement.context.stacked), placement.where.split("+")
    rows = held(assembly, placement)
    added = placement["held_stiffness"] * np.einsum("pi,pj->ij", rows, rows) / len(rows)
    tie(draft, assembly.coordinates, added)
    draft.notes.append(
        f"the files have what holds the tool by {joints[0]} and {joints[1]} as in the mean of the postures, "
        "without damping"
    )


HELD_TOOL = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    places=pairs,
    parameters=_parameters,
    starts=_starts,
    told=_told,
    act=_act,
    extend=_extend,
)
