"""Ports at coordinates that are rigid without them: the foundation, a link that bends."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from flexmodal.diagnosis.effects import base_flexibility, link_flexibility
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.lawfree.port import Patterns, PortKind, constant
from flexmodal.structure.assembly import Assembly


def _base_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    names, _ = base_flexibility.motions(placement.context.normal)
    return Patterns(compliance=np.stack([assembly.row(name) for name in names]))


def _base_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    tilt, shift = base_flexibility.sizes(context)
    _, motion = base_flexibility.motions(context.normal)
    return constant([1 / (tilt if way[3:].any() else shift) for way in motion.T], frequency)


def _base_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    _, motion = base_flexibility.motions(context.normal)
    turns = [bool(way[3:].any()) for way in motion.T]
    grid = product((0.03, 0.2, 1.0, 5.0, 30.0), (0.01, 0.2, 1.0, 5.0, 30.0))
    return tuple(tuple(tilt if turn else shift for turn in turns) for tilt, shift in grid)


BASE = PortKind(
    name="base",
    says="the foundation",
    places=lambda context: (context.robot.urdf.root,),
    functions=lambda context, where: tuple(base_flexibility.motions(context.normal)[0]),
    sizes=_base_sizes,
    starts=_base_starts,
    unit="1/stiffness",
    shape=replace(base_flexibility.EFFECT, name="port", parameters=lambda c, w: (), act=None, extend=None),
    patterns=_base_patterns,
)


def _link_functions(context: Context, where: str) -> tuple[str, ...]:
    planes = 1 if context.normal is not None else 2
    names = [f"bend {plane + 1}" for plane in range(planes)]
    return (*names, *(f"{name}, outwards" for name in names))


def _link_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Even compliance along the link, and what grows along it; the hinges share it by Gauss's weights."""
    context, where = placement.context, placement.where
    places = link_flexibility.hinges(context, where)
    weights = link_flexibility.gauss(len(places))[1]
    planes = 1 if context.normal is not None else 2
    names = link_flexibility.names_of(context, where)
    found = np.zeros((2 * planes, len(assembly.coordinates)))
    for number, name in enumerate(names):
        hinge, plane = divmod(number, planes)
        row = weights[hinge] * assembly.row(name)
        found[plane] += row
        found[planes + plane] += 2 * (places[hinge] - 0.5) * row
    return Patterns(compliance=found)


def _link_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    planes = 1 if context.normal is not None else 2
    return tuple((*(size,) * planes, *(0.0,) * planes) for size in (0.03, 0.1, 0.3, 1.0, 3.0))


LINK = PortKind(
    name="link",
    says="the bending of the link",
    places=link_flexibility.EFFECT.places,
    functions=_link_functions,
    sizes=lambda context, where, frequency: constant(
        [1 / link_flexibility.stiffest(context, where)] * len(_link_functions(context, where)), frequency
    ),
    starts=_link_starts,
    unit="rad/(N·m)",
    shape=replace(link_flexibility.EFFECT, name="port", parameters=lambda c, w: (), act=None, extend=None),
    patterns=_link_patterns,
)
