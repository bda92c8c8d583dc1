"""Something resilient attached to a link: a mass on a spring and damper, free along one direction."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, along, positive, sides, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass = context.arm_mass
    low, high = context.band
    found = [
        positive("mass", "kg", 0.06 * mass, 1.0, 1e-4 * mass, 3 * mass),
        positive("frequency", "Hz", float(np.sqrt(low * high)), 1.2, 0.7 * low, 1.5 * high),
        positive("damping_ratio", "", 0.03, 0.9, 1e-4, 1.0),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        signed("angle", "rad", 0.5, -1.6, 1.6),
    ]
    if context.normal is None:
        found += [signed("above", "m", 0.06, -0.5, 0.5), signed("turn", "rad", 2.0, -3.2, 3.2)]
    return tuple(found)


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Heavy ones, and light ones closer together: a heavy start hides what a light absorber does."""
    low, high = context.band
    first, last = max(3 * low, 0.05 * high), 0.6 * high
    turns: list[dict[str, float]] = [{}] if context.normal is not None else [{"turn": 0.0}, {"turn": 1.57}]
    grid = [(float(f), 0.06, 0.03) for f in np.geomspace(first, last, 10)]
    grid += [(float(f), 0.008, 0.06) for f in np.geomspace(first, last, 16)]
    return [
        {"frequency": f, "mass": share * context.arm_mass, "damping_ratio": ratio, "along": 0.75, **turn}
        for f, share, ratio in grid
        for turn in turns
    ]


def _way(context: Context, where: str, values: Mapping[str, float]) -> np.ndarray:
    """The direction in which it gives, in the frame of the link: across it, turned."""
    _, axis = along(context, where)
    across = sides(context, where, axis)
    side = across[0]
    if len(across) == 2:
        side = np.cos(values["turn"]) * across[0] + np.sin(values["turn"]) * across[1]
    return np.cos(values["angle"]) * side + np.sin(values["angle"]) * axis


def _spring(values: Mapping[str, float]) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N·s/m]."""
    stiffness = values["mass"] * (2 * np.pi * values["frequency"]) ** 2
    return stiffness, 2 * values["damping_ratio"] * float(np.sqrt(stiffness * values["mass"]))


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} absorber"])


def _act(assembly: Assembly, placement: Placement) -> None:
    way = assembly.axes(placement.where) @ _way(placement.context, placement.where, placement.values)
    own = assembly.row(f"{placement.where} absorber")
    mass = placement["mass"]
    place = place_on(placement.context, placement.where, placement.values)
    motion = assembly.motion(placement.where, place)
    for k in range(3):
        assembly.add_inertia(motion[..., k, :] + way[..., k, None] * own, mass)
    stiffness, damping = _spring(placement.values)
    assembly.add_spring(own, stiffness)
    assembly.add_damper(own, damping)


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    x, y, z = place_on(context, where, values).tolist()
    dx, dy, dz = _way(context, where, values).tolist()
    kept = {name: values[name] for name in ("mass", "frequency", "damping_ratio")}
    return {**kept, "stiffness": _spring(values)[0], "x": x, "y": y, "z": z, "dx": dx, "dy": dy, "dz": dz}


def _extend(draft: Draft, placement: Placement) -> None:
    place = place_on(placement.context, placement.where, placement.values)
    way = _way(placement.context, placement.where, placement.values)
    part = Body(placement["mass"], place, np.zeros((3, 3)))
    joint = draft.attach(placement.where, part, name=f"{placement.where}_absorber", slides=way)
    draft.flexible(joint, *_spring(placement.values))


EFFECT = Effect(
    name="local_absorber",
    says="something resilient is attached to the link",
    looks_like="a resonance at nearly the same frequency in every posture, strongest near the place",
    places=lambda context: context.links,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    simpler={"added_mass": ("mass", "along", "beside", "above")},
    physical=_physical,
    extend=_extend,
    units={"stiffness": "N/m", "x": "m", "y": "m", "z": "m"},
)
