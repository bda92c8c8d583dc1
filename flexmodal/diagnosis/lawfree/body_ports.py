"""Ports at bodies: something on a link, or between it and the surroundings."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from flexmodal.diagnosis.effects import foundation
from flexmodal.diagnosis.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.diagnosis.effects.added_mass import SUNK, SUNKEN, place_on, sunk
from flexmodal.diagnosis.effects.attached_point import MIDDLE, lever_of
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.diagnosis.effects.hung_across import clips, halves
from flexmodal.diagnosis.effects.hung_across import places as hung_places
from flexmodal.diagnosis.lawfree.port import Patterns, PortKind, outer, tensor, tensor_names
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

ATTACHED = 0.05
"""Of the arm's mass: what a body port is measured by."""
GEOMETRY = ("along", "beside", "above")
"""Parameters of the place of a body port."""
SPREADS = 0.3
"""How far what is attached spreads, over the length of the link."""


def link_ways(context: Context, where: str) -> list[np.ndarray]:
    """Along a link and across it, in its frame.

    Args:
        context: of the diagnosis.
        where: the link.
    """
    _, axis = along(context, where)
    return [axis, *sides(context, where, axis)]


def _body_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Of the port's place along the axes of the link."""
    context, where = placement.context, placement.where
    motion = assembly.motion(where, place_on(context, where, placement.values))[..., :3, :]
    axes = assembly.axes(where)
    rows = [np.einsum("...i,...ij->...j", axes @ way, motion) for way in link_ways(context, where)]
    return Patterns(tensor(rows, len(placement.posture)))


def _place(context: Context, where: str) -> tuple[Parameter, ...]:
    return tuple(one for one in ADDED_MASS.parameters(context, where) if one.name in GEOMETRY)


def _body_functions(context: Context, where: str) -> tuple[str, ...]:
    return tensor_names(GEOMETRY[: len(link_ways(context, where))])


def _body_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    size = ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    return np.repeat(size[None], len(_body_functions(context, where)), axis=0)


BODY = PortKind(
    name="body",
    says="something attached to the link",
    places=lambda context: context.links,
    functions=_body_functions,
    sizes=_body_sizes,
    unit="N/m",
    shape=replace(
        ADDED_MASS,
        name="port",
        parameters=_place,
        shape=None,
        act=None,
        extend=None,
    ),
    patterns=_body_patterns,
)


def _attached_rows(assembly: Assembly, placement: Placement) -> list[np.ndarray]:
    """Of the middle of the link: along it and across it, and turning about these, times a lever."""
    context, where = placement.context, placement.where
    axes, (_, axis), ways = assembly.axes(where), along(context, where), link_ways(context, where)
    lever = lever_of(context, where)
    motion = assembly.motion(where, MIDDLE * lever * axis)
    turns = ways if context.normal is None else [np.cross(ways[0], ways[1])]
    return [
        np.einsum("...i,...ij->...j", axes @ way, motion[..., part, :]) * times
        for part, some, times in ((slice(0, 3), ways, 1.0), (slice(3, 6), turns, lever))
        for way in some
    ]


def _attached_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    return Patterns(tensor(_attached_rows(assembly, placement), len(placement.posture)))


def _attached_names(context: Context, where: str) -> tuple[str, ...]:
    names = GEOMETRY[: len(link_ways(context, where))]
    turns = [f"about {name}" for name in names] if context.normal is None else ["turning"]
    return (*names, *turns)


def _attached_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    ways = len(link_ways(context, where))
    each = [1.0 if k < ways else SPREADS for k, _ in enumerate(_attached_names(context, where))]
    force = ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    return np.array([a * b * force for a, b in combinations_with_replacement(each, 2)])


ATTACHED_BODY = PortKind(
    name="attached",
    says="something attached to the link that turns as well",
    places=lambda context: tuple(link for link in context.links if len(link_ways(context, link)) > 1),
    functions=lambda context, where: tensor_names(_attached_names(context, where)),
    sizes=_attached_sizes,
    unit="N/m",
    patterns=_attached_patterns,
    turns=True,
)


def world_ways(context: Context) -> list[np.ndarray]:
    """Axes of the world, those in the plane of a planar chain."""
    return list(np.eye(3) if context.normal is None else foundation.motions(context.normal)[1][:3, :2].T)


def _ground_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """The same along the axes of the world, as far below the place in every posture."""
    context, where = placement.context, placement.where
    moved = sunk(assembly.motion(where, place_on(context, where, placement.values)), placement[SUNK])
    rows = [np.einsum("i,...ij->...j", way, moved) for way in world_ways(context)]
    return Patterns(tensor(rows, len(placement.posture)))


def world_functions(context: Context, where: str) -> tuple[str, ...]:
    """Functions between motions along these.

    Args:
        context: of the diagnosis.
        where: the place, which does not matter.
    """
    return tensor_names("xyz" if context.normal is None else ("across", "up"))


GROUND = replace(
    BODY,
    name="ground",
    says="something between the link and what stands around",
    functions=world_functions,
    shape=replace(BODY.shape, parameters=lambda context, where: (*_place(context, where), SUNKEN)),
    patterns=_ground_patterns,
)


def _across_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Of the mean motion of both clips, by the axes of the link, and of half of that between them."""
    axes, count = assembly.axes(placement.where), len(placement.posture)
    ways = [axes @ way for way in link_ways(placement.context, placement.where)]
    means, apart = halves(assembly, placement, ways)
    other = np.sum([outer(row, row, count) for row in apart], axis=0)
    return Patterns(np.concatenate([tensor(means, count), other[None]]))


def _across_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    size = ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    return np.repeat(size[None], len(_across_functions(context, where)), axis=0)


def _across_functions(context: Context, where: str) -> tuple[str, ...]:
    return (*_body_functions(context, where), "apart")


ACROSS = replace(
    BODY,
    name="across",
    says="something that hangs on two links, across the joint between them",
    places=hung_places,
    functions=_across_functions,
    sizes=_across_sizes,
    shape=replace(
        BODY.shape, parameters=lambda context, where: (*_place(context, where), *clips(context, where))
    ),
    patterns=_across_patterns,
)
