"""Ports at bodies: something on a link, between it and the surroundings, or that moves with the sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
from jaxtyping import Complex

from flexmodal.diagnosis.effects import foundation
from flexmodal.diagnosis.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.attached_point import MIDDLE, lever_of
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.diagnosis.effects.sensor_mass import EFFECT as SENSOR_MASS
from flexmodal.diagnosis.effects.sensor_mass import carried_along
from flexmodal.diagnosis.lawfree.port import (
    STILL,
    Patterns,
    PortKind,
    Wider,
    outer,
    tensor,
    tensor_names,
)
from flexmodal.structure.assembly import Assembly

ATTACHED = 0.05
"""Of the arm's mass: what a body port is measured by."""
GEOMETRY = ("along", "beside", "above")
"""Parameters of the place of a body port."""
ACROSS_TURNING, TURNING = "across × turning", "turning"
"""Functions of what stands out from a sensor along the arm."""
OFF = 0.1
"""How far it does, for the sizes of these [m]."""
SPREADS = 0.3
"""How far what is attached spreads, over the length of the link."""


def _ways(context: Context, where: str) -> list[np.ndarray]:
    _, axis = along(context, where)
    return [axis, *sides(context, where, axis)]


def _tensor(placement: Placement, assembly: Assembly, ways: Sequence[np.ndarray]) -> Patterns:
    """Of the port's place along some world directions."""
    place = place_on(placement.context, placement.where, placement.values)
    motion = assembly.motion(placement.where, place)[..., :3, :]
    rows = [np.einsum("...i,...ij->...j", way, motion) for way in ways]
    return Patterns(tensor(rows, len(placement.posture)))


def _body_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    axes = assembly.axes(placement.where)
    return _tensor(placement, assembly, [axes @ way for way in _ways(placement.context, placement.where)])


def _body_functions(context: Context, where: str) -> tuple[str, ...]:
    return tensor_names(GEOMETRY[: len(_ways(context, where))])


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
        parameters=lambda context, where: tuple(
            one for one in ADDED_MASS.parameters(context, where) if one.name in GEOMETRY
        ),
        shape=None,
        act=None,
        extend=None,
    ),
    patterns=_body_patterns,
)


def _attached_rows(assembly: Assembly, placement: Placement) -> list[np.ndarray]:
    """Of the middle of the link: along it and across it, and turning about these, times a lever."""
    context, where = placement.context, placement.where
    axes, (_, axis), ways = assembly.axes(where), along(context, where), _ways(context, where)
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
    names = GEOMETRY[: len(_ways(context, where))]
    turns = [f"about {name}" for name in names] if context.normal is None else ["turning"]
    return (*names, *turns)


def _attached_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    ways = len(_ways(context, where))
    each = [1.0 if k < ways else SPREADS for k, _ in enumerate(_attached_names(context, where))]
    force = ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    return np.array([a * b * force for a, b in combinations_with_replacement(each, 2)])


ATTACHED_BODY = PortKind(
    name="attached",
    says="something attached to the link that turns as well",
    places=lambda context: tuple(link for link in context.links if len(_ways(context, link)) > 1),
    functions=lambda context, where: tensor_names(_attached_names(context, where)),
    sizes=_attached_sizes,
    unit="N/m",
    patterns=_attached_patterns,
    turns=True,
)


def _ground_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """The same along the axes of the world."""
    normal = placement.context.normal
    ways = np.eye(3) if normal is None else foundation.motions(normal)[1][:3, :2].T
    return _tensor(placement, assembly, list(ways))


def _ground_functions(context: Context, where: str) -> tuple[str, ...]:
    return tensor_names("xyz" if context.normal is None else ("across", "up"))


GROUND = replace(
    BODY,
    name="ground",
    says="something between the link and what stands around",
    functions=_ground_functions,
    patterns=_ground_patterns,
)


def _carried_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """What moves with the sensor, the same along every axis; off the surface by the port's geometry."""
    motion = carried_along(assembly, placement)[0, :, :3]
    return Patterns((np.swapaxes(motion, -1, -2) @ motion)[None])


def _carried_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    return (0.1 * ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2)[None]


def _by_way_names(context: Context, where: str) -> tuple[str, ...]:
    return (*tensor_names(GEOMETRY if context.normal is None else GEOMETRY[:2]), ACROSS_TURNING, TURNING)


def _by_way_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    names = _by_way_names(context, where)
    lever = np.array([{ACROSS_TURNING: OFF, TURNING: OFF**2}.get(name, 1.0) for name in names])
    return lever[:, None] * _carried_sizes(context, where, frequency)


def _by_way_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """What moves with the sensor, by the axes of the link that it is on; round about that, as it turns."""
    context, count = placement.context, len(placement.response)
    motion = carried_along(assembly, placement)[0]
    moved, turned = np.zeros((2, 3, count, motion.shape[-1]))
    for number in np.unique(placement.response[:, 0]).tolist():
        link, here = context.point(number).link, placement.response[:, 0] == number
        axes, (axis, *across) = assembly.axes(link)[here], _ways(context, link)
        for k, way in enumerate((axis, *across)):
            moved[k, here] = np.einsum("...i,...ij->...j", axes @ way, motion[here, :3])
            # what stands out along the axis moves along this way, as the sensor turns
            turned[k, here] = np.einsum("...i,...ij->...j", axes @ np.cross(axis, way), motion[here, 3:])
    ways = 3 if context.normal is None else 2
    across_turning = sum(outer(moved[k], turned[k].copy(), count) for k in range(1, ways))
    turning = sum(outer(turned[k], turned[k], count) for k in range(1, ways))
    return Patterns(np.concatenate([tensor(list(moved[:ways]), count), [across_turning, turning]]))


def _by_way(
    context: Context, values: Mapping[str, float], functions: Complex[np.ndarray, "function line"]
) -> Complex[np.ndarray, "more line"]:
    """The same along every axis, and nothing besides."""
    return np.stack([functions[0] * (name in GEOMETRY) for name in _by_way_names(context, "")])


CARRIED_BY_WAY = PortKind(
    name="carried",
    says="what moves from point to point with the sensor",
    places=lambda context: ("sensor",) if len(context.sensors) > 1 else (),
    functions=_by_way_names,
    sizes=_by_way_sizes,
    unit="N/m",
    shape=replace(
        STILL,
        variants=("response",),
        parameters=lambda context, where: tuple(
            one for one in SENSOR_MASS.parameters(context, where) if one.name.startswith("off")
        ),
    ),
    patterns=_by_way_patterns,
)
"""What differs along the arm and across it, as a cable that leaves the sensor does, or a bracket."""
CARRIED = replace(
    CARRIED_BY_WAY,
    functions=lambda context, where: ("force",),
    sizes=_carried_sizes,
    patterns=_carried_patterns,
    wider=Wider(CARRIED_BY_WAY, _by_way),
)
