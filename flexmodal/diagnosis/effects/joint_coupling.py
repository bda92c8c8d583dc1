"""A parallel mechanism ties two joints: an off-diagonal stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.effect import Effect, Scene, Site, signed
from flexmodal.structure.assembly import Assembly


def _size(scene: Scene, where: str) -> float:
    """√(k₁ k₂) of the card, which a coupling is a part of [N·m/rad]."""
    one, other = (scene.robot.joints[name].stiffness for name in where.split("+"))
    return float(np.sqrt(one * other))


def _act(assembly: Assembly, site: Site) -> None:
    one, other = site.where.split("+")
    rows = assembly.stretch_of(one), assembly.stretch_of(other)
    assembly.add_coupling(*rows, site["coupling"] * _size(site.scene, site.where))


def _physical(scene: Scene, where: str, values: Mapping[str, float]) -> dict[str, float]:
    return {"stiffness": values["coupling"] * _size(scene, where), "coupling": values["coupling"]}


def _extend(draft: Draft, site: Site) -> None:
    one, other = site.where.split("+")
    draft.couple(one, other, _physical(site.scene, site.where, site.values)["stiffness"])


EFFECT = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    looks_like="no new resonance, but frequencies and shapes that no separate joints give",
    places=lambda scene: tuple(f"{a}+{b}" for a, b in combinations(scene.joints, 2)),
    parameters=lambda scene, where: (signed("coupling", "", 0.3, -0.97, 0.97),),
    starts=lambda scene, where: [{"coupling": 0.15}, {"coupling": -0.15}],
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"stiffness": "N·m/rad"},
)
