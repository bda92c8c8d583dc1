"""Fifth forms of what sits in joints: a brake's disc that drags, strands that go slack, a fork that bends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, frame, rows
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION_EFFECT
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, each, multiplied, positive, within
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.forms.behind import behind, draw_hub, hold
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import heading
from flexmodal.rig.plant.plant import DRAGGED, PIECEWISE, NonlinearElement

SOFTEST = 2.0
"""Largest compliance of tight strands over that of their joint."""


def _draw_splined(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A disc that even a weak blow drags along, once the play of its splines is used up."""
    k, weak = stand.true.stiffness[where], stand.deflection[where][0]
    return {
        "torque": float(random.uniform(0.04, 0.18) * k * weak),
        "spline_stiffness": float(random.uniform(4.0, 8.0) * k),
        "play": float(random.uniform(0.01, 0.06) * weak),
    }


def _act_splined(assembly: PlantAssembly, site: Site) -> None:
    """The disc stays where it is within ±play of it, is pushed beyond, and slips at F."""
    law = (site["spline_stiffness"], site["torque"], site["play"])
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), DRAGGED, law))


def _draw_strands(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A belt tight enough for a weak blow, of which a hard one leaves one strand alone."""
    softer = float(random.uniform(0.4, 1.2))
    return {
        "softer": softer,
        "deflection": float(random.uniform(0.1, 0.4)) * softer * stand.deflection[where][1],
        **draw_hub(stand, random),
    }


def _act_strands(assembly: PlantAssembly, site: Site) -> None:
    """Behind the joint's spring two strands of k₂/2: beyond ±θ₀ one of them is slack and pulls no less."""
    tight, at = site.stand.true.stiffness[site.where] / site["softer"], site["deflection"]
    pulley = assembly.row(f"{site.where} pulley")
    hold(assembly, site, pulley, tight / 2, tight)
    assembly.elements.append(NonlinearElement(pulley, PIECEWISE, (tight / 2, 0.0, -tight / 2, at)))


def _draw_fork(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Prongs that hold the joint against a tilt as stiffly as the rig's own bearing does."""
    drawn, wide = draw_springs(stand, where, random), float(random.uniform(0.05, 0.15))
    length = float(random.uniform(0.1, 0.25))
    return {
        "bending_stiffness": drawn["tilt_stiffness"] / (2 * wide**2) * length**3 / 3,
        "length": length,
        "depth": float(random.uniform(0.3, 0.8)) * length,
        "thickness": float(random.uniform(0.2, 0.6)),
        "wide": wide,
        "uneven": float(random.uniform(0.5, 1.0)),
        "damping_time": drawn["damping_time"],
    }


def _along(assembly: PlantAssembly, site: Site) -> np.ndarray:
    """Parts along the frame's first two axes of the way in which the prongs stand out of their link."""
    parent = assembly.robot.urdf.joint_by_name[site.where].parent
    axes = frame(assembly, site.where)
    stands = axes[:, :2].T @ assembly.orientation(parent) @ heading(site.stand.robot, parent)
    size = float(np.linalg.norm(stands))
    return np.asarray(stands / size) if size > 1e-6 else np.array([1.0, 0.0])


def _act_fork(assembly: PlantAssembly, site: Site) -> None:
    """Two cantilevers, `wide` to both sides along the axis: 3 E I/l³ across, 12 E I/(h² l) lengthways.

    Along the joint's axis they are plates, thinner than deep: 3 E I t²/l³ with t the thickness over h.
    """
    x, y, z, rx, ry = rows(assembly, site)
    one, other = _along(assembly, site)
    length, depth = site["length"], site["depth"]
    for place, part in ((-site["wide"], 1.0), (site["wide"], site["uneven"])):
        rigidity = part * site["bending_stiffness"]
        first, second = x + place * ry, y - place * rx
        for row, spring in (
            (one * first + other * second, 12 * rigidity / (depth**2 * length)),
            (one * second - other * first, 3 * rigidity / length**3),
            (z, 3 * rigidity * site["thickness"] ** 2 / length**3),
        ):
            assembly.add_spring(row, spring, site["damping_time"] * spring)


SPLINED: Effect = replace(
    FRICTION_EFFECT,
    form="splined",
    says="the disc of a brake that was let go: it drags, and has play on its splines, so that small motions "
    "are free",
    source="Visintin, Differential Models of Hysteresis, Springer 1994 (play and stop); Jenkins, British "
    "J. Applied Physics 13 (1962) 30 (a spring that slips)",
    units={
        "torque": "N·m, at which the disc slips",
        "spline_stiffness": "N·m/rad",
        "play": "rad, to either side",
    },
    draw=_draw_splined,
    check=each(positive("torque", "spline_stiffness"), within(play=(0.0, np.inf))),
    act=_act_splined,
)
STRANDS: Effect = replace(
    SPRING,
    form="strands",
    says="a toothed belt behind the joint's spring, one of whose strands a hard blow leaves slack",
    source="Childs, Dalgarno, Hojjati, Tutt and Day, Proc. IMechE D 211 (1997) 205 (timing belts); Rivin, "
    "Stiffness and Damping in Mechanical Design, Marcel Dekker 1999, on preload",
    units={
        "softer": "compliance of the belt, both strands tight, over the joint's",
        "deflection": "rad, at which one goes slack",
        "frequency": "Hz, of the pulley while both are tight",
        "damping_time": "damping over stiffness of the belt, s",
    },
    draw=_draw_strands,
    scaled=multiplied("softer"),
    most=lambda parameters: SOFTEST / max(parameters["softer"], 1e-9),
    check=each(
        positive("softer", "deflection", "frequency"),
        within(softer=(0.0, SOFTEST + 1e-9), damping_time=(0.0, 0.1)),
    ),
    shape=behind("pulley"),
    act=_act_strands,
)
FORK: Effect = replace(
    BEARING,
    form="fork",
    says="a joint that runs in both prongs of a fork, which bend: softer across them, and one of them more",
    source="Rivin, Mechanical Design of Robots, McGraw-Hill 1988, on how joints are held; Young and Budynas, "
    "Roark's Formulas for Stress and Strain, 7th ed., 2002, chapter 8 (cantilevers)",
    units={
        "bending_stiffness": "N·m², of the stiffer prong", "length": "m, of the prongs",
        "depth": "m: E A is 12 E I over its square", "thickness": "over the depth",
        "wide": "m, from the joint to a prong along its axis", "uneven": "the other prong's part of both",
        "damping_time": "damping over stiffness, s",
    },
    draw=_draw_fork,
    scaled=divided("bending_stiffness"),
    check=each(BEARING.check, positive("length", "depth", "thickness", "wide", "uneven")),
    act=_act_fork,
)  # fmt: skip

FORMS = (SPLINED, STRANDS, FORK)
