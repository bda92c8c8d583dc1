"""Further forms of what bends, carries and hangs: a layered link, a table, a hanging load, a body on feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.rig.effects.base_flexibility import EFFECT as BASE
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    damping_time,
    divided,
    drawing,
    each,
    positive,
    within,
)
from flexmodal.rig.effects.link_flexibility import EFFECT as LINK
from flexmodal.rig.effects.link_flexibility import plane_in, span
from flexmodal.rig.effects.local_absorber import EFFECT as ABSORBER
from flexmodal.rig.forms.added_mass import GRAVITY
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam
from flexmodal.rig.plant.geometry import across, cuboid
from flexmodal.rig.plant.plant import Branch
from flexmodal.structure.arm import carried


def _draw_layered(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A core that relaxes somewhere in the lower half of the band."""
    drawn, (low, high) = drawing(LINK.draw, relaxing=(0.4, 1.5))(stand, where, random), stand.plan.band
    corner = 2 * np.pi * float(np.exp(random.uniform(np.log(3 * low), np.log(0.5 * high))))
    return {**drawn, "time": 1 / corner}


def _act_layered(assembly: PlantAssembly, site: Site) -> None:
    """E I (1 + g iωτ/(1 + iωτ)): bent quickly, the core holds the faces together; slowly, they slide."""
    length, axis = span(site.where, site.stand)
    values, vectors = np.linalg.eigh(Beam(length, site["bending_stiffness"], 1.0).condensed_stiffness)
    for plane in range(len(across(axis, plane_in(assembly, site.where)))):
        names = [f"{site.where} bending {plane + 1}.{k + 1}" for k in range(len(values))]
        for value, row in zip(values, vectors.T @ [assembly.row(name) for name in names], strict=True):
            assembly.branches.append(Branch(row, site["relaxing"] * float(value), site["time"]))


def _draw_table(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Legs that let the robot sway as the rig's own base does; a top of 10 to 50 % of the robot's mass."""
    drawn, height = BASE.draw(stand, where, random), float(random.uniform(0.5, 0.9))
    return {
        "bending_stiffness": drawn["translation_stiffness"] * height**3 / 12,
        "height": height,
        "half_width": float(random.uniform(0.2, 0.45)),
        "half_depth": float(random.uniform(0.2, 0.45)),
        "gyration": float(random.uniform(0.03, 0.08)) * height,
        "table_mass": float(random.uniform(0.1, 0.5)) * stand.mass,
        "damping_time": damping_time(random),
    }


def _act_table(assembly: PlantAssembly, site: Site) -> None:
    """Each leg is welded to the top, its foot turns: 3 E I/h³ (u − h φ)² each way, and E A/h upright."""
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    beside, height = np.cross(up, level), site["height"]
    sway, upright = 3 / height**3, 1 / site["gyration"] ** 2 / height
    for one, other in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        place = one * site["half_width"] * level + other * site["half_depth"] * beside
        top = carried(motion, place) @ own
        held = [(up @ top[:3], upright)]
        for way in (level, beside)[: 1 if assembly.normal is not None else 2]:
            held.append((way @ top[:3] - height * np.cross(up, way) @ top[3:], sway))
        for row, part in held:
            spring = part * site["bending_stiffness"]
            assembly.add_spring(row, spring, site["damping_time"] * spring)
    root = assembly.robot.urdf.root
    axes = assembly.orientation(root).T @ np.column_stack([level, beside, up])
    sizes = np.array([2 * site["half_width"], 2 * site["half_depth"], 0.0])
    inertia = axes @ cuboid(site["table_mass"], sizes) @ axes.T
    assembly.add_body(root, np.zeros(3), site["table_mass"], inertia)


def _draw_hanging(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = ADDED_MASS.draw(stand, where, random)
    del drawn["gyration"]
    return drawing(lambda *_: drawn, length=(0.15, 0.8), damping_ratio=(0.01, 0.05))(stand, where, random)


def _act_hanging(assembly: PlantAssembly, site: Site) -> None:
    """A load on a rope goes up and down with its link; sideways it swings at √(g/l) and stays behind."""
    moved = assembly.motion(site.where, site.vector("x", "y", "z"))[:3]
    assembly.add_inertia(moved[2], site["mass"])
    frequency = float(np.sqrt(GRAVITY / site["length"])) / (2 * np.pi)
    names = ["hanging x", "hanging y"]
    assembly.add_on_springs(names, moved[:2], site["mass"], frequency, site["damping_ratio"])


def _act_rocking(assembly: PlantAssembly, site: Site) -> None:
    """A body above its feet, which are at ±w: they give up and down, and in shear; so it bounces and rocks.

    Its centre moves by a along `d`, and by b + h θ across; the feet are pressed by a ∓ w θ and sheared by b.
    """
    up, side = ways(assembly, site)
    bounce, shift, rock = coordinates(assembly, 3)
    mass, height, axis = site["mass"], site["height"], np.cross(up, side)
    feet, above = site.vector("x", "y", "z"), height * (assembly.orientation(site.where).T @ up)
    moved = assembly.motion(site.where, feet + above)
    own = np.outer(up, bounce) + np.outer(side, shift + height * rock)
    for k in range(3):
        assembly.add_inertia(moved[k] + own[k], mass)
        assembly.add_inertia(moved[3 + k] + axis[k] * rock, mass * site["gyration"] ** 2)
    omega = 2 * np.pi * site["frequency"]
    half = site["half_width"] * rock
    for row, part in ((bounce - half, 0.5), (bounce + half, 0.5), (shift, site["shear"])):
        spring = part * mass * omega**2
        assembly.add_spring(row, spring, 2 * site["damping_ratio"] / omega * spring)


LAYERED: Effect = replace(
    LINK,
    form="layered",
    says="two faces on a core that relaxes: a link that is stiffer when it is bent quickly",
    source="Mead and Markus, J. Sound and Vibration 10 (1969) 163 (sandwich beams); the core as Zener",
    units={
        "bending_stiffness": "N·m², when bent slowly", "damping_ratio": "of the first clamped mode, besides",
        "relaxing": "stiffness that relaxes, relative", "time": "s",
    },
    draw=_draw_layered,
    check=each(positive("bending_stiffness", "relaxing", "time"), within(damping_ratio=(0.0, 1.0))),
    act=_act_layered,
)  # fmt: skip
TABLE: Effect = replace(
    BASE,
    form="table",
    says="the robot stands on a table whose four legs stand on feet that turn",
    source="Chopra, Dynamics of Structures, 4th ed., Prentice-Hall 2012, chapter 1 (frames on columns)",
    units={
        "bending_stiffness": "N·m², of a leg", "height": "m", "half_width": "m", "half_depth": "m",
        "gyration": "m, radius of the section of a leg", "table_mass": "kg", "damping_time": "s",
    },
    draw=_draw_table,
    scaled=divided("bending_stiffness"),
    check=each(
        positive("bending_stiffness", "height", "half_width", "half_depth", "gyration"),
        within(table_mass=(0.0, np.inf)),
    ),
    act=_act_table,
)  # fmt: skip
HANGING: Effect = replace(
    ADDED_MASS,
    form="hanging",
    says="a load that hangs on a rope: only up and down it has to move along",
    source="Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., 2002, chapter 6 (small oscillations)",
    units={"mass": "kg", "x": "m", "y": "m", "z": "m", "length": "m, of the rope", "damping_ratio": ""},
    draw=_draw_hanging,
    check=positive("mass", "length"),
    act=_act_hanging,
)
ROCKING: Effect = replace(
    ABSORBER,
    form="rocking",
    says="a body on two resilient feet, which bounces and rocks",
    source="Himelblau and Rubin, in Harris' Shock and Vibration Handbook, McGraw-Hill, chapter 3 (a rigid "
    "body on resilient supports)",
    units={
        **ABSORBER.units,
        "height": "m, of its centre over the feet",
        "half_width": "m, between the feet",
        "gyration": "m, radius",
        "shear": "stiffness of the feet in shear over upright",
    },
    draw=drawing(
        ABSORBER.draw, height=(0.04, 0.2), half_width=(0.05, 0.2), gyration=(0.04, 0.12), shear=(0.3, 1.0)
    ),
    check=each(positive("half_width", "gyration", "shear"), ABSORBER.check),
    act=_act_rocking,
)

FORMS = (LAYERED, TABLE, HANGING, ROCKING)
