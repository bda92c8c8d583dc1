"""Ports at joints: one, two together, all at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.dry_friction import NESTED_BY, beside, even, in_a_row
from flexmodal.diagnosis.effects.effect import Placement, signed
from flexmodal.diagnosis.effects.held_tool import directions, directions_tried, held
from flexmodal.diagnosis.effects.held_tool import stiffness_of as tool_stiffness
from flexmodal.diagnosis.effects.rod import cranks, cranks_tried, pairs, stiffness_of, stretch, tightened
from flexmodal.diagnosis.lawfree.port import STILL, Patterns, PortKind, Wider, constant, outer, tensor
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

NESTED_AT = 0.5
"""Ratio of shafts in one another from which a look sets out, over where both springs are even."""


def _stiffness(context: Context, joint: str) -> float:
    return float(context.robot.joints[joint].stiffness)


def _joint_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    row = assembly.stretch_of(placement.where)
    return Patterns(outer(row, row, len(placement.posture))[None])


JOINT = PortKind(
    name="joint",
    says="what drives or holds the joint",
    places=lambda context: context.joints,
    functions=lambda context, where: ("stiffness",),
    sizes=lambda context, where, frequency: constant([_stiffness(context, where)], frequency),
    patterns=_joint_patterns,
)
_BY_BLOW = replace(
    JOINT,
    name="torque",
    says="a torque of the joint that depends on how hard the blow is",
    by_blow=True,
    shape=replace(STILL, variants=("blow",)),
)


def _nested_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Of what one joint's shaft turns against that of the joint beside it."""
    other = beside(placement.context, placement.where)
    row = assembly.stretch_of(placement.where) - placement[NESTED_BY] * assembly.stretch_of(other)
    return Patterns(outer(row, row, len(placement.posture))[None])


def _nested(sign: float) -> Wider:
    """With a shaft that turns the same way, or the other way, as far as both springs are even at first."""

    def parameters(context: Context, where: str) -> tuple[Parameter, ...]:
        size = even(context, where)
        return (signed(NESTED_BY, "", size, -5 * size, 5 * size, centre=sign * NESTED_AT * size),)

    kind = replace(
        _BY_BLOW,
        places=in_a_row,
        shape=replace(STILL, variants=("blow",), parameters=parameters),
        patterns=_nested_patterns,
    )
    return Wider(kind, lambda context, where, values, functions: functions)


TORQUE = replace(_BY_BLOW, wider=(_nested(1.0), _nested(-1.0)))


def _coupling_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    rows = [assembly.stretch_of(name) for name in placement.where.split("+")]
    return Patterns(tensor(rows, len(placement.posture)))


def _coupling_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    one, other = (_stiffness(context, name) for name in where.split("+"))
    return constant([one, float(np.sqrt(one * other)), other], frequency)


COUPLING = PortKind(
    name="coupling",
    says="a mechanism between two joints",
    places=pairs,
    functions=lambda context, where: ("first", "between", "second"),
    sizes=_coupling_sizes,
    patterns=_coupling_patterns,
    parts=lambda where: [
        (JOINT, name, number) for name, number in zip(where.split("+"), (0, 2), strict=True)
    ],
)


def _rod_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    row = stretch(assembly, placement)
    return Patterns(outer(row, row, len(placement.posture))[None])


ROD = PortKind(
    name="rod",
    says="a rod between two links",
    places=pairs,
    functions=lambda context, where: ("stiffness",),
    sizes=lambda context, where, frequency: constant([stiffness_of(context, where)], frequency),
    starts=lambda context, where: ((0.3,), (3.0,)),
    unit="N/m",
    shape=replace(STILL, parameters=cranks),
    geometries=cranks_tried,
    patterns=_rod_patterns,
)


def _balancer_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    row = stretch(assembly, placement)
    along = outer(row, row, len(placement.posture))
    return Patterns((along + tightened(assembly, placement))[None])


BALANCER = replace(
    ROD, name="balancer", says="a stretched spring between two links", patterns=_balancer_patterns
)
"""Without a length of its own, so that it pulls as much as it is long."""


def _held_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    row = held(assembly, placement)
    return Patterns(outer(row, row, len(placement.posture))[None])


HELD = replace(
    ROD,
    name="held",
    says="what holds the tool along a direction by two joints",
    sizes=lambda context, where, frequency: constant([tool_stiffness(context, where)], frequency),
    shape=replace(STILL, parameters=directions),
    geometries=directions_tried,
    patterns=_held_patterns,
)


def _damping_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    total = np.zeros((len(placement.posture), *(len(assembly.coordinates),) * 2))
    for name, joint in placement.context.robot.joints.items():
        row = assembly.stretch_of(name)
        total = total + float(joint.stiffness) * outer(row, row, len(placement.posture))
    return Patterns(total[None])


DAMPING = PortKind(
    name="damping",
    says="the damping of all joints alike",
    places=lambda context: ("joints",),
    functions=lambda context, where: ("share",),
    sizes=lambda context, where, frequency: constant([1.0], frequency),
    unit="",
    patterns=_damping_patterns,
)
