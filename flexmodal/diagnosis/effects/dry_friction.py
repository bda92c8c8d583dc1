"""Joints with dry friction, by describing functions (`nonlinear_stiffness`) and as torques in time.

At the next level what sticks damps as it bends: bristles with a stiffness and a damping (LuGre, Canudas de
Wit, Olsson, Åström and Lischinsky, IEEE Trans. Automatic Control 40, 1995). And there is a second sliding
element beside the first, of other limit and stiffness: the smallest of Iwan's models of sliders that slip one
after the other (Journal of Applied Mechanics 33, 1966). What it slips at may grow with what the joint
carries, as that of a gear does. And what rubs may be a cylinder's seal, whose lever turns with the joint, or
lie behind the joint's spring, as a clamp that slips: beside it the spring is softer by a part of its own.
Beyond that the shafts of two joints in a row run one in the other, and what rubs is how one turns against the
other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.friction_felt import dahl, levelling, mean_load
from flexmodal.diagnosis.effects.swing import one_level, swing_of, typical
from flexmodal.diagnosis.time_domain.law import Law, friction, linear, slow_friction
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

_FRICTION = ("torque", "presliding_stiffness", "exponent", "stiction", "stribeck_speed")
_SLOW = ("slow_torque", "slow_speed")
_LAG = "bristle_time"
_SECOND = ("second_torque", "second_stiffness")
"""Of the second sliding element, over those of the first."""
_CARRIED = ("growing", "wound")
"""Friction over the torque of the joint's spring, and how far a load at rest winds that up."""
_LEVER = ("lever", "lever_angle", "lever_ratio")
"""Of a cylinder that rubs: whether its lever turns with the joint, 1, or not, 0; in the middle of the
postures the angle between its crank and where it hangs, and the crank over how far off that is."""
_SLIPS, SLIPS = "slips", (0.25, 0.5)
"""Part of the joint's stiffness that goes as it slips, and those from which fits start."""
LEAST = 1e-9
"""Lever over the crank at least: at dead centre in all postures it has none."""
_ANGLES = tuple(np.array([-5, -4, -3, -2, 1, 2, 3, 4, 5]) * np.pi / 6)
"""Of the crank in the middle, from which fits set out [rad]."""
NESTED_BY, NESTS = "nested", (0.3, 0.8)
"""What turns against a joint's shaft of the next joint's, over what that joint turns by; and sizes from which
fits start, over where both springs are even."""
_SPEED = 0.7
"""Of the largest speed of a swing, where friction takes most of its energy."""


def _rub(assembly: Assembly, placement: Placement) -> None:
    amplitude, omega = swing_of(placement)
    arm = lever_of(placement)
    amplitude = amplitude * np.abs(arm)
    torque, bristles, exponent, stiction, speed = (placement[name] for name in _FRICTION)
    growing, wound = _carried(placement)
    limit = torque * (1 + stiction * np.exp(-((_SPEED * amplitude * omega / speed) ** 2)))
    limit = limit + growing * mean_load(amplitude, wound)
    stiffness, loss = dahl(amplitude, limit, bristles, exponent)
    turned = omega * placement.values.get(_LAG, 0.0)
    stiffness, loss = stiffness - turned * loss, loss + turned * stiffness
    if _SECOND[0] in placement.values:
        later = dahl(amplitude, torque * placement[_SECOND[0]], bristles * placement[_SECOND[1]], exponent)
        stiffness, loss = stiffness + later[0], loss + later[1]
    row = _drawn(assembly, placement, arm)
    assembly.add_spring(assembly.stretch_of(placement.where), -_lost(placement))
    assembly.add_spring(row, stiffness)
    assembly.add_damper(row, loss / omega)
    assembly.add_damper(row, levelling(amplitude * omega, *(placement[name] for name in _SLOW)))


def lever_of(placement: Placement) -> Float[np.ndarray, "*system"]:
    """How much longer a cylinder gets for each radian of its joint, over the root mean square of that.

    With its crank a and where it hangs b from the joint, and the angle φ between these two, it is
    √(a² + b² − 2 a b cos φ) long, so that the lever is a b sin φ over that (the law of cosines).

    Args:
        placement: of friction; 1 where its law has no lever.
    """
    if not placement.values.get(_LEVER[0]):
        return np.ones(len(placement.posture))
    part, middle, ratio = (placement[name] for name in _LEVER)
    every = [one.q.get(placement.where, 0.0) for one in placement.context.postures]
    angle = middle + np.array(every) - np.mean(every)
    arm = np.sin(angle) / np.sqrt(1 + ratio**2 - 2 * ratio * np.cos(angle))
    arm = arm / max(float(np.sqrt(np.mean(arm**2))), LEAST)
    return np.asarray((1 + part * (arm - 1))[placement.posture])


def _drawn(assembly: Assembly, placement: Placement, arm: np.ndarray) -> Float[np.ndarray, "*system dof"]:
    """The row of what rubs, by its lever; of shafts in one another what one turns against the other."""
    row = assembly.stretch_of(placement.where)
    if NESTED_BY in placement.values:
        return np.asarray(
            row - placement[NESTED_BY] * assembly.stretch_of(beside(placement.context, placement.where))
        )
    return np.asarray(arm[:, None] * row) if _LEVER[0] in placement.values else row


def beside(context: Context, where: str) -> str:
    """The joint after one, or before it where it is the last.

    Args:
        context: of the diagnosis.
        where: one of `in_a_row`.
    """
    order = context.joints
    at = order.index(where)
    return order[at + 1] if at + 1 < len(order) else order[at - 1]


def in_a_row(context: Context) -> tuple[str, ...]:
    """Joints beside another one: all, unless there is but one."""
    return context.joints if len(context.joints) > 1 else ()


def _carried(placement: Placement) -> tuple[float, float]:
    """By how much the limit grows with the elongation [N·m/rad], and how far it is wound up at rest [rad]."""
    context, where = placement.context, placement.where
    growing, wound = (placement.values.get(name, 0.0) for name in _CARRIED)
    return growing * float(context.robot.joints[where].stiffness), wound * typical(context, where)[0]


def _lost(placement: Placement) -> float:
    """By how much the joint's spring is softer where it slips [N·m/rad]."""
    stiffness = float(placement.context.robot.joints[placement.where].stiffness)
    return placement.values.get(_SLIPS, 0.0) * stiffness


def _rubbing(assembly: Assembly, placement: Placement) -> tuple[Law, ...]:
    row = _drawn(assembly, placement, lever_of(placement))
    torque, bristles, exponent, stiction, speed = (placement[name] for name in _FRICTION)
    lag = placement.values.get(_LAG, 0.0)
    hysteretic = friction(row, torque, bristles, exponent, stiction, speed, lag, *_carried(placement))
    slow = slow_friction(row, *(placement[name] for name in _SLOW))
    if _SECOND[0] not in placement.values:
        return hysteretic, slow
    second = friction(row, torque * placement[_SECOND[0]], bristles * placement[_SECOND[1]], exponent)
    lost = linear(assembly.stretch_of(placement.where), -_lost(placement))
    return hysteretic, slow, second, lost


def _friction_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = float(context.robot.joints[where].stiffness)
    size, speed = typical(context, where)
    torque = 0.1 * k * size
    return (
        positive("torque", "N·m", torque, 1.2, torque / 1e3, torque * 1e3),
        positive("presliding_stiffness", "N·m/rad", 5 * k, 0.7, 0.1 * k, 200 * k),
        signed("exponent", "", 0.4, 0.0, 1.6, centre=1.0),
        positive("stiction", "", 0.02, 1.5, 1e-3, 4.0),
        positive("stribeck_speed", "rad/s", 0.3 * speed, 1.2, 1e-3 * speed, 10 * speed),
        positive("slow_torque", "N·m", 0.003 * torque, 2.0, torque / 1e5, torque * 1e3),
        positive("slow_speed", "rad/s", 0.3 * speed, 1.2, 1e-3 * speed, 10 * speed),
        positive("reach", "", 1.0, 0.7, 0.05, 20.0),
    )


def _friction_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    stiffness = float(context.robot.joints[where].stiffness)
    size = 0.1 * stiffness * typical(context, where)[0]
    found = [{"torque": share * size} for share in (0.2, 1.0, 4.0)]
    found += [{"torque": share * size, "presliding_stiffness": 50 * stiffness} for share in (4.0, 16.0)]
    return [
        *found,
        {"torque": size, "stiction": 0.5},
        *({"torque": 0.01 * size, "slow_torque": share * size} for share in (0.3, 2.0)),
    ]


def _bristle_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    low, high = (1 / (2 * np.pi * edge) for edge in context.band[::-1])
    centre = 0.1 * float(np.sqrt(low * high))
    return (
        *_friction_parameters(context, where),
        positive(_LAG, "s", centre, 2.0, 1e-3 * low, high),
        positive(_SECOND[0], "of the first", 0.1, 2.0, 1e-4, 100.0),
        positive(_SECOND[1], "of the first", 0.3, 1.5, 1e-3, 100.0),
        positive(_CARRIED[0], "of the torque carried", 1e-3, 2.5, 1e-7, 1.0),
        signed(_CARRIED[1], "of the swing", 1.0, -30.0, 30.0),
        signed(_LEVER[0], "", 0.5, 0.0, 1.0),
        signed(_LEVER[1], "rad", 1.0, -np.pi, np.pi, centre=np.pi / 2),
        positive(_LEVER[2], "", 0.3, 0.7, 0.02, 3.0),
        positive(_SLIPS, "of the joint's stiffness", 1e-3, 2.0, 1e-6, 0.95),
    )


def _bristle_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where the narrower law was, and with some of its other numbers elsewhere."""
    slow = 1 / (2 * np.pi * float(np.sqrt(context.band[0] * context.band[1])))
    loose = {**values, "slow_torque": 0.01 * values["torque"]}
    stiff = {**loose, "presliding_stiffness": 3 * values["presliding_stiffness"]}
    none = dict(zip(_SECOND, (1e-3, 0.1), strict=True))
    found: list[Mapping[str, float]] = [
        {**one, **none, _LAG: share * slow} for one in (values, loose, stiff) for share in (0.03, 0.3, 1.0)
    ]
    second = [(0.1, 1.0), (0.3, 0.3), (1.0, 0.3), (3.0, 0.5), (10.0, 1.0)]
    held = {**loose, _LAG: 1e-3 * slow}
    found += [{**held, **dict(zip(_SECOND, each, strict=True))} for each in second]
    stiffness = float(context.robot.joints[where].stiffness)
    size = stiffness * typical(context, where)[0]
    slipping = [
        {_SLIPS: part, "presliding_stiffness": part * stiffness, "torque": share * part * size}
        for part in SLIPS
        for share in (0.1, 0.3, 1.0)
    ]
    found += [{**held, **none, **one} for one in slipping]
    light = {**held, **none, "torque": 0.3 * values["torque"]}
    loads = [(share, wound) for share in (0.03, 0.2) for wound in (0.0, 1.0, -1.0)]
    found += [{**light, **dict(zip(_CARRIED, each, strict=True))} for each in loads]
    if len({one.q.get(where, 0.0) for one in context.postures}) == 1:
        return found
    arms = [dict(zip(_LEVER, (1.0, angle, 0.3), strict=True)) for angle in _ANGLES]
    return [*found, *({**held, **none, **one} for one in arms)]


def _nested_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size = even(context, where)
    return (*_friction_parameters(context, where), signed(NESTED_BY, "", 0.5 * size, -5 * size, 5 * size))


def even(context: Context, where: str) -> float:
    """√(k'/k) of the joint beside one and of it.

    Args:
        context: of the diagnosis.
        where: the one.
    """
    joints, other = context.robot.joints, beside(context, where)
    return float(np.sqrt(joints[other].stiffness / joints[where].stiffness))


def _nested_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    own = [one.name for one in _friction_parameters(context, where)]
    kept = {name: values[name] for name in own}
    ratios = [sign * size * even(context, where) for size in NESTS for sign in (1, -1)]
    return [
        {**kept, "torque": size * kept["torque"], NESTED_BY: ratio} for ratio in ratios for size in (1.0, 2.0)
    ]


BRISTLES = Effect(
    name="coulomb_friction",
    says="the joint has dry friction",
    places=lambda context: context.joints,
    parameters=_bristle_parameters,
    starts=_friction_starts,
    act=_rub,
    law=_rubbing,
    variants=("blow",),
    untestable=one_level,
    physical=lambda context, where, values: {
        name: values[name]
        for name in (*_FRICTION, *_SLOW, _LAG, *_SECOND, *_CARRIED, *_LEVER, _SLIPS, NESTED_BY)
        if name in values
    },
    sticks=True,
)
NESTED = replace(
    BRISTLES,
    places=in_a_row,
    parameters=_nested_parameters,
)
EFFECT = replace(
    BRISTLES,
    parameters=_friction_parameters,
    next_level=Level(replace(BRISTLES, next_level=Level(NESTED, _nested_starts)), _bristle_starts),
)
