"""An elastic rod between two links: from a crank before one joint to one after another.

Its ends move against each other along the line between them, so that how it ties the joints, those in between
too, changes with the posture. What is clamped at its ends, such as a package of hoses, holds them across that
line too, alike both ways. What is stretched at rest, as a spring that balances an arm, also resists being
turned: with a tension T along its line d and Δ the motion of one end against the other, second derivatives of
its energy by the joints gain T (∂Δ·∂Δ − ∂|d| ∂|d| + d·∂²Δ)/|d| (Géradin and Rixen, Mechanical Vibrations,
3rd ed., Wiley 2015, on prestressed members). It has no mass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import combinations, product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import KEPT, Effect, Placement, across, positive, signed
from flexmodal.diagnosis.effects.foundation import length_of
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

SIDES = ("near", "far")
"""Its ends: before the first joint and after the second."""
TURNS, REACHES = 8, (0.2, 0.5)
"""Directions about a joint that a crank's end is looked for in, and how far off, over the size of a link."""
ACROSS = 0.3
"""Stiffness across over along from which some fits start; from none it is not found."""
BALANCES = 1.0
"""Pull from which some fits start: that of a spring without a length of its own."""
SHORTEST = 1e-6
"""Of the rod [m], at which its direction still is one."""


def pairs(context: Context) -> tuple[str, ...]:
    """Any two joints, such as q1+q2."""
    return tuple(f"{a}+{b}" for a, b in combinations(context.joints, 2))


def size_of(context: Context) -> float:
    """About as long as a link between two joints [m]."""
    return length_of(context) / max(len(context.joints), 1)


def stiffness_of(context: Context, where: str) -> float:
    """Of a rod that is as stiff as the joints by the card, on cranks as long as a third of a link [N/m].

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    one, other = (float(context.robot.joints[name].stiffness) for name in where.split("+"))
    return float(np.sqrt(one * other)) / (size_of(context) / 3) ** 2


@lru_cache(maxsize=KEPT)
def links(context: Context, where: str) -> tuple[tuple[str, np.ndarray, np.ndarray], ...]:
    """Of either end the link that has it, and in that link's frame where the joint is [m], and its axis.

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    urdf = context.robot.urdf
    one, other = (urdf.joint_by_name[name] for name in where.split("+"))
    turned = context.axes(one.parent).T @ context.axes(one.child)
    return (one.parent, one.xyz, turned @ one.axis), (other.child, np.zeros(3), other.axis)


@lru_cache(maxsize=KEPT)
def ways(context: Context, link: str) -> tuple[np.ndarray, ...]:
    """Directions of a crank's parameters, in the frame of its link: two in the plane of a planar chain.

    Args:
        context: of the diagnosis.
        link: its name.
    """
    return tuple(np.eye(3)) if context.normal is None else across(context.axes(link).T @ context.normal)


def cranks(context: Context, where: str) -> tuple[Parameter, ...]:
    """Where the ends are, from the joints.

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    size, count = size_of(context), 2 if context.normal is not None else 3
    return tuple(
        signed(f"{side}_{axis}", "m", size / 2, -2 * size, 2 * size)
        for side in SIDES
        for axis in "xyz"[:count]
    )


def cranks_tried(context: Context, where: str) -> list[dict[str, float]]:
    """Where to look for the ends: about the joints' axes, at some distances.

    Args:
        context: of the diagnosis.
        where: the two joints.
    """
    ends = []
    for side, (link, _, axis) in zip(SIDES, links(context, where), strict=True):
        along, here = ways(context, link), []
        first, second = across(axis / np.linalg.norm(axis)) if context.normal is None else along
        for angle, reach in product(np.arange(TURNS) * 2 * np.pi / TURNS, REACHES):
            place = reach * size_of(context) * (np.cos(angle) * first + np.sin(angle) * second)
            here.append(
                {f"{side}_{name}": float(place @ way) for name, way in zip("xyz", along, strict=False)}
            )
        ends.append(here)
    return [{**one, **other} for one, other in product(*ends)]


def stretch(assembly: Assembly, placement: Placement) -> Float[np.ndarray, "*posture dof"]:
    """The row of what stretches the rod [m]: its far end's motion less that of the near one, along it.

    Args:
        assembly: with all coordinates.
        placement: with the values of `cranks`.
    """
    return _drawn(assembly, placement)[0]


def tightened(assembly: Assembly, placement: Placement) -> Float[np.ndarray, "*posture dof dof"]:
    """Second derivatives of half the square of a spring's length by the joints [m²], and of their stretches.

    That is what a spring without a length of its own adds to the stiffness, over its own, but its part along
    itself: of a joint i before a joint j ∂²Δ is the axis of i across the derivative by j.

    Args:
        assembly: with all coordinates.
        placement: with the values of `cranks`.
    """
    along, moved, line, ends = _drawn(assembly, placement)
    found = np.swapaxes(moved, -1, -2) @ moved - along[..., :, None] * along[..., None, :]
    joints = [assembly.number(name) for name in placement.context.joints]
    for sign, motion in zip((-1.0, 1.0), ends, strict=True):
        shifts, turns = motion[..., :3, joints], motion[..., 3:, joints]
        pulled = np.cross(line[..., None], turns, axisa=-2, axisb=-2, axisc=-2)  # d · (a × r) = (d × a) · r
        bent = np.triu(np.swapaxes(pulled, -1, -2) @ shifts)
        bent = bent + np.swapaxes(np.triu(bent, 1), -1, -2)
        found[..., np.array(joints)[:, None], joints] += sign * bent
    return np.asarray(found)


def _drawn(
    assembly: Assembly, placement: Placement
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Sequence[np.ndarray]]:
    """The far end's motion less that of the near one [m], along the rod and along the axes of the world.

    And the line from the near end to the far one [m], and the motion of either.
    """
    context, places, motions = placement.context, [], []
    for side, (link, joint, _) in zip(SIDES, links(context, placement.where), strict=True):
        place = joint
        for name, way in zip("xyz", ways(context, link), strict=False):
            place = place + placement[f"{side}_{name}"] * way
        places.append(assembly.origin(link) + assembly.axes(link) @ place)
        motions.append(assembly.motion(link, place))
    line = places[1] - places[0]
    way = line / np.maximum(np.linalg.norm(line, axis=-1, keepdims=True), SHORTEST)
    moved = (motions[1] - motions[0])[..., :3, :]
    return np.asarray((way[..., None, :] @ moved)[..., 0, :]), moved, line, motions


def springs(
    assembly: Assembly, placement: Placement
) -> list[tuple[Float[np.ndarray, "*posture dof"], float]]:
    """What stretches its springs, along it and along the axes of the world, and their stiffness [N/m].

    Args:
        assembly: with all coordinates.
        placement: with the values of the effect.
    """
    along, moved, *_ = _drawn(assembly, placement)
    stiffness = placement["rod_stiffness"]
    across = placement["rod_across"] * stiffness
    return [(along, stiffness - across), *((moved[..., axis, :], across) for axis in range(3))]


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    stiffness = stiffness_of(context, where)
    return (
        positive("rod_stiffness", "N/m", stiffness, 2.0, stiffness / 1e4, stiffness * 1e4),
        positive("rod_damping_time", "s", 1e-5, 2.0, 1e-12, 0.03),
        positive("rod_across", "of the stiffness along it", 1e-3, 2.5, 1e-9, 10.0),
        signed("rod_pull", "of the stiffness along it, times its length", 0.1, -1.0, 2.0),
        *cranks(context, where),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    sizes = [factor * stiffness_of(context, where) for factor in (0.3, 3.0)]
    clamped = {"rod_stiffness": stiffness_of(context, where), "rod_across": ACROSS}
    balancing = {"rod_stiffness": stiffness_of(context, where), "rod_pull": BALANCES}
    kinds = [*({"rod_stiffness": size} for size in sizes), clamped, balancing]
    return [{**one, **kind} for one in cranks_tried(context, where) for kind in kinds]


def _told(context: Context, where: str, free: FreeFunction) -> Sequence[Mapping[str, float]]:
    """The mean stiffness of a rod whose law is free."""
    if not any(name.startswith(SIDES) for name in free.geometry):
        return ()
    stiffness = max(float(np.median(free.value[0].real)), 1e-3 * stiffness_of(context, where))
    told = {**free.geometry, "rod_stiffness": stiffness}
    return told, {**told, "rod_pull": BALANCES}


def _act(assembly: Assembly, placement: Placement) -> None:
    for row, stiffness in springs(assembly, placement):
        assembly.add_spring(row, stiffness)
        assembly.add_damper(row, placement["rod_damping_time"] * stiffness)
    if pulls := placement["rod_pull"] * placement["rod_stiffness"]:
        added = tightened(assembly, placement)
        for number in np.flatnonzero(added.any(axis=tuple(range(added.ndim - 1)))).tolist():
            row = assembly.row(assembly.coordinates[number])
            assembly.add_coupling(row, added[..., number, :], pulls / 2)  # half of a row, half of a column


def tie(draft: Draft, names: Sequence[str], added: Float[np.ndarray, "dof dof"]) -> None:
    """Add a stiffness between joints to the files.

    Args:
        draft: of the robot.
        names: of the joints, by row.
        added: to their stiffness.
    """
    tied = np.flatnonzero(np.diag(added)).tolist()
    for k in tied:
        draft.stiffen(names[k], added[k, k])
    for i, j in combinations(tied, 2):
        draft.couple(names[i], names[j], added[i, j])


def _extend(draft: Draft, placement: Placement) -> None:
    """What it adds to the joints in the mean of the postures: couplings of a card are the same in all."""
    assembly = Assembly(placement.context.stacked)
    names = assembly.coordinates
    rows, stiffness = zip(*springs(assembly, placement), strict=True)
    added = np.einsum("s,spi,spj->ij", stiffness, rows, rows) / len(rows[0])
    added += placement["rod_pull"] * placement["rod_stiffness"] * tightened(assembly, placement).mean(axis=0)
    tie(draft, names, added)
    one, other = placement.where.split("+")
    draft.notes.append(
        f"the files have the rod between {one} and {other} as in the mean of the postures, without damping"
    )


ROD = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    places=pairs,
    parameters=_parameters,
    starts=_starts,
    told=_told,
    act=_act,
    extend=_extend,
    comes_close=True,
)
