"""A payload, motor or tool that the card lacks: a compact mass on a link, on its axis or beside it.

In space it may be a disc or a rod, turned as it likes: its tensor of inertia is any that a body has. What
holds it may give, alike in every direction, so little that it swings beyond the band only; what swings
within is an absorber.

At the next level it is a tank that is not full. All of its liquid goes up and down, sideways a part of it
stays behind: it swings slowly, as on springs (Abramson, ed., NASA SP-106, 1966). Or it is grain that has run
to its lowest place: as far below a place on the link in every posture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, along, positive, sides, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly

SHORTEST = 0.05
"""Length of a link at least, by which places along it are told [m]."""
LOWEST = 1.15
"""Of the band's end, above which a mass swings on what holds it."""
RIGID = 8.0
"""Likewise, above which files hold the mass as rigid."""
LOSS = 0.03
"""Damping ratio of that, which is not to be seen so far below."""
HANGING = 0.97
"""Part of what hangs on a rope that stays behind sideways, from which fits start."""
FROZEN = 0.02
"""Of a liquid, up to which no file lacks what swings."""
SLOSH = ("sloshing", "slosh_frequency", "slosh_damping_ratio", "slosh_height")
"""Part of a liquid that swings by itself; how fast and with what loss, and how far above the centre."""
SUNK, SUNKEN = "sunk", signed("sunk", "m", 0.05, -0.5, 0.5)
"""How far below its place the centre of what has settled or hangs there is, whatever the posture."""
SETTLED = (0.05, 0.15)
"""Such depths from which fits start [m]."""
RATIOS, LEANS = ("length_ratio", "side_ratio"), ("length_side_lean", "length_across_lean", "side_across_lean")
"""In space, spreads of the mass along the link and to a side over that across both; and how it leans."""


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass, high = context.arm_mass, context.band[1]
    found = [
        positive("mass", "kg", 0.05 * mass, 1.2, 1e-4 * mass, 3 * mass),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        positive("gyration", "m", 0.05, 0.7, 2e-3, 0.5),
        positive("mount_frequency", "Hz", 50 * high, 1.5, LOWEST * high, 500 * high),
    ]
    if context.normal is None:
        found.append(signed("above", "m", 0.06, -0.5, 0.5))
        found += [positive(name, "", 1.0, 0.5, 0.05, 20.0) for name in RATIOS]
        found += [signed(name, "", 0.7, -6.0, 6.0) for name in LEANS]
    return tuple(found)


def _liquid_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Of a tank of some decimetres the liquid swings at 1 to 3 Hz."""
    rigid = (one for one in _parameters(context, where) if one.name != "mount_frequency")
    return (
        *rigid,
        positive("sloshing", "of the mass", 0.1, 1.5, 1e-4, 0.999),
        positive("slosh_frequency", "Hz", 2.0, 0.5, 0.3, 10.0),
        positive("slosh_damping_ratio", "", 0.05, 0.7, 1e-3, 0.5),
        signed("slosh_height", "m", 0.05, -0.5, 0.5),
        SUNKEN,
    )


def _liquid_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    liquid = [
        {**values, "mass": size * values["mass"], "sloshing": part}
        for part in (0.1, 0.3, 0.6, HANGING)
        for size in (1.0, 1.4, *((3.0,) if part == HANGING else ()))
    ]
    return [*liquid, *({**values, "sloshing": 1e-3, SUNK: depth} for depth in SETTLED)]


def sunk(motion: Float[np.ndarray, "*posture 6 dof"], depth: float) -> Float[np.ndarray, "*posture 3 dof"]:
    """How a point moves that is so far below another one, whose motion is given, in the same body.

    Args:
        motion: along the axes of the world, and turns about them.
        depth: [m].
    """
    moved = motion[..., :3, :].copy()
    moved[..., 0, :] -= depth * motion[..., 4, :]
    moved[..., 1, :] += depth * motion[..., 3, :]
    return moved


def place_on(context: Context, where: str, values: Mapping[str, float]) -> np.ndarray:
    """A place part of the way along a link and beside its axis, in its frame [m].

    Args:
        context: of the diagnosis.
        where: name of the link.
        values: of the effect: along as part of the length, beside and above [m].
    """
    length, axis = along(context, where)
    across = sides(context, where, axis)
    place = values["along"] * max(length, SHORTEST) * axis
    for name, side in zip(("beside", "above"), across, strict=False):
        place = place + values[name] * side
    return place


def _body(placement: Placement, place: np.ndarray) -> Body:
    """The mass with its moments of inertia tr(S) − S [kg·m²], of its spreads S = m r²/2 exp A.

    A is symmetric along the link, to a side and across both, so that some body has them: twice the logarithms
    of the ratios are on its diagonal, beside it how the mass leans.
    """
    _, axis = along(placement.context, placement.where)
    first, *_ = sides(placement.context, placement.where, axis)
    ways, grown = np.stack([axis, first, np.cross(axis, first)], axis=1), np.zeros((3, 3))
    grown[[0, 1], [0, 1]] = [2 * np.log(placement.values.get(name, 1.0)) for name in RATIOS]
    grown[[1, 2, 2], [0, 0, 1]] = [placement.values.get(name, 0.0) for name in LEANS]
    sizes, turned = np.linalg.eigh(grown)
    root = ways @ turned * np.exp(sizes / 2)  # its square is symmetric to the last digit
    spread = placement["mass"] * placement["gyration"] ** 2 / 2 * (root @ root.T)
    return Body(placement["mass"], place, np.trace(spread) * np.eye(3) - spread)


def _ways(context: Context, where: str) -> list[np.ndarray]:
    """Unit vectors along which a mount gives, in the frame of the link; in a planar chain two."""
    _, axis = along(context, where)
    return [axis, *sides(context, where, axis)]


def _coordinates(context: Context, where: str) -> list[str]:
    return [f"{where} mount {number}" for number, _ in enumerate(_ways(context, where))]


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates(_coordinates(placement.context, placement.where))


def _act(assembly: Assembly, placement: Placement) -> None:
    context, where, mass = placement.context, placement.where, placement["mass"]
    place = place_on(context, where, placement.values)
    motion = assembly.motion(where, place)
    axes, own = assembly.axes(where), 2 * np.pi * placement["mount_frequency"]
    for name, way in zip(_coordinates(context, where), _ways(context, where), strict=True):
        row = assembly.row(name)
        carried = np.sum((axes @ way)[..., :, None] * motion[..., :3, :], axis=-2)
        assembly.add_inertia(carried + row, mass)
        assembly.add_spring(row, mass * own**2)
        assembly.add_damper(row, 2 * LOSS * mass * own)
    assembly.add_body(where, replace(_body(placement, place), mass=0.0))


def _liquid_shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} slosh {axis}" for axis in "xy"])


def _liquid_act(assembly: Assembly, placement: Placement) -> None:
    """Up along z of the world; what swings is above the centre of the whole, what stays below it."""
    where, mass = placement.where, placement["mass"]
    part, own, ratio, high = (placement[name] for name in SLOSH)
    place = place_on(placement.context, where, placement.values)
    motion, omega = assembly.motion(where, place), 2 * np.pi * own
    moved, tilted = sunk(motion, placement[SUNK]), (motion[..., 4, :], -motion[..., 3, :])
    assembly.add_inertia(moved[..., 2, :], mass)
    for axis, name in enumerate("xy"):
        row = assembly.row(f"{where} slosh {name}")
        level, lever = moved[..., axis, :], high * tilted[axis]
        assembly.add_inertia(level - part / (1 - part) * lever, (1 - part) * mass)
        assembly.add_inertia(level + lever + row, part * mass)
        assembly.add_spring(row, part * mass * omega**2)
        assembly.add_damper(row, 2 * ratio * part * mass * omega)
    assembly.add_body(where, replace(_body(placement, place), mass=0.0))


def _liquid_extend(draft: Draft, placement: Placement) -> None:
    """All of it, as if it were frozen."""
    where, place = placement.where, place_on(placement.context, placement.where, placement.values)
    draft.attach(where, _body(placement, place), name=f"{where}_payload")
    if placement[SUNK]:
        lower = f"it lies {placement[SUNK]:.3g} m below that"
        draft.notes.append(f"the files have the mass on {where} at a place of the link; {lower}")
    if placement["sloshing"] > FROZEN:
        part = f"{placement['sloshing']:.3g} of it stays behind sideways"
        draft.notes.append(f"the files have the mass on {where} as rigid: {part}")


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    x, y, z = place_on(context, where, values).tolist()
    return {
        "mass": values["mass"],
        "x": x,
        "y": y,
        "z": z,
        **{name: values[name] for name in ("gyration", "mount_frequency", *SLOSH, SUNK) if name in values},
    }


def _extend(draft: Draft, placement: Placement) -> None:
    place = place_on(placement.context, placement.where, placement.values)
    body, own = _body(placement, place), 2 * np.pi * placement["mount_frequency"]
    ways = _ways(placement.context, placement.where)
    gives = placement["mount_frequency"] < RIGID * placement.context.band[1]
    joints = draft.attach(
        placement.where, body, name=f"{placement.where}_payload", slides=ways if gives else ()
    )
    for joint in joints if gives else ():
        draft.flexible(joint, body.mass * own**2, 2 * LOSS * body.mass * own)


RIGID_MASS = Effect(
    name="added_mass",
    says="the link carries a mass that the card lacks",
    places=lambda context: context.links,
    parameters=_parameters,
    starts=lambda context, where: [
        {"mass": share * context.arm_mass, "along": place} for share in (0.04, 0.15) for place in (0.4, 0.95)
    ],
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    hides_in=("mass.", "inertia."),
    units={"x": "m", "y": "m", "z": "m"},
)
LIQUID = replace(
    RIGID_MASS, parameters=_liquid_parameters, shape=_liquid_shape, act=_liquid_act, extend=_liquid_extend
)
EFFECT = replace(RIGID_MASS, next_level=Level(LIQUID, _liquid_starts))
