"""Something balanced on a swivel that gives, such as a bar held in its middle: its mass goes along, it turns.

Its mass moves with the place where it is held and feels turns of the link alone, about one direction on a
spring and a damper (Nestorides, A Handbook on Torsional Vibration, Cambridge 1958), about one across that
firmly.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.absorber_ways import directions
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.attached_point import lever_of
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, along, positive, sides, signed
from flexmodal.diagnosis.improved.draft import DUST, Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, crossed
from flexmodal.structure.assembly import Assembly

FREQUENCIES, MASSES, WIDE = 10, (0.03, 0.1), (0.15, 0.4)
"""From which fits start: over the band, over the arm's, and radii of gyration over the length of the link."""
LEANS = ({"angle": 0.0, "turn": 0.0}, {"angle": 0.0, "turn": 1.57}, {"angle": 1.57, "turn": 0.0})
"""Axes from which fits start: across the link, and along it."""
THIN = 1e-6
"""What a body's moment has to be more than the difference of the other two, over the first, in files."""


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass, (low, high) = context.arm_mass, context.band
    found = [
        positive("mass", "kg", 0.06 * mass, 1.0, 1e-4 * mass, 3 * mass),
        positive("gyration", "m", 0.3 * lever_of(context, where), 0.7, 1e-3, 3.0),
        positive("frequency", "Hz", float(np.sqrt(low * high)), 1.2, 0.7 * low, 1.15 * high),
        positive("damping_ratio", "", 0.03, 0.9, 1e-4, 1.0),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
    ]
    if context.normal is not None:
        return tuple(found)
    return (
        *found,
        signed("above", "m", 0.06, -0.5, 0.5),
        positive("firm", "of the moment", 1.0, 1.0, 1e-3, 10.0),
        signed("angle", "rad", 1.0, -1.7, 1.7),
        *(signed(name, "rad", 2.0, -3.2, 3.2) for name in ("turn", "roll")),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    low, high = context.band
    own = np.geomspace(max(2 * low, 0.05 * high), high, FREQUENCIES).tolist()
    lever, leans = lever_of(context, where), LEANS if context.normal is None else ({},)
    return [
        {"frequency": f, "mass": share * context.arm_mass, "gyration": wide * lever, **lean}
        for f, share, wide, lean in product(own, MASSES, WIDE, leans)
    ]


def _axes(context: Context, where: str, values: Mapping[str, float]) -> list[Float[np.ndarray, " 3"]]:
    """About which it swings, and in space about which it is firm, in the frame of the link."""
    if context.normal is None:
        return list(directions(context, where, values)[:2])
    _, axis = along(context, where)
    return [crossed(axis, sides(context, where, axis)[0])]


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} swivel"])


def _moments(placement: Placement) -> list[float]:
    """About these [kg·m²]."""
    own = placement["mass"] * placement["gyration"] ** 2
    return [own, own * placement.values.get("firm", 0.0)]


def _act(assembly: Assembly, placement: Placement) -> None:
    context, where, values = placement.context, placement.where, placement.values
    motion = assembly.motion(where, place_on(context, where, values))
    assembly.add_together("mass", motion[..., :3, :], np.full(3, placement["mass"]))
    row, frame = assembly.row(f"{where} swivel"), assembly.axes(where)
    moved = (row, np.zeros_like(row))
    for axis, moment, own in zip(_axes(context, where, values), _moments(placement), moved, strict=False):
        turned = np.sum((frame @ axis)[..., :, None] * motion[..., 3:, :], axis=-2)
        assembly.add_inertia(turned + own, moment)
    moment, omega = _moments(placement)[0], 2 * np.pi * placement["frequency"]
    assembly.add_spring(row, moment * omega**2)
    assembly.add_damper(row, 2 * placement["damping_ratio"] * moment * omega)


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    place = dict(zip("xyz", place_on(context, where, values).tolist(), strict=True))
    axis = dict(zip(("dx", "dy", "dz"), _axes(context, where, values)[0].tolist(), strict=True))
    kept = ("mass", "gyration", "frequency", "damping_ratio", "firm")
    return {**{name: values[name] for name in kept if name in values}, **place, **axis}


def _body(placement: Placement) -> Float[np.ndarray, "3 3"]:
    """Its moments; about a direction of which nothing is known as little as a body can have [kg·m²]."""
    own, firm = _moments(placement)
    axis, *across = _axes(placement.context, placement.where, placement.values)
    if not across:  # a disc
        return own / 2 * (np.eye(3) + np.outer(axis, axis))
    last = crossed(axis, across[0])
    third = (1 + THIN) * abs(own - firm) + THIN * own
    moments = ((own, axis), (firm, across[0]), (third, last))
    return np.asarray(sum(moment * np.outer(way, way) for moment, way in moments))


def _extend(draft: Draft, placement: Placement) -> None:
    """Its mass at the place, and a body that turns there on a hinge."""
    context, where, values = placement.context, placement.where, placement.values
    place, name, omega = place_on(context, where, values), f"{where}_swivel", 2 * np.pi * values["frequency"]
    draft.attach(where, Body(values["mass"], place, np.zeros((3, 3))), name=f"{name}_mass")
    part = Body(DUST * draft.arm_mass, place, _body(placement))
    (joint,) = draft.attach(where, part, name=name, hinges=_axes(context, where, values)[:1])
    moment = _moments(placement)[0]
    draft.flexible(joint, moment * omega**2, 2 * values["damping_ratio"] * moment * omega)


SWIVEL = Effect(
    name="local_absorber",
    says="something resilient is attached to the link",
    places=lambda context: context.links,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"x": "m", "y": "m", "z": "m"},
)
