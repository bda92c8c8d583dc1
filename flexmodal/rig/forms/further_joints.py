"""Further forms of what sits in joints: a cylinder's seal, a band that goes slack, an overhung shaft."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, rows, turning_joints
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    divided,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import BACKLASH, SLIDER, NonlinearElement

NEVER = 1e6
"""Gap of a band over its slack: it is never pulled the other way."""
MOST_OF_BAND = 0.85
"""Of a joint's stiffness."""


def lever(crank: float, distance: float, angle: float) -> float:
    """Of a cylinder about a joint: how much longer it gets for each radian [m].

    Args:
        crank: from the joint to where the cylinder drives [m].
        distance: from the joint to where it hangs [m].
        angle: between these two [rad].
    """
    length = np.sqrt(crank**2 + distance**2 - 2 * crank * distance * np.cos(angle))
    return float(crank * distance * np.sin(angle) / length)


def _draw_cylinder(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A cylinder that stands well at the middle of the postures, where it rubs as the rig's own joint."""
    drawn, k = FRICTION.draw(stand, where, random), stand.true.stiffness[where]
    crank, distance = float(random.uniform(0.1, 0.2)), float(random.uniform(0.3, 0.6))
    asked = [dict(posture.q).get(where, 0.0) for posture in stand.plan.postures]
    between = either_sign(random, np.pi / 3, 2 * np.pi / 3)
    arm = abs(lever(crank, distance, between))
    return {
        "force": drawn["torque"] / arm,
        "presliding_stiffness": float(random.uniform(3.0, 8.0)) * k / arm**2,
        "crank": crank,
        "distance": distance,
        "angle": between - float(np.mean(asked)),
    }


def _act_cylinder(assembly: PlantAssembly, site: Site) -> None:
    """The seal sticks, then slides at a force; its lever turns with the joint, and is none at dead centre."""
    angle = site["angle"] + assembly.posture.values[site.where]
    row = lever(site["crank"], site["distance"], angle) * assembly.row(site.where)
    law = (site["presliding_stiffness"], site["force"])
    assembly.elements.append(NonlinearElement(row, SLIDER, law))


def _draw_slack(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A band that a hard blow takes the tension off and a weak one does not, or hardly."""
    return {
        "change": float(random.uniform(0.25, 0.6)),
        "deflection": either_sign(random, 0.1, 0.4) * stand.deflection[where][1],
    }


def _act_slack(assembly: PlantAssembly, site: Site) -> None:
    """A part of the spring is a band: past its tension, one way, it does not push."""
    slack, part = site["deflection"], site["change"] * site.stand.true.stiffness[site.where]
    row = float(np.sign(slack)) * assembly.stretch(site.where)
    law = (part, NEVER * abs(slack), part * abs(slack))
    assembly.elements.append(NonlinearElement(row, BACKLASH, law))


def _draw_overhung(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A shaft whose end tilts under a moment as the rig's own bearing does."""
    drawn = draw_springs(stand, where, random)
    span, overhang = float(random.uniform(0.06, 0.2)), float(random.uniform(0.05, 0.15))
    return {
        "bending_stiffness": drawn["tilt_stiffness"] * (span + 3 * overhang) / 3,
        "span": span,
        "overhang": overhang,
        "axial_stiffness": drawn["axial_stiffness"],
        "damping_time": drawn["damping_time"],
    }


def _act_overhung(assembly: PlantAssembly, site: Site) -> None:
    """The end of a shaft that stands out over two supports; the inverse of what a force and a moment bend it.

    E I w = a² (l + a)/3 P + a (2 l + 3 a)/6 M and E I φ = a (2 l + 3 a)/6 P + (l + 3 a)/3 M. A chain in a
    plane puts no moment on it.
    """
    x, y, z, rx, ry = rows(assembly, site)
    span, over, rigidity = site["span"], site["overhang"], site["bending_stiffness"]
    bent, mixed = over**2 * (span + over) / 3, over * (2 * span + 3 * over) / 6
    tilted = (span + 3 * over) / 3
    held = [(z, site["axial_stiffness"])]
    for shift, slope in ((x, ry), (y, -rx)):
        held.append((shift, rigidity / bent))
        if assembly.normal is None:
            held.append((slope - mixed / bent * shift, rigidity / (tilted - mixed**2 / bent)))
    for row, spring in held:
        assembly.add_spring(row, spring, site["damping_time"] * spring)


CYLINDER: Effect = replace(
    FRICTION,
    form="cylinder",
    says="a balancing cylinder whose seal rubs: its lever turns with the joint",
    source="Arakelian and Briot, Balancing of Linkages and Robot Manipulators, Springer 2015 (cylinders); "
    "Iwan, as iwan, a spring that slips",
    units={
        "force": "N, of the seal",
        "presliding_stiffness": "N/m",
        "crank": "m, from the joint to the rod",
        "distance": "m, from the joint to the other end",
        "angle": "rad, between these two where the joint is at 0",
    },
    places=turning_joints,
    place_is="a flexible joint that turns",
    draw=_draw_cylinder,
    scaled=multiplied("force"),
    check=positive("force", "presliding_stiffness", "crank", "distance"),
    act=_act_cylinder,
)
SLACK: Effect = replace(
    SPRING,
    form="slack",
    says="a band beside the spring, which goes slack one way",
    source="Chati, Rand and Mukherjee, J. Sound and Vibration 207 (1997) 249 (bilinear); Tsai, Robot "
    "Analysis, Wiley 1999, chapter 7 (bands and tendons that only pull)",
    units={"change": "part of the stiffness that is the band's", "deflection": "rad, at which it goes slack"},
    draw=_draw_slack,
    most=lambda parameters: MOST_OF_BAND / max(parameters["change"], 1e-9),
    check=within(change=(0.0, MOST_OF_BAND)),
    act=_act_slack,
)
OVERHUNG: Effect = replace(
    BEARING,
    form="overhung",
    says="a joint at the end of a shaft that stands out over its two bearings and bends",
    source="Young and Budynas, Roark's Formulas for Stress and Strain, 7th ed., 2002, chapter 8 (overhangs)",
    units={
        "bending_stiffness": "N·m², of the shaft", "span": "m, between the bearings", "overhang": "m",
        "axial_stiffness": "N/m", "damping_time": "damping over stiffness, s",
    },
    draw=_draw_overhung,
    scaled=divided("bending_stiffness", "axial_stiffness"),
    check=each(BEARING.check, positive("bending_stiffness", "span", "overhang")),
    act=_act_overhung,
)  # fmt: skip

FORMS = (CYLINDER, SLACK, OVERHUNG)
