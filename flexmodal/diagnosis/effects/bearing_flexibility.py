"""A joint gives across its axis: its bearing tilts and shifts on springs.

The springs meet somewhere on the axis, which couples tilt and shift as the full stiffness matrix of a rolling
bearing does (Lim and Singh, Journal of Sound and Vibration 139, 1990); a housing may be stiffer one way than
the other. A part of all springs may relax, as a seat of plastic or a film of grease does. In all joints
alike, each tilts on a multiple of its own stiffness, and nothing relaxes.

At the next level tilts have principal directions of their own, as on two bearings in different housings, and
each kind of motion its own loss; all directions may turn with the carried link, as of a shaft that is not
round, or by a part of the joint's angle, as of a cage of rollers; and all springs may be the stiffer the more
the bearing carries, see `weight`. And the spring of the joint is stretched by
shifts of the bearing besides, as where a pinion drives: a mesh gives along its line of action (Kahraman and
others, ASME J. Mechanical Design 114, 1992), so that the drive pushes aside what the bearing carries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.bearing import (
    ALL,
    RADIUS,
    TILT,
    Way,
    add_ways,
    coordinate,
    given,
    joints_at,
    levers,
    size,
    ways,
)
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.relaxation import HELD, RELAXING, add_all_relaxing, relaxation
from flexmodal.diagnosis.effects.relaxation import PART as RELAXATION_PART
from flexmodal.diagnosis.effects.weight import LOADED, loaded, loaded_starts, stiffer
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

FOLLOWS = "follows"
"""Part of the joint's angle by which all directions turn."""
SEEN = 0.03
"""Load over preload from which it is told how files have it."""
_MESH = 1 / RADIUS
"""What a shift adds to the turn that stretches the spring of the joint, about [rad/m]."""


def _places(context: Context) -> tuple[str, ...]:
    turning = tuple(name for name in context.joints if ways(context, name))
    return (*turning, ALL) if context.normal is None and len(turning) > 1 else turning


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    loss = positive("damping_time", "s", 3e-4, 1.5, 1e-7, 0.03)
    if where == ALL:
        return positive("tilt_factor", "", TILT, 2.0, 1e-2 * TILT, 2e3 * TILT), loss
    tilt = size(context, where)
    kinds = [way.kind for way in ways(context, where)]
    found = []
    if "tilt" in kinds:
        found.append(positive("tilt_stiffness", "N·m/rad", tilt, 2.0, tilt / 300, tilt * 3e3))
    for kind in ("radial", "axial"):
        if kind in kinds:
            shift = tilt / RADIUS**2
            found.append(positive(f"{kind}_stiffness", "N/m", shift, 2.0, shift / 300, shift * 3e3))
    found.append(loss)
    if "tilt" in kinds:
        found.append(signed("offset", "m", 0.05, -0.5, 0.5))
    found += [positive("ratio", "", 1.0, 0.4, 0.05, 20.0), signed("angle", "rad", 0.8, -1.6, 1.6)]
    return (*found, *relaxation(context))


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    grid = (0.06, 0.2, 0.6, 2.0, 8.0)
    if where == ALL:
        return [{"tilt_factor": factor * TILT} for factor in grid]
    tilt, kinds = size(context, where), {way.kind for way in ways(context, where)}
    found: list[Mapping[str, float]] = []
    for factor in grid:
        for shift in (0.1, 1.0, 30.0) if "tilt" in kinds else (1.0,):
            other = {f"{kind}_stiffness": factor * shift * tilt / RADIUS**2 for kind in kinds - {"tilt"}}
            found.append({**({"tilt_stiffness": factor * tilt} if "tilt" in kinds else {}), **other})
    return found + [{**start, "relaxing": RELAXING} for start in found[1::3]]


def _wide_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Those of a bearing; in space how tilts differ from shifts, and how losses do."""
    if where == ALL:
        return _parameters(context, where)
    kinds = {way.kind for way in ways(context, where)}
    found = [positive("second_loss_ratio", "", 1.0, 0.7, 0.02, 50.0)]
    found += [signed(FOLLOWS, "of the joint's angle", 0.5, -1.2, 1.2), *loaded()]
    found += [signed(name, "rad/m", _MESH / 2, -10 * _MESH, 10 * _MESH) for name in _mesh(context, where)]
    if "tilt" in kinds:
        found += [positive(f"{kind}_loss_ratio", "", 1.0, 0.7, 0.02, 50.0) for kind in ("radial", "axial")]
        found += [
            positive("tilt_ratio", "of the ratio", 1.0, 0.5, 0.05, 20.0),
            signed("tilt_angle", "rad", 0.8, -1.6, 1.6),
        ]
    return (*_parameters(context, where), *found)


def _wide_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where a fit with the directions of all alike ended, one way round and the other."""
    if where == ALL:
        return []
    known = {**values, "second_loss_ratio": 1.0}
    turning = [
        {FOLLOWS: 1.0, "ratio": ratio, "angle": angle}
        for ratio in (0.3, 1.0)
        for angle in (-0.8, 0.0, 0.8, 1.6)
    ]
    turned = [{"tilt_ratio": ratio, "tilt_angle": angle} for ratio in (0.3, 3.0) for angle in (0.0, 0.8)]
    across = [name for name, way in _mesh(context, where).items() if way.kind == "radial"]
    turned += [{name: sign * _MESH} for name in across for sign in (1, -1)]
    more = [*turned, *turning, *loaded_starts()]
    return [known, {**known, "ratio": 1 / values["ratio"]}, *({**known, **one} for one in more)]


def _mesh(context: Context, where: str) -> dict[str, Way]:
    """Parameters of the shifts that stretch the spring of the joint."""
    return {f"mesh_{way.name.replace(' ', '_')}": way for way in ways(context, where) if not way.turns}


def _end(joint: str, number: int) -> str:
    """Of the relaxing part of a spring."""
    return f"{joint} relaxing {number + 1}"


def _shape(assembly: Assembly, placement: Placement) -> None:
    add_ways(assembly, placement)
    if placement.where != ALL:
        count = len(given(placement.context, placement.where, placement.where))
        assembly.add_coordinates([_end(placement.where, number) for number in range(count)])


_Pulled = list[tuple[Way, float | np.ndarray]]
"""Ways, and the shares of a spring in them."""


def _springs(placement: Placement, joint: str) -> list[tuple[_Pulled, float, float]]:
    """The ways that a spring pulls along with their shares, its stiffness, and its damping over that [s].

    Shares are numbers, or one for each system where directions turn with the joint.
    """
    context, where, values = placement.context, placement.where, placement.values
    some, time = given(context, where, joint), placement["damping_time"]
    if where == ALL:
        spring = placement["tilt_factor"] * size(context, joint) / TILT
        return [([(way, 1.0)], spring, time) for way in some]
    found: list[tuple[_Pulled, float, float]] = []
    for kind in dict.fromkeys(way.kind for way in some):
        along, spring = [way for way in some if way.kind == kind], placement[f"{kind}_stiffness"]
        loss = time * values.get(f"{kind}_loss_ratio", 1.0)
        if len(along) == 1:
            found.append(([(along[0], 1.0)], spring, loss))
            continue
        ratio = placement["ratio"] * values.get(f"{kind}_ratio", 1.0)
        angle = placement["angle"] + values.get(f"{kind}_angle", 0.0) + _turned(placement, joint)
        turned = ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle)))
        for row, factor, more in zip(
            turned, (1.0, ratio), (1.0, values.get("second_loss_ratio", 1.0)), strict=True
        ):
            found.append((list(zip(along, row, strict=True)), spring * factor, loss * more))
    return found


def _turned(placement: Placement, joint: str) -> float | np.ndarray:
    """By how much directions have turned with the joint, in each system [rad]."""
    follows = placement.values.get(FOLLOWS, 0.0)
    if not follows:
        return 0.0
    angles = np.array([posture.q[joint] for posture in placement.context.postures])
    return np.asarray(follows * angles[placement.posture])


def _along(pulled: _Pulled, felt: Mapping[Way, np.ndarray]) -> Float[np.ndarray, "*system dof"]:
    """What a spring is stretched by."""
    return np.asarray(sum(np.asarray(share)[..., None] * felt[way] for way, share in pulled))


def _act(assembly: Assembly, placement: Placement) -> None:
    context, where = placement.context, placement.where
    offset = placement.values.get("offset", 0.0)
    for joint in joints_at(context, where):
        some = given(context, where, joint)
        if not some:
            continue
        rows = np.array([assembly.row(coordinate(joint, way)) for way in some])
        if offset:  # motion of the point where the springs meet
            rows = rows + offset * (levers(context, where, joint) @ rows)
        felt, springs = dict(zip(some, rows, strict=True)), _springs(placement, joint)
        along = np.stack(
            list(np.broadcast_arrays(*(_along(pulled, felt) for pulled, *_ in springs))), axis=-2
        )
        factor = np.asarray(stiffer(placement, joint))[..., None]
        stiffness = factor * np.array([spring for _, spring, _ in springs])
        assembly.add_together("stiffness", along, stiffness)
        assembly.add_together("damping", along, stiffness * np.array([loss for *_, loss in springs]))
        if where != ALL:
            _drive(assembly, placement)
            ends = np.array([assembly.row(_end(joint, number)) for number in range(len(springs))])
            part, time = placement["relaxing"] * stiffness, placement["relaxation_time"]
            add_all_relaxing(assembly, along, ends, part, time, context.band[1])


def _drive(assembly: Assembly, placement: Placement) -> None:
    """The spring and damper of the joint, as the card has them, along the turn and the shift at the mesh.

    What its stiffness is off is taken up by the parameters of the mesh and those of the shifts.
    """
    context, joint = placement.context, placement.where
    shares = {way: placement.values.get(name, 0.0) for name, way in _mesh(context, joint).items()}
    if not any(shares.values()):
        return
    shift = sum(share * assembly.row(coordinate(joint, way)) for way, share in shares.items())
    turn, card = assembly.stretch_of(joint), context.robot.joints[joint]
    stretch = np.asarray(turn + shift)
    assembly.add_spring(stretch, card.stiffness)
    assembly.add_spring(turn, -card.stiffness)
    assembly.add_damper(stretch, card.damping)
    assembly.add_damper(turn, -card.damping)


def _extend(draft: Draft, placement: Placement) -> None:
    context, where = placement.context, placement.where
    offset = placement.values.get("offset", 0.0)
    for joint in joints_at(context, where):
        axis = np.asarray(context.robot.urdf.joint_by_name[joint].axis)
        motions: list[tuple[str, np.ndarray, bool]] = []
        springs: list[tuple[str, float, float]] = []
        for pulled, stiffness, loss in _springs(placement, joint):
            vector = sum((np.ravel(share)[0] * way.vector for way, share in pulled), np.zeros(3))
            way = pulled[0][0]
            name = draft.fresh(f"{joint}_{way.kind}_{len(springs) + 1}")
            motions.append((name, vector, way.turns))
            springs.append((name, stiffness, loss))
        if motions:
            draft.under_joint(joint, motions, offset * axis)
        factor = float(np.ravel(stiffer(placement, joint))[0])
        for name, stiffness, loss in springs:
            draft.flexible(name, factor * stiffness, factor * stiffness * loss)
        if where != ALL:
            _driven(draft, placement, motions, offset * axis)
    if placement.values.get(FOLLOWS, 0.0):
        draft.notes.append(
            f"the files have the springs of the bearing of {where} as they lie in the first posture; they "
            f"turn by {placement[FOLLOWS]:.3g} of its angle"
        )
    if placement.values.get(LOADED, 0.0) > SEEN:
        draft.notes.append(f"the files have the bearing of {where} as its load in the first posture has it")
    if placement.values.get("relaxing", 0.0) > HELD:
        draft.notes.append(
            f"the files have the bearing of {where} and lack what relaxes: {placement['relaxing']:.3g} of "
            f"its stiffness within {placement['relaxation_time']:.3g} s"
        )


def _driven(
    draft: Draft, placement: Placement, motions: Sequence[tuple[str, np.ndarray, bool]], off: np.ndarray
) -> None:
    """What the mesh adds between the joint and the motions of its bearing, and among these."""
    context, joint = placement.context, placement.where
    mesh = sum(
        (placement.values.get(name, 0.0) * way.vector for name, way in _mesh(context, joint).items()),
        np.zeros(3),
    )
    stiffness = float(context.robot.joints[joint].stiffness)
    shares = {name: float(mesh @ (np.cross(off, way) if turns else way)) for name, way, turns in motions}
    felt = {name: share for name, share in shares.items() if share}
    for name, share in felt.items():
        draft.couple(joint, name, stiffness * share)
        draft.stiffen(name, stiffness * share**2)
    for (one, share), (other, more) in combinations(felt.items(), 2):
        draft.couple(one, other, stiffness * share * more)
    if felt:
        draft.notes.append(f"the files have the mesh beside the bearing of {joint} without its damping")


WIDE = Effect(
    name="bearing_flexibility",
    says="the joint gives across its axis",
    places=_places,
    parameters=_wide_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
    parts=(RELAXATION_PART,),
)
EFFECT = replace(WIDE, parameters=_parameters, next_level=Level(WIDE, _wide_starts))
