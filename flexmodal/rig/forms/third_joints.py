"""Third forms of what sits in joints: an eccentric gear that rubs, an elastomer spider, a loaded bearing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, frame, rows, turning_joints
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION_EFFECT
from flexmodal.rig.effects.effect import Effect, Site, Stand, each, multiplied, positive, within
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.forms.behind import behind, draw_hub, hold
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import FRICTION, SINH, NonlinearElement

CUT = 3.0
"""Beyond so many of its deflections the spider goes along its tangent."""
SOFTEST = 4.0
"""Compliance of a spider over that of its joint."""


def _draw_eccentric(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A gear that rubs on average as the rig's own joint, and comes round one to three times a turn."""
    return {
        **FRICTION_EFFECT.draw(stand, where, random),
        "uneven": float(random.uniform(0.4, 0.85)),
        "times": float(random.integers(1, 4)),
        "phase": float(random.uniform(0.0, 2 * np.pi)),
    }


def _act_eccentric(assembly: PlantAssembly, site: Site) -> None:
    """F (1 + e cos(n q + φ)): tight where the teeth stand deepest, nearly free half a wave from there."""
    angle = site["times"] * assembly.posture.values[site.where] + site["phase"]
    torque = float(site["torque"] * (1 + site["uneven"] * np.cos(angle)))
    law = (torque, site["presliding_stiffness"], 0.0)
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), FRICTION, law))


def _draw_spider(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A spider that a hard blow winds up to where it stiffens several times, and a hub beyond the band."""
    softer = float(random.uniform(0.4, 1.2))
    return {
        "softer": softer,
        "deflection": float(random.uniform(0.1, 0.4)) * softer * stand.deflection[where][1],
        **draw_hub(stand, random),
    }


def _act_spider(assembly: PlantAssembly, site: Site) -> None:
    """k₂ u_r sinh(u/u_r) behind the joint's spring k: q = τ/k + u_r arsinh(τ/(k₂ u_r)) while it is slow."""
    spider, own = assembly.row(f"{site.where} spider"), site.stand.true.stiffness[site.where] / site["softer"]
    hold(assembly, site, spider, own, own)
    assembly.elements.append(NonlinearElement(spider, SINH, (own, site["deflection"], CUT)))


def _draw_load_zone(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**draw_springs(stand, where, random), "ratio": float(random.uniform(0.15, 0.5))}


def _act_load_zone(assembly: PlantAssembly, site: Site) -> None:
    """The weight presses some of the rollers: k along it, a part of k across; g is what of "down" is radial.

    K = k (ρ I + (1 − ρ) g gᵀ), so that an upright axis has all of it soft, and a level one what lies across.
    """
    x, y, z, rx, ry = rows(assembly, site)
    down = -frame(assembly, site.where)[2]
    ratio, radial, tilt = site["ratio"], site["radial_stiffness"], site["tilt_stiffness"]
    for row, spring in (
        (x, ratio * radial),
        (y, ratio * radial),
        (down[0] * x + down[1] * y, (1 - ratio) * radial),
        (z, site["axial_stiffness"]),
        (rx, ratio * tilt),
        (ry, ratio * tilt),
        (down[0] * ry - down[1] * rx, (1 - ratio) * tilt),
    ):
        assembly.add_spring(row, spring, site["damping_time"] * spring)


ECCENTRIC: Effect = replace(
    FRICTION_EFFECT,
    form="eccentric",
    says="a gear that runs out of true: it rubs more in some positions than in others",
    source="Armstrong-Hélouvry, Control of Machines with Friction, Kluwer 1991, on friction that depends on "
    "position; Dahl's law, as the rig's own",
    units={
        "torque": "N·m, the mean over a turn",
        "presliding_stiffness": "N·m/rad",
        "uneven": "how much more it is at its largest, relative",
        "times": "in a turn of the joint",
        "phase": "rad, where the joint is at 0",
    },
    places=turning_joints,
    place_is="a flexible joint that turns",
    draw=_draw_eccentric,
    scaled=multiplied("torque"),
    check=each(positive("torque", "presliding_stiffness"), within(uneven=(0.0, 0.95))),
    act=_act_eccentric,
)
SPIDER: Effect = replace(
    SPRING,
    form="spider",
    says="an elastomer coupling behind the joint's spring, which stiffens the more it is wound up",
    source="Rivin, Stiffness and Damping in Mechanical Design, Marcel Dekker 1999, on elastomeric couplings; "
    "springs one behind the other",
    units={
        "softer": "compliance of the spider, unloaded, over the joint's",
        "deflection": "rad, of the spider",
        "frequency": "Hz, of the hub between both",
        "damping_time": "damping over stiffness of the spider, s",
    },
    draw=_draw_spider,
    scaled=multiplied("softer"),
    most=lambda parameters: SOFTEST / max(parameters["softer"], 1e-9),
    check=each(
        positive("softer", "deflection", "frequency"),
        within(softer=(0.0, SOFTEST + 1e-9), damping_time=(0.0, 0.1)),
    ),
    shape=behind("spider"),
    act=_act_spider,
)
LOAD_ZONE: Effect = replace(
    BEARING,
    form="load_zone",
    says="a bearing with play that lies in its weight: softer across that, however the arm stands",
    source="Gargiulo, Machine Design 52 (1980) 107; Harris and Kotzalas, Rolling Bearing Analysis, 5th ed., "
    "CRC 2006, chapter 7 (load zones)",
    units={**BEARING.units, "ratio": "of the stiffness across the load over that along it"},
    draw=_draw_load_zone,
    check=each(BEARING.check, within(ratio=(0.01, 1.0))),
    act=_act_load_zone,
)

FORMS = (ECCENTRIC, SPIDER, LOAD_ZONE)
