"""Sixth forms of what sits in joints: nested shafts that rub, a worm on springs, a bearing under load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, frame, rows, turning_joints
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION_EFFECT
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    each,
    either_sign,
    multiplied,
    positive,
    standing,
    within,
)
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.forms.added_mass import GRAVITY
from flexmodal.rig.forms.behind import behind, draw_hub, hold
from flexmodal.rig.forms.fifth_drives import weights
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import BACKLASH, FRICTION, NonlinearElement
from flexmodal.structure.arm import beyond

NEVER = 1e6
"""Gap of a worm over what it lifts off at: it meets nothing on the other side."""
SOFTEST = 2.5
"""Largest compliance of a worm that sits on its shoulder, over that of its joint."""


def neighbour(robot: Robot, joint: str) -> str | None:
    """The turning joint after one, or before where it is the last; None where it is alone.

    Args:
        robot: whose joints.
        joint: which.
    """
    order = turning_joints(robot, ())
    at = order.index(joint)
    others = order[at + 1 : at + 2] or order[max(at - 1, 0) : at]
    return others[0] if others else None


def _nested(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    turning = turning_joints(robot, points)
    return turning if len(turning) > 1 else ()


def _draw_nested(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """As the rig's own; the other joint turns its shaft by a part of what balances both springs."""
    drawn, other = FRICTION_EFFECT.draw(stand, where, random), neighbour(stand.robot, where)
    k = stand.true.stiffness
    even = float(np.sqrt(k[other] / k[where])) if other is not None else 0.0
    return {**drawn, "torque": 1.5 * drawn["torque"], "ratio": either_sign(random, 0.3, 0.8) * even}


def _act_nested(assembly: PlantAssembly, site: Site) -> None:
    """Dahl's law on q − r q': what one shaft turns against the other."""
    row, other = assembly.stretch(site.where), neighbour(site.stand.robot, site.where)
    if other is not None:
        row = row - site["ratio"] * assembly.row(other)
    law = (site["torque"], site["presliding_stiffness"], 0.0)
    assembly.elements.append(NonlinearElement(row, FRICTION, law))


def _draw_worm(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A pack pressed so that a weak blow leaves the worm on its shoulder, or nearly so; lifted either way."""
    hard = stand.true.stiffness[where] * stand.deflection[where][1]
    return {
        "softer": float(random.uniform(0.9, 1.5)),
        "torque": either_sign(random, 0.1, 0.4) * hard,
        "pack": float(random.uniform(0.15, 0.35)),
        **draw_hub(stand, random),
    }


def _act_worm(assembly: PlantAssembly, site: Site) -> None:
    """Behind the joint's spring k₂; where a torque one way lifts the worm off, the pack alone: p k₂."""
    seated = site.stand.true.stiffness[site.where] / site["softer"]
    lifts, shoulder = abs(site["torque"]) / seated, (1 - site["pack"]) * seated
    worm = assembly.row(f"{site.where} worm")
    hold(assembly, site, worm, seated, seated)
    row = -float(np.sign(site["torque"])) * worm
    assembly.elements.append(NonlinearElement(row, BACKLASH, (shoulder, NEVER * lifts, shoulder * lifts)))


def load_on(assembly: PlantAssembly, stand: Stand, where: str, radius: float, mesh: float) -> float:
    """What a bearing carries: the weight beyond it, and the tooth that holds that up [N].

    Args:
        assembly: the plant in the making, in its posture.
        stand: with the bodies.
        where: the joint.
        radius: from the joint to the tooth [m].
        mesh: angle at which the tooth stands, in the frame of the joint [rad].
    """
    links = beyond(stand.robot.urdf, stand.robot.urdf.joint_by_name[where].child)
    mass = sum(stand.true.bodies[link].mass for link in links if link in stand.true.bodies)
    tooth = frame(assembly, where) @ np.array([-np.sin(mesh), np.cos(mesh), 0.0])
    pushed = weights(assembly, stand)[where] / radius * tooth
    return float(np.linalg.norm(pushed - GRAVITY * mass * np.array([0.0, 0.0, 1.0])))


def _draw_by_load(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """As stiff as the rig's own where it carries most; a wheel of 6 to 15 cm."""
    drawn = draw_springs(stand, where, random)
    radius, mesh = float(random.uniform(0.06, 0.15)), float(random.uniform(0.0, 2 * np.pi))
    most = max(load_on(one, stand, where, radius, mesh) for one in standing(stand))
    part = float(random.uniform(0.03, 0.15))
    return {**drawn, "radius": radius, "mesh": mesh, "load": max(most, 1.0), "preload": part}


def _act_by_load(assembly: PlantAssembly, site: Site) -> None:
    """Hertz's balls: stiffnesses go with the cube root of the load, a preload beside it."""
    carried = load_on(assembly, site.stand, site.where, site["radius"], site["mesh"]) / site["load"]
    part = float(((carried + site["preload"]) / (1 + site["preload"])) ** (1 / 3))
    springs = [site["radial_stiffness"]] * 2 + [site["axial_stiffness"]] + [site["tilt_stiffness"]] * 2
    for row, spring in zip(rows(assembly, site), springs, strict=True):
        assembly.add_spring(row, part * spring, part * spring * site["damping_time"])


NESTED: Effect = replace(
    FRICTION_EFFECT,
    form="nested",
    says="shafts of two joints that run one inside the other, whose seals rub: what counts is how one turns "
    "against the other",
    source="Tsai, Robot Analysis, Wiley 1999, chapter 7 (wrists with shafts one in the other); Dahl's law, "
    "as the rig's own",
    units={**FRICTION_EFFECT.units, "ratio": "of the other joint's shaft over its joint"},
    places=_nested,
    place_is="a flexible joint that turns, beside another",
    draw=_draw_nested,
    check=each(FRICTION_EFFECT.check, within(ratio=(-100.0, 100.0))),
    act=_act_nested,
)
WORM: Effect = replace(
    SPRING,
    form="worm",
    says="a worm behind the joint's spring, which disc springs press against a shoulder: one way a hard blow "
    "lifts it off, and then the disc springs alone hold",
    source="Almen and László, Trans. ASME 58 (1936) 305 (disc springs); Rivin, Stiffness and Damping in "
    "Mechanical Design, Marcel Dekker 1999, on preload",
    units={
        "softer": "compliance of the worm on its shoulder over the joint's",
        "torque": "N·m, at which it lifts off; the sign says which way",
        "pack": "stiffness of the disc springs over that on the shoulder",
        "frequency": "Hz, of the worm's wheel while it sits",
        "damping_time": "damping over stiffness, s",
    },
    draw=_draw_worm,
    scaled=multiplied("softer"),
    most=lambda parameters: SOFTEST / max(parameters["softer"], 1e-9),
    check=each(
        positive("softer", "frequency"),
        within(softer=(0.0, SOFTEST + 1e-9), pack=(0.02, 1.0), damping_time=(0.0, 0.1)),
    ),
    shape=behind("worm"),
    act=_act_worm,
)
BY_LOAD: Effect = replace(
    BEARING,
    form="by_load",
    says="a ball bearing with little preload, the stiffer the more it carries: the weight beyond it, and the "
    "tooth beside it that holds that up",
    source="Gargiulo, Machine Design 52 (1980) 107 (stiffness by the cube root of the load); Harris and "
    "Kotzalas, Rolling Bearing Analysis, 5th ed., CRC 2006, chapter 7",
    units={
        **BEARING.units,
        "radius": "m, from the joint to the tooth", "mesh": "rad, where the tooth stands",
        "load": "N, at which the stiffnesses are these", "preload": "over that",
    },
    draw=_draw_by_load,
    check=each(BEARING.check, positive("radius", "load"), within(preload=(1e-3, 1e3))),
    act=_act_by_load,
)  # fmt: skip

FORMS = (NESTED, WORM, BY_LOAD)
