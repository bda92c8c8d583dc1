"""A drive that sits a link farther back: its spring is stretched by both joints that it passes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import Effect, Site, Stand, either_sign, multiplied, within
from flexmodal.rig.effects.joint_coupling import EFFECT as OWN
from flexmodal.rig.plant.assembly import PlantAssembly

MOST = 3.0
"""Of the ratio over √(k_A/k_B)."""


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """What the second joint's spring holds the first one with is 2 to 25 % of the first one's own."""
    return {"ratio": either_sign(random, 0.15, 0.5)}


def _shape(assembly: PlantAssembly, site: Site) -> None:
    """K = Tᵀ diag(k) T: the spring and damper of B are stretched by q_B − r q_A; nothing is added to them."""
    one, other = site.where.split("+")
    stiffness = site.stand.true.stiffness
    ratio = site["ratio"] * float(np.sqrt(stiffness[one] / stiffness[other]))
    assembly.elongation[other] = assembly.stretch(other) - ratio * assembly.row(one)


REMOTE: Effect = replace(
    OWN,
    form="remote",
    says="the second joint is driven from before the first: its spring feels both",
    source="Spong, Hutchinson and Vidyasagar, Robot Modeling and Control, Wiley 2006, section 7.4 (remotely "
    "driven link)",
    units={"ratio": "of the first joint into the second one's drive, over √(k₁/k₂)"},
    draw=_draw,
    scaled=multiplied("ratio"),
    most=lambda parameters: MOST / max(abs(parameters["ratio"]), 1e-9),
    check=within(ratio=(-MOST, MOST)),
    shape=_shape,
    act=None,
    active=False,
)

FORMS = (REMOTE,)
