"""Ports at coordinates that are rigid without them: the foundation, and the bearing of a joint."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement, product

import numpy as np

from flexmodal.diagnosis.effects import (
    base_flexibility,
    bearing,
    bearing_flexibility,
    foundation,
)
from flexmodal.diagnosis.effects.bearing import Way
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.diagnosis.lawfree.port import BETWEEN, Patterns, PortKind, Wider, constant, outer, tensor_names
from flexmodal.structure import Parameter
from flexmodal.structure.arm import carried
from flexmodal.structure.assembly import Assembly

BASE_AXIS = ("aside", "ahead")
"""Of the foundation in space [m]."""


Terms = Callable[[Context], list[tuple[int, int]]]


def _base_patterns(terms: Terms, assembly: Assembly, placement: Placement) -> Patterns:
    context = placement.context
    rows = [assembly.row(name) for name in foundation.motions(context.normal)[0]]
    return Patterns(compliance=np.stack([outer(rows[i], rows[j], 1)[0] for i, j in terms(context)]))


def _base_functions(terms: Terms, context: Context, where: str) -> tuple[str, ...]:
    names = foundation.motions(context.normal)[0]
    return tuple(names[i] if i == j else f"{names[i]}{BETWEEN}{names[j]}" for i, j in terms(context))


def _base_sizes(terms: Terms, context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    tilt, shift = foundation.sizes(context)
    _, motion = foundation.motions(context.normal)
    each = [1 / (tilt if way[3:].any() else shift) for way in motion.T]
    return constant([float(np.sqrt(each[i] * each[j])) for i, j in terms(context)], frequency)


def _base_starts(every: Terms, context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    _, motion = foundation.motions(context.normal)
    turns, terms = [bool(way[3:].any()) for way in motion.T], every(context)
    grid = product((0.03, 0.2, 1.0, 5.0, 30.0), (0.01, 0.2, 1.0, 5.0, 30.0))
    return tuple(
        tuple(0.0 if i != j else tilt if turns[i] else shift for i, j in terms) for tilt, shift in grid
    )


def _base_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """In space: where the upright axis is about which horizontal shifts and tilts go together."""
    if context.normal is not None:
        return ()
    return tuple(one for one in base_flexibility.EFFECT.parameters(context, where) if one.name in BASE_AXIS)


def _base_shape(assembly: Assembly, placement: Placement) -> None:
    names, motion = foundation.motions(placement.context.normal)
    if placement.context.normal is None:
        motion = carried(motion, -foundation.aside_of(placement))
    assembly.move_root(assembly.add_coordinates(names), motion)


def _spread(context: Context, where: str, values: Mapping[str, float], functions: np.ndarray) -> np.ndarray:
    """Compliances about an upright axis as those of the root's origin, between any two coordinates."""
    _, motion = foundation.motions(context.normal)
    count = motion.shape[1]
    about = np.zeros((functions.shape[1], count, count), dtype=complex)
    for (i, j), value in zip(foundation.terms(context), functions, strict=True):
        about[:, i, j] = about[:, j, i] = value
    if context.normal is None:
        turned = carried(motion, -np.array([*(values[name] for name in BASE_AXIS), 0.0]))
        about = turned @ about @ turned.T
    return np.stack([about[:, i, j] for i, j in foundation.every_term(context)])


def _base(terms: Terms, shape: Effect, *wider: Wider) -> PortKind:
    return PortKind(
        name="base",
        says="the foundation",
        places=base_flexibility.EFFECT.places,
        functions=partial(_base_functions, terms),
        sizes=partial(_base_sizes, terms),
        starts=partial(_base_starts, terms),
        unit="1/stiffness",
        shape=replace(shape, name="port", act=None, extend=None),
        patterns=partial(_base_patterns, terms),
        informs=True,
        wider=wider,
    )


BASE = _base(
    foundation.terms,
    replace(base_flexibility.EFFECT, parameters=_base_parameters, geometry=BASE_AXIS, shape=_base_shape),
    Wider(
        _base(foundation.every_term, replace(base_flexibility.EFFECT, parameters=lambda context, where: ())),
        _spread,
    ),
)


def _bearing_kinds(context: Context, where: str) -> list[str]:
    """Of the ways in which the joints give, each kind once."""
    return list(dict.fromkeys(way.kind for _, way, _ in bearing.names_of(context, where)))


def _scale(context: Context, where: str, joint: str) -> float:
    """What a joint's compliance is a multiple of: 1 N·m/rad, or of all joints alike its own stiffness."""
    return float(context.robot.joints[joint].stiffness) if where == bearing.ALL else 1.0


def _bearing_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    context, where = placement.context, placement.where
    kinds = _bearing_kinds(context, where)
    found = np.zeros((len(kinds), *(len(assembly.coordinates),) * 2))
    for joint, way, name in bearing.names_of(context, where):
        found[kinds.index(way.kind)] += np.diag(assembly.row(name)) / _scale(context, where, joint)
    return Patterns(compliance=found)


def _bearing_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    if where == bearing.ALL:
        return constant([1 / bearing.TILT], frequency)
    tilt = bearing.size(context, where)
    shift = tilt / bearing.RADIUS**2
    return constant([1 / (tilt if k == "tilt" else shift) for k in _bearing_kinds(context, where)], frequency)


def _bearing_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    kinds, found = _bearing_kinds(context, where), []
    for tilt in (0.1, 0.5, 2.0, 8.0):
        for shift in (0.02, 0.5) if "tilt" in kinds and len(kinds) > 1 else (0.5,):
            found.append(tuple(tilt if k == "tilt" else shift * tilt for k in kinds))
    return tuple(found)


def _every_way(context: Context, where: str) -> list[tuple[Way, Way]]:
    """Any two ways in which a joint gives."""
    return list(combinations_with_replacement(bearing.given(context, where, where), 2))


def _full_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    where, pairs = placement.where, _every_way(placement.context, placement.where)
    rows = {way: assembly.row(bearing.coordinate(where, way)) for pair in pairs for way in pair}
    return Patterns(compliance=np.stack([outer(rows[one], rows[other], 1)[0] for one, other in pairs]))


def _full_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    kinds = _bearing_kinds(context, where)
    size = dict(zip(kinds, _bearing_sizes(context, where, frequency)[:, 0].tolist(), strict=True))
    pairs = [(size[one.kind], size[other.kind]) for one, other in _every_way(context, where)]
    return constant([float(np.sqrt(one * other)) for one, other in pairs], frequency)


def _full(*, turning: bool) -> Wider:
    """Whatever is the same in all postures as the carrying link has it, or as the carried one does."""

    def begin(context: Context, where: str, values: Mapping[str, float], functions: np.ndarray) -> np.ndarray:
        each = dict(zip(_bearing_kinds(context, where), functions, strict=True))
        return np.stack([each[one.kind] * (one is other) for one, other in _every_way(context, where)])

    shape = replace(BEARING_SHAPE, shape=partial(bearing.add_ways, turning=turning))
    kind = PortKind(
        name="bearing",
        says="the bearing of a joint",
        places=lambda context: tuple(
            joint for joint in bearing_flexibility.EFFECT.places(context) if joint != bearing.ALL
        ),
        functions=lambda context, where: tensor_names(
            [way.name for way in bearing.given(context, where, where)]
        ),
        sizes=_full_sizes,
        unit="1/stiffness",
        shape=shape,
        patterns=_full_patterns,
    )
    return Wider(kind, begin)


BEARING_SHAPE = replace(
    bearing_flexibility.EFFECT,
    name="port",
    parameters=lambda context, where: (),
    shape=bearing.add_ways,
    act=None,
    extend=None,
)
BEARING = PortKind(
    name="bearing",
    says="the bearing of a joint",
    places=bearing_flexibility.EFFECT.places,
    functions=lambda context, where: tuple(_bearing_kinds(context, where)),
    sizes=_bearing_sizes,
    starts=_bearing_starts,
    unit="1/stiffness",
    shape=BEARING_SHAPE,
    patterns=_bearing_patterns,
    wider=(_full(turning=False), _full(turning=True)),
)
