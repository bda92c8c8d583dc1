"""A parallel mechanism ties two joints: a block of stiffness, off the diagonal and on it.

A spring between q₁ and r q₂ adds k to the first joint, r² k to the second and −r k between them; what of that
lies on the diagonal may be more than the trust in the joints' own stiffness allows for.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure.assembly import Assembly


def _size(context: Context, where: str) -> float:
    """√(k₁ k₂) of the card, which a coupling is a part of [N·m/rad]."""
    one, other = (context.robot.joints[name].stiffness for name in where.split("+"))
    return float(np.sqrt(one * other))


def _act(assembly: Assembly, placement: Placement) -> None:
    one, other = placement.where.split("+")
    rows = assembly.stretch_of(one), assembly.stretch_of(other)
    assembly.add_coupling(*rows, placement["coupling"] * _size(placement.context, placement.where))
    for row, added in zip(rows, _diagonal(placement), strict=True):
        assembly.add_spring(row, added)
        assembly.add_loss(row, added)  # hysteretic where the joints are, as a card has it


def _diagonal(placement: Placement) -> tuple[float, float]:
    """What it adds to the stiffness of either joint [N·m/rad]."""
    one, other = (placement.context.robot.joints[name].stiffness for name in placement.where.split("+"))
    return placement["first"] * float(one), placement["second"] * float(other)


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    kept = {name: values[name] for name in ("coupling", "first", "second")}
    return {"stiffness": values["coupling"] * _size(context, where), **kept}


def _extend(draft: Draft, placement: Placement) -> None:
    one, other = placement.where.split("+")
    draft.couple(one, other, _physical(placement.context, placement.where, placement.values)["stiffness"])
    for joint, added in zip((one, other), _diagonal(placement), strict=True):
        draft.stiffen(joint, added)


EFFECT = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    looks_like="no new resonance, but frequencies and shapes that no separate joints give",
    places=lambda context: tuple(f"{a}+{b}" for a, b in combinations(context.joints, 2)),
    parameters=lambda context, where: (
        signed("coupling", "", 0.3, -0.97, 0.97),
        signed("first", "", 0.15, -0.03, 3.0),
        signed("second", "", 0.15, -0.03, 3.0),
    ),
    starts=lambda context, where: [{"coupling": 0.15}, {"coupling": -0.15}],
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"stiffness": "N·m/rad"},
)
