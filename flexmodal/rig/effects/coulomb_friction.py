"""Dry friction in a joint: stick and slip, integrated in time (Dahl's model)."""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.effect import Effect, Site, Stand, multiplied, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints
from flexmodal.rig.plant.plant import FRICTION, NonlinearElement


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Slips at 3 to 15 % of the spring's peak torque under the weakest blow."""
    k = stand.true.stiffness[where]
    return {
        "torque": float(random.uniform(0.03, 0.15) * k * stand.deflection[where][0]),
        "presliding_stiffness": float(random.uniform(4.0, 8.0) * k),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    law = (site["torque"], site["presliding_stiffness"], 0.0)
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), FRICTION, law))


EFFECT = Effect(
    name="coulomb_friction",
    says="dry friction in a joint",
    units={"torque": "N·m", "presliding_stiffness": "N·m/rad"},
    places=lambda robot, points: commanded_joints(robot),
    place_is="a flexible joint",
    draw=_draw,
    scaled=multiplied("torque"),
    most=lambda parameters: 10.0,
    check=positive("torque", "presliding_stiffness"),
    act=_act,
    linear=False,
)
