"""A parallel mechanism ties two joints: a block of stiffness, off the diagonal and on it.

A spring between q₁ and r q₂ adds k to the first joint, r² k to the second and −r k between them; what of that
lies on the diagonal may be more than the trust in the joints' own stiffness allows for. Its damper is a
multiple of it.

Halfway along the spring an idler may turn: as the mean of q₁ and r q₂ where it is slow, and by a coordinate
of its own against both halves of the spring, with a frequency of its own. A part of the spring may relax, as
a belt does. At its next level it is a rod between two cranks, which ties the joints differently by posture;
beyond that what holds the tool along a direction does, and then a belt over a roller on a spring.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.held_tool import HELD_TOOL
from flexmodal.diagnosis.effects.relaxation import HELD as RELAXATION_HELD
from flexmodal.diagnosis.effects.relaxation import PART as RELAXATION_PART
from flexmodal.diagnosis.effects.relaxation import RELAXING, add_relaxing, relaxation
from flexmodal.diagnosis.effects.rod import ROD, pairs
from flexmodal.diagnosis.effects.tensioner import TENSIONED
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

MOST = 30.0
"""Stiffness of a mechanism at most, over the joints'."""
LEAST = 1e-6
"""The same of what relaxes, whose end may not be without a stiffness."""
HELD = 0.05
"""Stiffness of an idler's swing or of the damper at the end of the band, over that of the coupling, from
which it is told that no file holds it."""


def _joints(context: Context, where: str) -> tuple[float, float]:
    """Stiffness of either joint by the card [N·m/rad]."""
    one, other = where.split("+")
    return float(context.robot.joints[one].stiffness), float(context.robot.joints[other].stiffness)


def _size(context: Context, where: str) -> float:
    """√(k₁ k₂) of the card, which a coupling is a part of [N·m/rad]."""
    one, other = _joints(context, where)
    return float(np.sqrt(one * other))


def _top(context: Context) -> float:
    """Upper end of the band [rad/s]."""
    return float(2 * np.pi * context.band[1])


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    one, other = _joints(context, where)
    inertia = one / _top(context) ** 2
    high, ratio = context.band[1], float(np.sqrt(other / one))
    return (
        signed("coupling", "", 0.3, -MOST, MOST),
        signed("first", "", 0.15, -0.03, MOST),
        signed("second", "", 0.15, -0.03, MOST),
        positive("damping_time", "s", 1e-5, 2.0, 1e-12, 0.03),
        positive("inertia", "kg·m²", 1e-3 * inertia, 3.0, 1e-9 * inertia, 30 * inertia),
        positive("frequency", "Hz", 0.6 * high, 0.5, 0.05 * high, 5 * high),
        positive("damping_ratio", "", 0.03, 1.0, 1e-4, 1.0),
        positive("ratio", "", ratio, 0.4, ratio / 20, ratio * 20),
        *relaxation(context),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    one, _ = _joints(context, where)
    found: list[Mapping[str, float]] = [{"coupling": 0.15}, {"coupling": -0.15}]
    idler = {"first": 0.15, "second": 0.15, "inertia": 4 * 0.15 * one / (0.6 * _top(context)) ** 2}
    belt = {"first": 0.15, "second": 0.15, "relaxing": RELAXING}
    return found + [{**start, **more} for more in (idler, belt) for start in found]


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} idler", f"{placement.where} relaxing"])


def _act(assembly: Assembly, placement: Placement) -> None:
    one, other = placement.where.split("+")
    rows = assembly.stretch_of(one), assembly.stretch_of(other)
    between = placement["coupling"] * _size(placement.context, placement.where)
    time = placement["damping_time"]
    assembly.add_coupling(*rows, between)
    assembly.add_damper(rows[0] + rows[1], time * between)
    for row, added in zip(rows, _diagonal(placement), strict=True):
        assembly.add_spring(row, added)
        assembly.add_loss(row, added)  # hysteretic where the joints are, as a card has it
        assembly.add_damper(row, time * (added - between))
    own, omega = assembly.row(f"{placement.where} idler"), 2 * np.pi * placement["frequency"]
    ratio = -np.copysign(placement["ratio"], between)
    assembly.add_inertia(own + (rows[0] + ratio * rows[1]) / 2, placement["inertia"])
    assembly.add_spring(own, placement["inertia"] * omega**2)
    assembly.add_damper(own, 2 * placement["damping_ratio"] * placement["inertia"] * omega)
    spring = max(abs(between), LEAST * _size(placement.context, placement.where)) / placement["ratio"]
    part, relaxes = placement["relaxing"] * spring, placement["relaxation_time"]
    end = assembly.row(f"{placement.where} relaxing")
    add_relaxing(assembly, rows[0] - ratio * rows[1], end, part, relaxes, placement.context.band[1])


def _diagonal(placement: Placement) -> tuple[float, float]:
    """What it adds to the stiffness of either joint [N·m/rad]."""
    one, other = _joints(placement.context, placement.where)
    return placement["first"] * one, placement["second"] * other


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    stiffness = values["coupling"] * _size(context, where)
    return {"stiffness": stiffness, "damping": values["damping_time"] * stiffness, **values}


def _extend(draft: Draft, placement: Placement) -> None:
    one, other = placement.where.split("+")
    draft.couple(one, other, _physical(placement.context, placement.where, placement.values)["stiffness"])
    for joint, added in zip((one, other), _diagonal(placement), strict=True):
        draft.stiffen(joint, added)
    between = abs(placement["coupling"]) * _size(placement.context, placement.where)
    lacking = []
    if placement["damping_time"] * _top(placement.context) > HELD:
        lacking.append(f"its damper, {placement['damping_time']:.3g} s times the spring")
    if placement["inertia"] * (2 * np.pi * placement["frequency"]) ** 2 > HELD * between:
        lacking.append(f"its idler, which swings at {placement['frequency']:.3g} Hz")
    if placement["relaxing"] > RELAXATION_HELD:
        lacking.append(
            f"what relaxes, {placement['relaxing']:.3g} of it within {placement['relaxation_time']:.3g} s"
        )
    if lacking:
        found = " and ".join(lacking)
        draft.notes.append(f"the files have the spring between {one} and {other} and lack {found}")


_HELD = replace(HELD_TOOL, next_level=Level.anew(TENSIONED))
EFFECT = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    places=pairs,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"stiffness": "N·m/rad", "damping": "N·m·s/rad"},
    made_by=("coupling", "damping"),
    parts=(("inertia", "frequency", "damping_ratio", "ratio"), (*RELAXATION_PART, "ratio")),
    next_level=Level.anew(replace(ROD, next_level=Level.anew(_HELD))),
)
