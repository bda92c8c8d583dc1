"""Something that hangs on two links, across a joint: a loop of hose, a package of cables between two clips.

Its clips move by a and b. As a string of mass m each part s of its length moves by (1 − s) a + s b, and it
swings besides as sin π s and sin 2π s (Meirovitch, Analytical Methods in Vibrations, Macmillan 1967, on
strings whose ends move). With c = (a + b)/2 and d = (a − b)/2 that is, along each way in which it swings,

    m ((1 − 8/π²) c² + ½ (y + 4 c/π)² + (⅓ − 2/π²) d² + ½ (z + 2 d/π)²),

y on a spring ½ m ω² and z on one as many times as fast; along the way in which it does not m (c² + d²/3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.absorber_start import told_by
from flexmodal.diagnosis.effects.absorber_ways import directions
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import KEPT, Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.rod import size_of, ways
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly

NEAR = ("near_x", "near_y", "near_z")
"""Where the clip on the link before is, from the joint [m]."""
SWUNG = 8 / np.pi**2
"""Part of its mass that swings once its clips move alike."""
COORDINATES = ("", " across", " other", " other across")
"""What it swings along either way, as half a wave and as a whole one."""
BEFORE, FAR, SIZES = (0.0, 0.3), (0.5, 0.9), (0.02, 0.1)
"""Clips from which fits start: before the joint, over the way from the joint before it, and along the link;
and masses, over the arm's."""
HEAVIER = (1.0, 2.5, 6.0)
"""Its mass, over that of an absorber that swings as a function does, from which fits start."""
ANOTHER = 0.1
"""Second mass of an absorber, over its first, that swings as the second way of what hangs on two links."""
_OTHER = {"other": 1e-6, "other_ratio": 0.2}, {"other": 3.0, "other_ratio": 5.0}
"""Least and most of another mass that an absorber has, which this has not."""
FREQUENCIES, SECOND = 6, (2.0, 20.0)
"""Likewise, over the band; and of a whole wave over that of a half one, of a string and of none."""


@lru_cache(maxsize=KEPT)
def joint_of(context: Context, where: str) -> str | None:
    """The joint that carries a link; None where the link is fixed to another.

    Args:
        context: of the diagnosis.
        where: the link.
    """
    urdf = context.robot.urdf
    return next((name for name in context.joints if urdf.joint_by_name[name].child == where), None)


def places(context: Context) -> tuple[str, ...]:
    """Links that a joint carries."""
    return tuple(link for link in context.links if joint_of(context, link) is not None)


def clips(context: Context, where: str) -> tuple[Parameter, ...]:
    """Where its clip on the link before is, from the joint.

    Args:
        context: of the diagnosis.
        where: the link that carries the other one.
    """
    size, count = size_of(context), 2 if context.normal is not None else 3
    return tuple(signed(name, "m", size / 2, -2 * size, 2 * size) for name in NEAR[:count])


def clip_motions(
    assembly: Assembly, placement: Placement
) -> tuple[Float[np.ndarray, "*posture 3 dof"], Float[np.ndarray, "*posture 3 dof"]]:
    """Of both clips, along the axes of the world.

    Args:
        assembly: with all coordinates.
        placement: with the values of `clips` and of a place on the link.
    """
    before, near = _near(placement.context, placement.where, placement.values)
    far = place_on(placement.context, placement.where, placement.values)
    return assembly.motion(before, near)[..., :3, :], assembly.motion(placement.where, far)[..., :3, :]


def halves(
    assembly: Assembly, placement: Placement, ways: Sequence[np.ndarray]
) -> tuple[list[Float[np.ndarray, "*posture dof"]], list[Float[np.ndarray, "*posture dof"]]]:
    """Half of the sum of both clips' motions, and of their difference, along some ways.

    Args:
        assembly: with all coordinates.
        placement: with the values of `clips` and of a place on the link.
        ways: unit vectors in the world, the same in every posture or one for each.
    """
    near, far = clip_motions(assembly, placement)
    alike, apart = (
        [np.sum(way[..., :, None] * half, axis=-2) for way in ways]
        for half in ((near + far) / 2, (near - far) / 2)
    )
    return alike, apart


def _near(context: Context, where: str, values: Mapping[str, float]) -> tuple[str, Float[np.ndarray, " 3"]]:
    """The link before, and where its clip is in its frame."""
    joint = context.robot.urdf.joint_by_name[str(joint_of(context, where))]
    place = np.asarray(joint.xyz, dtype=float)
    for name, way in zip(NEAR, ways(context, joint.parent), strict=False):
        place = place + values[name] * way
    return joint.parent, place


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass, (low, high) = context.arm_mass, context.band
    found = [
        positive("mass", "kg", 0.06 * mass, 1.0, 1e-4 * mass, 3 * mass),
        positive("frequency", "Hz", float(np.sqrt(low * high)), 1.2, 0.7 * low, 1.15 * high),
        positive("damping_ratio", "", 0.03, 0.9, 1e-4, 1.0),
        positive("across_ratio", "", 1.0, 0.7, 0.05, 20.0),
        positive("second_ratio", "of the frequency", 20.0, 1.5, 1.2, 300.0),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        signed("angle", "rad", 0.5, -1.6, 1.6),
    ]
    if context.normal is None:
        turns = (signed(name, "rad", 2.0, -3.2, 3.2) for name in ("turn", "roll"))
        found += [signed("above", "m", 0.06, -0.5, 0.5), *turns]
    return (*found, *clips(context, where))


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    low, high = context.band
    own = np.geomspace(max(3 * low, 0.05 * high), 0.8 * high, FREQUENCIES).tolist()
    turns: list[dict[str, float]] = [{}] if context.normal is not None else [{"turn": 0.0}, {"turn": 1.57}]
    hung = [{"along": far, **_before(context, where, near)} for near, far in product(BEFORE, FAR)]
    return [
        {"frequency": f, "mass": size * context.arm_mass, "second_ratio": second, **clip, **turn}
        for clip, f, size, second, turn in product(hung, own, SIZES, SECOND, turns)
    ]


def hung_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From an absorber on the link as well: as it swings, its second mass along the second way.

    Args:
        context: of the diagnosis.
        where: the link.
        values: of the absorber.
    """
    across = values["other_ratio"] ** 2 if values["other"] > ANOTHER else values["across_ratio"]
    kept = ("frequency", "damping_ratio", "angle", "turn", "roll", "beside", "above")
    swings = {name: values[name] for name in kept if name in values}
    own = {one.name: one for one in _parameters(context, where)}
    swings["across_ratio"] = float(np.clip(across, own["across_ratio"].lower, own["across_ratio"].upper))
    mass = values["mass"] / SWUNG
    hung = [{"along": far, **_before(context, where, near)} for near, far in product(BEFORE, FAR)]
    like_it = [
        {**swings, **clip, "mass": size * mass, "second_ratio": second}
        for clip, size, second in product(hung, (1.0, 2.0), SECOND)
    ]
    return [*like_it, *_starts(context, where)]


def _before(context: Context, where: str, part: float) -> dict[str, float]:
    """A clip on the line from the joint before to the joint that carries the link, so far back."""
    joint = context.robot.urdf.joint_by_name[str(joint_of(context, where))]
    back = -part * np.asarray(joint.xyz, dtype=float)
    along = ways(context, joint.parent)
    return {name: float(back @ way) for name, way in zip(NEAR, along, strict=False)}


def _told(context: Context, where: str, free: FreeFunction) -> Sequence[Mapping[str, float]]:
    """Between the clips that were found, swinging as the function of their mean does."""
    if NEAR[0] not in free.geometry:
        return ()
    of_mean = FreeFunction(free.frequency, free.value[:-1], free.geometry, free.fitted)
    own = _parameters(context, where)
    low, high = {one.name: one.lower for one in own}, {one.name: one.upper for one in own}
    laid = told_by(of_mean, {**low, **_OTHER[0]}, {**high, **_OTHER[1]})
    alike = [{name: one[name] for name in one if name not in _OTHER[0]} for one in laid]
    return [
        {**free.geometry, **one, "mass": size * one["mass"]}  # what is told may be what does not swing
        for one, size in product(alike, HEAVIER)
    ]


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates(_coordinates(placement))


def _coordinates(placement: Placement) -> list[str]:
    planar = placement.context.normal is not None
    return [f"{placement.where} hung{name}" for name in COORDINATES if not planar or "across" not in name]


def _act(assembly: Assembly, placement: Placement) -> None:
    context, mass = placement.context, placement["mass"]
    axes = assembly.axes(placement.where)
    along = [axes @ way for way in directions(context, placement.where, placement.values)]
    means, apart = halves(assembly, placement, along)
    rows = [assembly.row(name) for name in _coordinates(placement)]
    swinging = len(rows) // 2
    for k, (mean, half) in enumerate(zip(means, apart, strict=True)):
        if k >= swinging:
            assembly.add_inertia(mean, mass)
            assembly.add_inertia(half, mass / 3)
            continue
        first, second = rows[k], rows[swinging + k]
        assembly.add_inertia(mean, (1 - SWUNG) * mass)
        assembly.add_inertia(first + 4 / np.pi * mean, mass / 2)
        assembly.add_inertia(half, (1 / 3 - SWUNG / 4) * mass)
        assembly.add_inertia(second + 2 / np.pi * half, mass / 2)
        faster = float(np.sqrt(placement["across_ratio"])) if k else 1.0
        for row, times in ((first, faster), (second, faster * placement["second_ratio"])):
            omega = 2 * np.pi * placement["frequency"] * times
            assembly.add_spring(row, mass / 2 * omega**2)
            assembly.add_damper(row, 2 * placement["damping_ratio"] * mass / 2 * omega)


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    _, near = _near(context, where, values)
    ends = dict(zip(NEAR, near.tolist(), strict=True))
    far = dict(zip("xyz", place_on(context, where, values).tolist(), strict=True))
    kept = ("mass", "frequency", "damping_ratio", "across_ratio", "second_ratio")
    return {**{name: values[name] for name in kept}, **ends, **far}


def _extend(draft: Draft, placement: Placement) -> None:
    """Half of its mass at either clip."""
    half, nothing = placement["mass"] / 2, np.zeros((3, 3))
    before, near = _near(placement.context, placement.where, placement.values)
    far = place_on(placement.context, placement.where, placement.values)
    for link, place in ((before, near), (placement.where, far)):
        draft.attach(link, Body(half, place, nothing), name=f"{placement.where}_hung_on_{link}")
    draft.notes.append(
        f"the files have half of what hangs between {before} and {placement.where} at either clip, and lack "
        f"how it swings, at {placement['frequency']:.3g} Hz"
    )


HUNG_ACROSS = Effect(
    name="local_absorber",
    says="something resilient is attached to the link",
    places=places,
    parameters=_parameters,
    starts=_starts,
    told=_told,
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    units=dict.fromkeys((*NEAR, *"xyz"), "m"),
)
