"""A payload, motor or tool that the card lacks: a compact mass fixed to a link, on its axis or beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, along, positive, sides, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass = context.arm_mass
    found = [
        positive("mass", "kg", 0.05 * mass, 1.2, 1e-4 * mass, 3 * mass),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        positive("gyration", "m", 0.05, 0.7, 2e-3, 0.5),
    ]
    if context.normal is None:
        found.append(signed("above", "m", 0.06, -0.5, 0.5))
    return tuple(found)


def place_on(context: Context, where: str, values: Mapping[str, float]) -> np.ndarray:
    """A place part of the way along a link and beside its axis, in its frame [m]."""
    length, axis = along(context, where)
    across = sides(context, where, axis)
    place = values["along"] * max(length, 0.05) * axis
    for name, side in zip(("beside", "above"), across, strict=False):
        place = place + values[name] * side
    return place


def _compact(placement: Placement, place: np.ndarray) -> Body:
    """With the same moment of inertia about every axis, as a ball or a cube has."""
    return Body(placement["mass"], place, placement["mass"] * placement["gyration"] ** 2 * np.eye(3))


def _act(assembly: Assembly, placement: Placement) -> None:
    place = place_on(placement.context, placement.where, placement.values)
    assembly.add_body(placement.where, _compact(placement, place))


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    x, y, z = place_on(context, where, values).tolist()
    return {"mass": values["mass"], "x": x, "y": y, "z": z, "gyration": values["gyration"]}


def _extend(draft: Draft, placement: Placement) -> None:
    place = place_on(placement.context, placement.where, placement.values)
    draft.attach(placement.where, _compact(placement, place), name=f"{placement.where}_payload")


EFFECT = Effect(
    name="added_mass",
    says="the link carries a mass that the card lacks",
    looks_like="lower frequencies, most in postures where the link's end moves most, and a lower mass line",
    places=lambda context: context.links,
    parameters=_parameters,
    starts=lambda context, where: [
        {"mass": share * context.arm_mass, "along": place} for share in (0.04, 0.15) for place in (0.4, 0.95)
    ],
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"x": "m", "y": "m", "z": "m"},
)
