"""The foundation gives: the root link tilts and shifts on springs, all of it at once.

Three coordinates under a planar chain, six under a spatial one. The springs meet somewhere below the root or
beside it, are not equally stiff every way, in space along and about two level axes that may be turned from
those of the root, and carry a foundation with a mass of its own. The inertia of the root link counts.

At the next level the foundation moves by itself: bolts between it and the root give too, at the root's origin
and about the same axes. Machines on blocks: Richart, Hall and Woods, Vibrations of Soils and Foundations,
Prentice-Hall 1970, chapter 10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.floor import SAYS, floor_like
from flexmodal.diagnosis.effects.foundation import (
    Spring,
    centre_of,
    inertias,
    length_of,
    mass_centre,
    motions,
    sizes,
    springs,
)
from flexmodal.diagnosis.effects.foundation_start import told_by
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, carried
from flexmodal.structure.assembly import Assembly

_SPRINGS = ("horizontal_stiffness", "vertical_stiffness", "tilt_stiffness", "twist_stiffness")
DEPTH, HEAVY = 0.1, (1.0, 3.0, 10.0)
"""Of a block, to its middle, over the arm's length; masses over that of what moves on the root."""
Motions = list[tuple[str, np.ndarray, bool]]


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Springs and dampers; where they meet, how their stiffness differs by direction, the foundation's mass.

    What a simple foundation does not need stays near its prior's centre: ratios of 1, no offset, next to no
    mass.
    """
    tilt, shift = sizes(context)
    mass, length = context.arm_mass, length_of(context)
    found = [
        positive("horizontal_stiffness", "N/m", shift, 2.0, shift / 1e3, shift * 1e6),
        positive("vertical_stiffness", "N/m", shift * 1.5, 2.0, shift / 1e3, shift * 1e6),
        positive("tilt_stiffness", "N·m/rad", tilt, 2.0, tilt / 1e3, tilt * 1e6),
        positive("translation_damping", "N·s/m", shift * 3e-4, 2.0, shift * 1e-8, shift * 100),
        positive("tilt_damping", "N·m·s/rad", tilt * 3e-4, 2.0, tilt * 1e-8, tilt * 100),
        positive("vertical_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
        signed("aside", "m", 0.1 * length, -length, length),
        signed("below", "m", 0.15 * length, -length, length),
        positive("mass", "kg", 0.01 * mass, 2.5, 1e-5 * mass, 50 * mass),
        signed("mass_below", "m", 0.15 * length, -length, length),
        signed("mass_aside", "m", 0.05 * length, -length, length),
        positive("gyration", "m", 0.15 * length, 1.0, 1e-3 * length, 3 * length),
    ]
    if context.normal is None:
        found += [
            positive("twist_stiffness", "N·m/rad", 2 * tilt, 2.0, tilt / 1e3, tilt * 1e6),
            positive("sideways_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("tilt_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("sideways_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("tilt_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            positive("twist_damping_ratio", "", 1.0, 0.5, 0.05, 20.0),
            signed("ahead", "m", 0.1 * length, -length, length),
            signed("mass_ahead", "m", 0.05 * length, -length, length),
            signed("angle", "rad", 0.8, -1.6, 1.6),
        ]
    return tuple(found)


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


def _told(context: Context, where: str, free: FreeFunction) -> list[dict[str, float]]:
    """What free compliances come near to."""
    return told_by(context, free, _parameters(context, where), _starts(context, where))


def _bolted_told(context: Context, where: str, free: FreeFunction) -> list[dict[str, float]]:
    """The same with bolts, from some of the foundations with bolts of any stiffness."""
    starts = _with_bolts(context, _simple_starts(context, where)[::3], (5.0, 0.7))
    return told_by(context, free, _bolted_parameters(context, where), starts, bolts_of)


def _shape(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    assembly.move_root(assembly.add_coordinates(names), motion)


def _act(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    own = np.array([assembly.row(name) for name in names])
    _sprung(assembly, carried(motion, centre_of(placement)) @ own, springs(placement))
    moved = motion.T @ carried(motion, mass_centre(placement)) @ own
    assembly.add_together("mass", moved, inertias(placement))


def _sprung(assembly: Assembly, motion: np.ndarray, some: Sequence[Spring]) -> None:
    """Springs and dampers on a body that moves so, linear rows first, over the coordinates."""
    rows = np.array([way for _, way, _, _ in some]) @ motion
    assembly.add_together("stiffness", rows, np.array([stiffness for _, _, stiffness, _ in some]))
    assembly.add_together("damping", rows, np.array([damping for _, _, _, damping in some]))


def _extend(draft: Draft, placement: Placement) -> None:
    root = draft.robot.urdf.root
    draft.under_root(_new_joints(draft, springs(placement)), centre_of(placement))
    draft.attach(root, _own_body(placement, mass_centre(placement)), name="foundation_mass")


def _new_joints(draft: Draft, some: Sequence[Spring]) -> Motions:
    found = []
    for name, way, stiffness, damping in some:
        joint, turns = draft.fresh(name.replace(" ", "_")), bool(way[3:].any())
        found.append((joint, way[3:] if turns else way[:3], turns))
        draft.flexible(joint, stiffness, damping)
    return found


def _own_body(placement: Placement, centre: np.ndarray) -> Body:
    """The foundation's mass, its centre somewhere [m]."""
    return Body(placement["mass"], centre, placement["mass"] * placement["gyration"] ** 2 * np.eye(3))


def _kinds(context: Context) -> Mapping[str, tuple[int, ...]]:
    """Of motions, of six: those whose bolts are stiffer than the foundation's springs by the same ratio."""
    turns = {"tilt": (3, 4), "twist": (5,)} if context.normal is None else {"tilt": (3, 4, 5)}
    return {"horizontal": (0, 1), "vertical": (2,), **turns}


def _bolted_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Those of a foundation, and by how much the bolts are stiffer than its springs, by direction."""
    ratios = [positive(f"bolts_{kind}_ratio", "", 3.0, 1.5, 1e-2, 1e4) for kind in _kinds(context)]
    return (*_parameters(context, where), *ratios, positive("bolts_damping_ratio", "", 1.0, 1.0, 1e-3, 1e3))


def _bolted_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """Where a fit of springs alone ended, and elsewhere.

    Where bolts give, what was fitted without them may sit and weigh anything.
    """
    known = {name: value for name, value in values.items() if name.endswith(("_stiffness", "_damping"))}
    return _with_bolts(context, [values, known, *_simple_starts(context, where)], (5.0, 2.0, 0.7, 0.2))


def _simple_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Those of springs alone."""
    return [one for one in _starts(context, where) if "mass" not in one and "angle" not in one]


def _with_bolts(
    context: Context, some: Sequence[Mapping[str, float]], ratios: Sequence[float]
) -> list[Mapping[str, float]]:
    """Springs and bolts as stiff together as some springs alone, beneath heavy and deep foundations too."""
    found: list[Mapping[str, float]] = []
    deep = DEPTH * length_of(context)
    block = {"mass_below": deep, "below": 2 * deep, "gyration": deep}
    for narrow, ratio in product(some, ratios):
        bolts = {f"bolts_{kind}_ratio": ratio for kind in _kinds(context)}
        softer = {name: value * (1 + 1 / ratio) for name, value in narrow.items() if name in _SPRINGS}
        given = {**narrow, **softer, **bolts}
        found += [{**given, **block, "mass": heavy * context.arm_mass} for heavy in HEAVY]
        if "mass" in narrow:
            found.append(given)
    return found


def bolts_of(placement: Placement) -> list[Spring]:
    """Name and motion of each coordinate between foundation and root, its stiffness and damping."""
    found = []
    for name, way, stiffness, damping in springs(placement):
        number = int(np.argmax(np.abs(way)))
        kind = next(kind for kind, ways in _kinds(placement.context).items() if number in ways)
        ratio = placement[f"bolts_{kind}_ratio"]
        more = damping * ratio * placement["bolts_damping_ratio"]
        found.append((name.replace("base", "bolts"), way, stiffness * ratio, more))
    return found


def _bolted_shape(assembly: Assembly, placement: Placement) -> None:
    names, motion = motions(placement.context.normal)
    for some in (names, [name.replace("base", "bolts") for name in names]):
        assembly.move_root(assembly.add_coordinates(some), motion)


def _bolted_act(assembly: Assembly, placement: Placement) -> None:
    """What is fixed to the foundation moves by its coordinates, the root by those of the bolts too."""
    _act(assembly, placement)
    names, motion = motions(placement.context.normal)
    own = np.array([assembly.row(name.replace("base", "bolts")) for name in names])
    _sprung(assembly, motion @ own, bolts_of(placement))


def _bolted_extend(draft: Draft, placement: Placement) -> None:
    block = draft.under_root(_new_joints(draft, bolts_of(placement)), np.zeros(3))
    draft.under_root(_new_joints(draft, springs(placement)), centre_of(placement))
    draft.attach(block, _own_body(placement, mass_centre(placement)), name="foundation_mass")


def _floor_like(context: Context, values: Mapping[str, float]) -> float:
    return floor_like(context, values, _parameters(context, "base"))


def _bolted_floor_like(context: Context, values: Mapping[str, float]) -> float:
    return floor_like(context, values, _bolted_parameters(context, "base"), bolts_of)


BOLTED = Effect(
    name="base_flexibility",
    says="the foundation gives way",
    places=lambda context: ("base",),
    parameters=_bolted_parameters,
    starts=_starts,
    told=_bolted_told,
    shape=_bolted_shape,
    act=_bolted_act,
    extend=_bolted_extend,
    unlike=_bolted_floor_like,
    unlike_says=SAYS,
)
EFFECT = replace(
    BOLTED,
    parameters=_parameters,
    told=_told,
    shape=_shape,
    act=_act,
    extend=_extend,
    unlike=_floor_like,
    next_level=Level(BOLTED, _bolted_starts),
)
