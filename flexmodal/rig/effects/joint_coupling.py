"""A parallel mechanism ties two joints: an off-diagonal stiffness.

What lies on the diagonal counts as the joints' own. So it holds beside their springs, and may push where one
of these has given way to something much softer, such as a servo loop: the arm then falls over.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from flexmodal.model import Robot
from flexmodal.rig.effects.effect import Effect, Site, Stand, multiplied, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints


def _places(robot: Robot) -> tuple[str, ...]:
    return tuple(f"{one}+{other}" for one, other in combinations(commanded_joints(robot), 2))


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    sign = 1.0 if random.uniform() < 0.5 else -1.0
    return {"coupling": float(sign * random.uniform(0.15, 0.45))}


def _act(assembly: PlantAssembly, site: Site) -> None:
    one, other = site.where.split("+")
    size = np.sqrt(site.stand.true.stiffness[one] * site.stand.true.stiffness[other])
    assembly.add_coupling(one, other, float(site["coupling"] * size))


EFFECT = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    units={"coupling": "off-diagonal stiffness over √(k₁ k₂)"},
    places=lambda robot, points: _places(robot),
    place_is="a pair of flexible joints, jointA+jointB",
    draw=_draw,
    scaled=multiplied("coupling"),
    most=lambda parameters: 0.9 / max(abs(parameters["coupling"]), 1e-9),
    check=within(coupling=(-0.9, 0.9)),
    act=_act,
    active=True,
)
