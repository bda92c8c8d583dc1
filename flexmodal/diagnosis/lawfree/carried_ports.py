"""Ports at the sensor: what moves with it from point to point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Complex

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.sensor_mass import EFFECT as SENSOR_MASS
from flexmodal.diagnosis.effects.sensor_mass import carried_along
from flexmodal.diagnosis.effects.sensor_sets import SIZES, motions
from flexmodal.diagnosis.lawfree.body_ports import ATTACHED, GEOMETRY, link_ways, world_functions, world_ways
from flexmodal.diagnosis.lawfree.port import (
    BETWEEN,
    STILL,
    Patterns,
    PortKind,
    Wider,
    outer,
    tensor,
    tensor_names,
)
from flexmodal.structure.assembly import Assembly

ACROSS_TURNING, TURNING = "across × turning", "turning"
"""Functions of what stands out from a sensor along the arm."""
OFF = 0.1
"""How far it does, for the sizes of these [m]."""


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
        axes, (axis, *across) = assembly.axes(link)[here], link_ways(context, link)
        for k, way in enumerate((axis, *across)):
            moved[k, here] = np.einsum("...i,...ij->...j", axes @ way, motion[here, :3])
            # what stands out along the axis moves along this way, as the sensor turns
            turned[k, here] = np.einsum("...i,...ij->...j", axes @ np.cross(axis, way), motion[here, 3:])
    ways = 3 if context.normal is None else 2
    across_turning = sum(outer(moved[k], turned[k], count) for k in range(1, ways))
    turning = sum(outer(turned[k], turned[k], count) for k in range(1, ways))
    return Patterns(np.concatenate([tensor(list(moved[:ways]), count), [across_turning, turning]]))


def _in_world_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """What moves with the sensor, by the axes of the world, as what hangs from it does."""
    motion = carried_along(assembly, placement)[0, :, :3]
    rows = [np.einsum("i,...ij->...j", way, motion) for way in world_ways(placement.context)]
    return Patterns(tensor(rows, len(motion)))


def _alike(kind: PortKind) -> Wider:
    """A wider port that begins alike along every axis, with nothing besides."""

    def begin(
        context: Context,
        where: str,
        values: Mapping[str, float],
        functions: Complex[np.ndarray, "function line"],
    ) -> Complex[np.ndarray, "more line"]:
        names = kind.functions(context, where)
        besides = (ACROSS_TURNING, TURNING)
        return np.stack([functions[0] * (BETWEEN not in name and name not in besides) for name in names])

    return Wider(kind, begin)


CARRIED_IN_WORLD = PortKind(
    name="carried",
    says="what moves from point to point with the sensor",
    places=lambda context: ("sensor",) if len(context.sensors) > 1 else (),
    functions=world_functions,
    sizes=lambda context, where, frequency: np.repeat(
        _carried_sizes(context, where, frequency), len(world_functions(context, where)), axis=0
    ),
    unit="N/m",
    shape=replace(
        STILL,
        variants=("response",),
        parameters=lambda context, where: tuple(
            one for one in SENSOR_MASS.parameters(context, where) if one.name.startswith("off")
        ),
    ),
    patterns=_in_world_patterns,
)
"""What differs up and down and sideways, as what hangs from the sensor does."""
CARRIED_BY_WAY = replace(
    CARRIED_IN_WORLD, functions=_by_way_names, sizes=_by_way_sizes, patterns=_by_way_patterns
)
"""What differs along the arm and across it, as a cable that leaves the sensor does, or a bracket."""


def _in_sets(size: int) -> PortKind:
    """What moves with each of so many sensors that move on together."""

    def patterns(assembly: Assembly, placement: Placement) -> Patterns:
        every = motions(assembly, placement, size)[..., :3, :]
        return Patterns(sum(np.swapaxes(one, -1, -2) @ one for one in every)[None])

    return replace(
        CARRIED_IN_WORLD, functions=lambda context, where: ("force",), sizes=_carried_sizes, patterns=patterns
    )


CARRIED = replace(
    CARRIED_IN_WORLD,
    functions=lambda context, where: ("force",),
    sizes=_carried_sizes,
    patterns=_carried_patterns,
    wider=(
        _alike(CARRIED_BY_WAY),
        _alike(CARRIED_IN_WORLD),
        *(Wider(_in_sets(size), lambda context, where, values, functions: functions) for size in SIZES),
    ),
)
