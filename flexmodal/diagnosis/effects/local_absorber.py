"""Something resilient attached to a link: a mass on springs and dampers, free along one direction or two.

The second direction is across the first, in the plane of that and the link's axis; its spring is so many
times as stiff, and where that is much the mass is free along one.
"""

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
        positive("across_ratio", "", 1e3, 2.0, 0.02, 1e4),
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


def _ways(context: Context, where: str, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """The directions in which it gives, in the frame of the link: across it, turned; and across that."""
    _, axis = along(context, where)
    across = sides(context, where, axis)
    side = across[0]
    if len(across) == 2:
        side = np.cos(values["turn"]) * across[0] + np.sin(values["turn"]) * across[1]
    cosine, sine = np.cos(values["angle"]), np.sin(values["angle"])
    return cosine * side + sine * axis, cosine * axis - sine * side


def _springs(values: Mapping[str, float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Stiffness [N/m] and damping [N·s/m] along either direction."""
    stiffness = values["mass"] * (2 * np.pi * values["frequency"]) ** 2
    damping = 2 * values["damping_ratio"] * float(np.sqrt(stiffness * values["mass"]))
    across = values["across_ratio"]
    return (stiffness, damping), (across * stiffness, float(np.sqrt(across)) * damping)


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} absorber", f"{placement.where} absorber across"])


def _act(assembly: Assembly, placement: Placement) -> None:
    ways = _ways(placement.context, placement.where, placement.values)
    own, other = (assembly.row(f"{placement.where} absorber{more}") for more in ("", " across"))
    axes = assembly.axes(placement.where)
    along_, across = (axes @ way for way in ways)
    mass = placement["mass"]
    place = place_on(placement.context, placement.where, placement.values)
    motion = assembly.motion(placement.where, place)
    for k in range(3):
        moves = motion[..., k, :] + along_[..., k, None] * own + across[..., k, None] * other
        assembly.add_inertia(moves, mass)
    for row, spring in zip((own, other), _springs(placement.values), strict=True):
        assembly.add_spring(row, spring[0])
        assembly.add_damper(row, spring[1])


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    x, y, z = place_on(context, where, values).tolist()
    dx, dy, dz = _ways(context, where, values)[0].tolist()
    kept = {name: values[name] for name in ("mass", "frequency", "damping_ratio", "across_ratio")}
    return {**kept, "stiffness": _springs(values)[0][0], "x": x, "y": y, "z": z, "dx": dx, "dy": dy, "dz": dz}


def _extend(draft: Draft, placement: Placement) -> None:
    place = place_on(placement.context, placement.where, placement.values)
    ways = _ways(placement.context, placement.where, placement.values)
    part = Body(placement["mass"], place, np.zeros((3, 3)))
    joints = draft.attach(placement.where, part, name=f"{placement.where}_absorber", slides=ways)
    for joint, spring in zip(joints, _springs(placement.values), strict=True):
        draft.flexible(joint, *spring)


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
