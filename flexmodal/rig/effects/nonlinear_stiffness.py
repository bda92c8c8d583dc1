"""A spring that hardens or softens: cubic while small, levelling off beyond.

Torque k q (1 + a u²/(1 + u²)) with u = q/q_r: for small q the cubic k q + (a k/q_r²) q³, for large q a
stiffness (1 + a) k, as harmonic drives have it; so that a softening joint never turns unstable.
"""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.effect import Effect, Site, Stand, each, multiplied, positive, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints
from flexmodal.rig.plant.plant import HARDENING, NonlinearElement


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    sign = 1.0 if random.uniform() < 0.5 else -1.0
    return {
        "change": float(sign * random.uniform(0.2, 0.5)),
        "deflection": float(random.uniform(0.3, 0.6) * stand.deflection[where][1]),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    law = (site["change"] * site.stand.true.stiffness[site.where], site["deflection"], 0.0)
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), HARDENING, law))


EFFECT = Effect(
    name="nonlinear_stiffness",
    says="a hardening (+) or softening (−) joint spring",
    units={
        "change": "of the stiffness at large deflection, relative",
        "deflection": "rad, where half is reached",
    },
    places=lambda robot, points: commanded_joints(robot),
    place_is="a flexible joint",
    draw=_draw,
    scaled=multiplied("change"),
    most=lambda parameters: (
        (4.0 if parameters["change"] > 0 else 0.85) / max(abs(parameters["change"]), 1e-9)
    ),
    check=each(within(change=(-0.85, 10.0)), positive("deflection")),
    act=_act,
    linear=False,
)
