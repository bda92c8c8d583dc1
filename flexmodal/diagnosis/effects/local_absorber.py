"""Something resilient attached to a link: a mass on springs and dampers, free along one direction or two.

The second direction is across the first; its spring is so many times as stiff, and where that is much the
mass is free along one. There may be another mass at the same place that swings along the second direction
alone; where it weighs next to nothing there is none. Part of the first spring may relax, as that of rubber: a
Maxwell element beside it, a standard linear solid's (Zener, Elasticity and Anelasticity of Metals, University
of Chicago Press 1948).

At the next level it has more modes, see `absorber_further`; beyond that it hangs on two links, see
`hung_across`, or turns on a swivel, see `swivel`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.absorber_further import (
    BELOW,
    FURTHER,
    GYRATION,
    NO_TURN,
    NOTHING,
    STILL,
    TURNS,
    add_beyond,
    coordinates,
    extend_beyond,
    lines,
    parameters_beyond,
    starts_beyond,
)
from flexmodal.diagnosis.effects.absorber_start import told_by, turning_by
from flexmodal.diagnosis.effects.absorber_ways import directions
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.attached_point import at_its_point
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.hung_across import HUNG_ACROSS, NEAR, hung_starts
from flexmodal.diagnosis.effects.relaxation import HELD, add_relaxing
from flexmodal.diagnosis.effects.swivel import SWIVEL
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly

HIGHEST = 1.15
"""Of the band's end, up to which something swings; what is stiffer is a mass."""

COORDINATES = ("", " across", " other", " relaxing")
"""What the mass does along its directions, what another one does along the second, and what relaxes."""


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass = context.arm_mass
    low, high = context.band
    found = [
        positive("mass", "kg", 0.06 * mass, 1.0, 1e-4 * mass, 3 * mass),
        positive("frequency", "Hz", float(np.sqrt(low * high)), 1.2, 0.7 * low, HIGHEST * high),
        positive("damping_ratio", "", 0.03, 0.9, 1e-4, 1.0),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        signed("angle", "rad", 0.5, -1.6, 1.6),
        positive("across_ratio", "", 1e3, 2.0, 0.02, 1e4),
        positive("other", "of the mass", 0.003, 2.0, 1e-6, 3.0),
        positive("other_ratio", "of the frequency", 1.7, 0.6, 0.2, 5.0),
        positive("relaxing", "of the stiffness", 2e-3, 2.5, 1e-8, 3.0),
        positive("relaxation_time", "s", float(0.5 / np.pi / np.sqrt(low * high)), 1.2, 0.02 / high, 2 / low),
    ]
    if context.normal is None:
        turns = (signed(name, "rad", 2.0, -3.2, 3.2) for name in ("turn", "roll"))
        found += [signed("above", "m", 0.06, -0.5, 0.5), *turns]
    return tuple(found)


def _wide_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    return (*_parameters(context, where), *parameters_beyond())


def _wide_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where the narrower law was, with and without its other mass, and free along both directions."""
    alone = {**values, "other": 1e-3}
    both = {**alone, "across_ratio": 1.0}
    return [{**one, **more} for one in (values, alone, both) for more in starts_beyond()]


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Heavy ones, and light ones closer together: a heavy start hides what a light absorber does."""
    low, high = context.band
    first, last = max(3 * low, 0.05 * high), 0.6 * high
    turns: list[dict[str, float]] = [{}] if context.normal is not None else [{"turn": 0.0}, {"turn": 1.57}]
    grid = [(float(f), 0.06, 0.03) for f in np.geomspace(first, last, 10)]
    grid += [(float(f), 0.008, 0.06) for f in np.geomspace(first, last, 16)]
    found: list[Mapping[str, float]] = [
        {"frequency": f, "mass": share * context.arm_mass, "damping_ratio": ratio, "along": 0.75, **turn}
        for f, share, ratio in grid
        for turn in turns
    ]
    further = [{"other": 0.7, "other_ratio": ratio} for ratio in (0.6, 1.7)]
    further += [{"across_ratio": ratio} for ratio in (0.4, 2.5)]
    further += [{"relaxing": 0.3}]
    return found + [{**one, **more} for one in found[: 10 * len(turns)] for more in further]


def _told(context: Context, where: str, free: FreeFunction) -> list[dict[str, float]]:
    """Where the port sits, with an absorber whose dynamic stiffness is like its functions."""
    if NEAR[0] in free.geometry:  # of what hangs on two links
        return []
    return _laid(_parameters(context, where), at_its_point(context, where, free)[0] if free.turns else free)


def _laid(known: tuple[Parameter, ...], free: FreeFunction) -> list[dict[str, float]]:
    found = told_by(free, {one.name: one.lower for one in known}, {one.name: one.upper for one in known})
    return [{**free.geometry, **values} for values in found]


def _wide_told(context: Context, where: str, free: FreeFunction) -> list[dict[str, float]]:
    """The same with more modes; a port of motions alone does not say what turns."""
    known = _wide_parameters(context, where)
    if NEAR[0] in free.geometry:
        return []
    if not free.turns:
        turning = ({GYRATION: NO_TURN}, *lines())
        return [{**one, BELOW: 0.0, **more} for one in _laid(known, free) for more in turning]
    here, turns = at_its_point(context, where, free)
    some = free.frequency > 0
    omega = 2 * np.pi * free.frequency[some]
    return [
        {
            **one,
            BELOW: 0.0,
            **dict(zip((GYRATION, TURNS, STILL), turning_by(omega, turns[some], one), strict=True)),
        }
        for one in _laid(known, here)
    ]


def _springs(values: Mapping[str, float]) -> tuple[tuple[float, float], ...]:
    """Stiffness [N/m] and damping [N·s/m] along either direction, and of the other mass."""
    own, loss, mass = 2 * np.pi * values["frequency"], 2 * values["damping_ratio"], values["mass"]
    faster = float(np.sqrt(values["across_ratio"])) * own
    apart, other = values["other_ratio"] * own, values["other"] * mass
    return tuple((m * w**2, loss * m * w) for m, w in ((mass, own), (mass, faster), (other, apart)))


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} absorber{name}" for name in COORDINATES])


def _wide_shape(assembly: Assembly, placement: Placement) -> None:
    _shape(assembly, placement)
    assembly.add_coordinates(coordinates(placement.where, planar=assembly.normal is not None))


def _act(assembly: Assembly, placement: Placement) -> None:
    values, where = placement.values, placement.where
    axes = assembly.axes(where)
    ways = [axes @ way for way in directions(placement.context, where, values)]
    place = place_on(placement.context, where, values)
    motion = assembly.motion(where, place)[..., :3, :]
    carried = [np.sum(way[..., :, None] * motion, axis=-2) for way in ways]
    own, across, other, relaxing = (assembly.row(f"{where} absorber{name}") for name in COORDINATES)
    mass, still = values["mass"], np.zeros_like(own)
    for body, swung in ((mass, (own, across, still)), (values["other"] * mass, (still, other, still))):
        for moves, row in zip(carried, swung, strict=True):
            assembly.add_inertia(moves + row, body)
    if FURTHER in values:
        places = (place, _below(placement.context, where, values))
        add_beyond(assembly, where, ways, places, values, _springs(values)[:2])
    for row, spring in zip((own, across, other), _springs(values), strict=True):
        assembly.add_spring(row, spring[0])
        assembly.add_damper(row, spring[1])
    relaxes, time = values["relaxing"] * _springs(values)[0][0], values["relaxation_time"]
    add_relaxing(assembly, own, relaxing, relaxes, time, placement.context.band[1])


def _below(context: Context, where: str, values: Mapping[str, float]) -> Float[np.ndarray, " 3"]:
    """Where the further mass sits, in the frame of the link [m]."""
    least = directions(context, where, values)[1 if context.normal is not None else 2]
    return np.asarray(place_on(context, where, values) - values[BELOW] * least)


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    x, y, z = place_on(context, where, values).tolist()
    first, second = (way.tolist() for way in directions(context, where, values)[:2])
    ways = dict(zip(("dx", "dy", "dz", "across_x", "across_y", "across_z"), [*first, *second], strict=True))
    where_and_how = {"along", "beside", "above", "angle", "turn", "roll"}
    own = [one.name for one in _wide_parameters(context, where) if one.name in values]
    kept = {name: values[name] for name in own if name not in where_and_how}
    return {**kept, "stiffness": _springs(values)[0][0], "x": x, "y": y, "z": z, **ways}


def _extend(draft: Draft, placement: Placement) -> None:
    values, name = placement.values, f"{placement.where}_absorber"
    place = place_on(placement.context, placement.where, values)
    first, second, least = directions(placement.context, placement.where, values)
    *springs, apart = _springs(values)
    part = Body(values["mass"], place, np.zeros((3, 3)))
    for joint, spring in zip(
        draft.attach(placement.where, part, name=name, slides=(first, second)), springs, strict=True
    ):
        draft.flexible(joint, *spring)
    if values["other"] > NOTHING:
        part = Body(values["other"] * values["mass"], place, np.zeros((3, 3)))
        (joint,) = draft.attach(placement.where, part, name=f"{name}_other", slides=(second,))
        draft.flexible(joint, *apart)
    if FURTHER in values:
        places = (place, _below(placement.context, placement.where, values))
        planar = placement.context.normal is not None
        extend_beyond(draft, placement.where, (first, second, least), places, values, springs, planar=planar)
    if values["relaxing"] > HELD:
        draft.notes.append(
            f"the files have the spring of {name} and lack what relaxes: {values['relaxing']:.3g} of its "
            f"stiffness within {values['relaxation_time']:.3g} s"
        )


WIDE = Effect(
    name="local_absorber",
    says="something resilient is attached to the link",
    places=lambda context: context.links,
    parameters=_wide_parameters,
    starts=_starts,
    told=_wide_told,
    shape=_wide_shape,
    act=_act,
    simpler={"added_mass": ("mass", "along", "beside", "above")},
    limit="frequency",
    physical=_physical,
    extend=_extend,
    units={"stiffness": "N/m", "x": "m", "y": "m", "z": "m"},
    next_level=Level(replace(HUNG_ACROSS, next_level=Level.anew(SWIVEL)), hung_starts),
)
EFFECT = replace(WIDE, parameters=_parameters, shape=_shape, told=_told, next_level=Level(WIDE, _wide_starts))
