"""Seventh forms of what sits in joints: a ring that rubs by its load, a gear under weight, a plain bush."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, rows, turning_joints
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION_EFFECT
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    divided,
    each,
    multiplied,
    positive,
    standing,
    within,
)
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.effects.structural_damping import maxwell
from flexmodal.rig.forms.added_mass import GRAVITY
from flexmodal.rig.forms.fifth_drives import weights
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import FRICTION, WOUND, NonlinearElement
from flexmodal.structure.arm import beyond

TILTING, RADIAL = 4.4, 2.2 * 1.73
"""What moments and radial forces count in the friction of a ring of balls, where axial forces count 1."""


def ring_load(assembly: PlantAssembly, stand: Stand, where: str, diameter: float) -> float:
    """What makes a ring of balls rub: 4.4 M/D + F_a + 3.8 F_r of the weight beyond the joint [N].

    Args:
        assembly: the plant in the making, in its posture.
        stand: with the bodies.
        where: the joint.
        diameter: of the ring [m].
    """
    joint = stand.robot.urdf.joint_by_name[where]
    axis = assembly.orientation(joint.child) @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
    force, moment = np.zeros(3), np.zeros(3)
    for link in beyond(stand.robot.urdf, joint.child):
        body = stand.true.bodies.get(link)
        if body is not None:
            weight = np.array([0.0, 0.0, -GRAVITY * body.mass])
            lever = assembly.origin(link) + assembly.orientation(link) @ body.com
            force, moment = force + weight, moment + np.cross(lever - assembly.origin(joint.child), weight)
    axial = float(abs(force @ axis))
    radial = float(np.linalg.norm(force - (force @ axis) * axis))
    tilting = float(np.linalg.norm(moment - (moment @ axis) * axis))
    return TILTING * tilting / diameter + axial + RADIAL * radial


def _draw_slewing(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A ring of 12 to 40 cm, and as the rig's own where it carries most."""
    drawn, diameter = FRICTION_EFFECT.draw(stand, where, random), float(random.uniform(0.12, 0.4))
    most = max(ring_load(one, stand, where, diameter) for one in standing(stand))
    return {
        "torque": 1.2 * drawn["torque"],
        "presliding_stiffness": drawn["presliding_stiffness"],
        "diameter": diameter,
        "load": max(most, 1.0),
        "seals": float(random.uniform(0.1, 0.4)),
    }


def _act_slewing(assembly: PlantAssembly, site: Site) -> None:
    """Dahl's law, whose torque goes with the load on the ring, seals beside it."""
    carried = ring_load(assembly, site.stand, site.where, site["diameter"]) / site["load"]
    torque = site["torque"] * (site["seals"] + (1 - site["seals"]) * carried)
    law = (torque, site["presliding_stiffness"], 0.0)
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), FRICTION, law))


def _draw_under_weight(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A hard blow comes up to a knee of the gear or over it; so does the weight, where it pulls most."""
    most = max(abs(weights(one, stand)[where]) for one in standing(stand))
    knee = float(random.uniform(0.4, 0.9)) * stand.deflection[where][1]
    return {
        "change": float(random.uniform(0.3, 0.9)),
        "deflection": knee,
        "wound": float(random.uniform(0.3, 1.0)) * knee,
        "load": max(most, 1e-3),
    }


def _act_under_weight(assembly: PlantAssembly, site: Site) -> None:
    """T(q + q₀) − T(q₀) with T the rig's own hardening and q₀ by how much the weight has wound it up."""
    pulled = weights(assembly, site.stand)[site.where] / site["load"]
    law = (
        site["change"] * site.stand.true.stiffness[site.where],
        site["deflection"],
        -pulled * site["wound"],
    )
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), WOUND, law))


def _draw_bush(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A bush of 4 to 12 cm between two washers; against tilts as stiff as the rig's own."""
    tilt, long = draw_springs(stand, where, random)["tilt_stiffness"], float(random.uniform(0.04, 0.12))
    washer, part = float(random.uniform(0.3, 0.7)) * long, float(random.uniform(0.3, 0.8))
    return {
        "radial_stiffness": 12 * part * tilt / long**2,
        "axial_stiffness": 2 * (1 - part) * tilt / washer**2,
        "long": long,
        "washer": washer,
        "aside": float(random.uniform(-0.5, 0.5)) * long,
        "loss_factor": float(random.uniform(0.04, 0.15)),
    }


def _act_bush(assembly: PlantAssembly, site: Site) -> None:
    """An even bed along the bush, k l²/12 against tilts, and washers, k ρ²/2; all with one loss factor."""
    first, second, along, tilt, other = rows(assembly, site)
    radial, axial, aside = site["radial_stiffness"], site["axial_stiffness"], site["aside"]
    tilting = radial * site["long"] ** 2 / 12 + axial * site["washer"] ** 2 / 2
    static, strengths, times = maxwell(site["loss_factor"], site.stand.plan.band)
    for row, spring in (
        (first + aside * other, radial),
        (second - aside * tilt, radial),
        (along, axial),
        (tilt, tilting),
        (other, tilting),
    ):
        if np.any(row):
            assembly.add_spring(row, static * spring)
            assembly.add_relaxation(row, strengths * spring, times)


SLEWING: Effect = replace(
    FRICTION_EFFECT,
    form="slewing",
    says="a ring of balls that carries the arm and rubs by its load: by the weight along and across its axis "
    "and by the moment that wants to tip it, so that it rubs otherwise in each posture",
    source="Rothe Erde, Slewing Bearings (catalogue), on their friction torque; Harris and Kotzalas, Rolling "
    "Bearing Analysis, 5th ed., CRC 2006, chapter 10; Dahl's law, as the rig's own",
    units={
        **FRICTION_EFFECT.units,
        "diameter": "m, of the ring", "load": "N, at which the torque is this",
        "seals": "part of the torque that does not go with the load",
    },
    places=turning_joints,
    place_is="a flexible joint that turns",
    draw=_draw_slewing,
    check=each(FRICTION_EFFECT.check, positive("diameter", "load"), within(seals=(0.01, 1.0))),
    act=_act_slewing,
)  # fmt: skip
UNDER_WEIGHT: Effect = replace(
    SPRING,
    form="under_weight",
    says="a gear that stiffens as it is wound up, and that the arm's weight has wound up already: farther in "
    "one posture than in the other, so that it is stiffer there, and one way more than the other",
    source="Tuttle and Seering, IEEE Trans. Robotics and Automation 12 (1996) 368 (stiffness by torque); "
    "Kovacic and Brennan, The Duffing Equation, Wiley 2011, chapter 8 (static loads)",
    units={
        **SPRING.units,
        "wound": "rad, by the weight where it pulls most", "load": "N·m, with which it pulls there",
    },
    draw=_draw_under_weight,
    scaled=multiplied("change"),
    most=lambda parameters: 4.0 / max(parameters["change"], 1e-9),
    check=each(within(change=(0.0, 10.0), wound=(0.0, np.inf)), positive("deflection", "load")),
    act=_act_under_weight,
)  # fmt: skip
BUSH: Effect = replace(
    BEARING,
    form="bush",
    says="a plain bush of polymer between two thrust washers, with loss of its own; it may lie to one side "
    "of the joint",
    source="Shigley and Mischke, Mechanical Engineering Design, 5th ed., McGraw-Hill 1989, chapter 12 (plain "
    "bearings); Rivin, Mechanical Design of Robots, McGraw-Hill 1988; an even bed, integrated",
    units={
        "radial_stiffness": "N/m", "axial_stiffness": "N/m, of the washers", "long": "m, the bush",
        "washer": "m, radius of the washers", "aside": "m, from the joint to the middle of the bush",
        "loss_factor": "of polymer",
    },
    draw=_draw_bush,
    scaled=divided("radial_stiffness", "axial_stiffness"),
    check=each(
        positive("radial_stiffness", "axial_stiffness", "long", "washer"), within(loss_factor=(0.0, 0.6))
    ),
    act=_act_bush,
)  # fmt: skip

FORMS = (SLEWING, UNDER_WEIGHT, BUSH)
