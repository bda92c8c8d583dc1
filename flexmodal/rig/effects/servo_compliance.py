"""The motor is not locked: its rotor moves against the stiffness and damping of the position loop.

J_M q̈_M = k (q − q_M) + b (q̇ − q̇_M) − K_P q_M − K_D q̇_M, [Hearne 2.1, 2.2] with a proportional and
derivative loop; the card's spring and damper then sit between rotor and link. The rotor's inertia is
reflected to the joint and turns about the joint's own axis only (Spong, ASME J. Dyn. Sys. 109, 1987).
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A loop twice to six times as stiff as the joint, a rotor that swings on both well inside the band."""
    k = stand.true.stiffness[where]
    low, high = stand.plan.band
    loop = float(random.uniform(2.0, 6.0) * k)
    omega = 2 * np.pi * float(np.exp(random.uniform(np.log(max(4 * low, 0.05 * high)), np.log(0.4 * high))))
    inertia = (loop + k) / omega**2
    return {
        "proportional_gain": loop,
        "derivative_gain": float(2 * random.uniform(0.2, 0.6) * np.sqrt(loop * inertia)),
        "rotor_inertia": inertia,
    }


def free_rotor(assembly: PlantAssembly, site: Site, inertia: float) -> Float[np.ndarray, " dof"]:
    """Free the rotor: the joint's spring goes to it instead of to a locked motor. Its row.

    Args:
        assembly: the plant in the making.
        site: whose joint.
        inertia: of the rotor, at the joint [kg·m², kg].
    """
    joint = site.where
    k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
    assembly.add_coordinates([f"{joint} motor"])
    motor, link = assembly.row(f"{joint} motor"), assembly.stretch(joint)
    assembly.add_spring(link, -k, -b)
    assembly.add_spring(link - motor, k, b)
    assembly.add_inertia(motor, inertia)
    assembly.elongation[joint] = link - motor  # what other effects of this joint act on
    return motor


def _act(assembly: PlantAssembly, site: Site) -> None:
    motor = free_rotor(assembly, site, site["rotor_inertia"])
    assembly.add_spring(motor, site["proportional_gain"], site["derivative_gain"])


def _scaled(parameters: Parameters, s: float) -> dict[str, float]:
    gains = {"proportional_gain": 1 / s, "derivative_gain": 1 / np.sqrt(s), "rotor_inertia": 1.0}
    return {name: float(value * gains[name]) for name, value in parameters.items()}


EFFECT = Effect(
    name="servo_compliance",
    says="the motor side moves against its control loop",
    units={"proportional_gain": "N·m/rad", "derivative_gain": "N·m·s/rad", "rotor_inertia": "kg·m²"},
    places=lambda robot, points: commanded_joints(robot),
    place_is="a flexible joint",
    draw=_draw,
    scaled=_scaled,
    check=positive("proportional_gain", "derivative_gain", "rotor_inertia"),
    act=_act,
)
