"""Seventh forms of what bends, carries and hangs: a tube between castings, a table on air, a sheet, a box."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.rig.effects.base_flexibility import EFFECT as BASE
from flexmodal.rig.effects.base_flexibility import base_coordinates, base_directions
from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    directed,
    divided,
    drawing,
    each,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.link_flexibility import EFFECT as LINK
from flexmodal.rig.effects.link_flexibility import plane_in, span, spread
from flexmodal.rig.effects.local_absorber import EFFECT as ABSORBER
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam
from flexmodal.rig.plant.chain import reach
from flexmodal.rig.plant.geometry import across, cuboid
from flexmodal.rig.plant.plant import BOUC_WEN, Branch, NonlinearElement

MOST_STIFF = 0.9
"""Of a link, what may be castings; where its numbers are varied beyond that, both give way."""


@dataclass(frozen=True, eq=False)
class Housed:
    """A beam between two ends that do not bend; its coordinates are the beam's own."""

    beam: Beam
    near: float
    """How far from the link's near end the beam begins [m]."""
    far: float
    """How long the stiff part beyond the beam is [m]."""

    @property
    def length(self) -> float:
        """Of the whole link [m]."""
        return self.near + self.beam.length + self.far

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "kept kept"]:
        """Of the beam: its ends store nothing."""
        return self.beam.condensed_stiffness

    def shape(self, place: float) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, " kept"]]:
        """Deflection and slope at a distance from the near end [m]; straight on beyond the beam."""
        out = place - self.near
        deflection, slope = self.beam.shape(out)
        return deflection + max(out - self.beam.length, 0.0) * slope, slope


def _draw_housings(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """What is left to bend is shorter than the link, and a tube that gives as much is softer."""
    drawn = LINK.draw(stand, where, random)
    near, far = float(random.uniform(0.1, 0.3)), float(random.uniform(0.1, 0.3))
    return {
        **drawn,
        "bending_stiffness": (1 - near - far) * drawn["bending_stiffness"],
        "near": near,
        "far": far,
        "flat": float(np.exp(random.uniform(np.log(0.4), np.log(2.5)))),
    }


def _shape_housings(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    normal, body = plane_in(assembly, site.where), site.stand.true.bodies[site.where]
    mass, _ = spread(body, length, axis, normal)
    near, far = (
        length * min(1.0, MOST_STIFF / (site["near"] + site["far"] + 1e-9)) * site.vector("near", "far")
    )
    for side, ratio in zip(across(axis, normal), (1.0, site["flat"]), strict=False):
        rigidity = ratio * site["bending_stiffness"]
        housed = Housed(Beam(length - near - far, rigidity, mass / length), near, far)
        slow = float(np.sqrt(max(body.mass, 1e-9) * length**3 / rigidity)) / 1.875104**2
        assembly.add_flexure(site.where, housed, axis, side, 2 * site["damping_ratio"] * slow)


def _check_housings(parameters: Parameters) -> str | None:
    stiff = parameters["near"] + parameters["far"]
    return None if stiff <= MOST_STIFF else f"near + far = {stiff:g}, where {MOST_STIFF:g} or less is allowed"


def _draw_isolated(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Mounts on which all of it bounces at 4 to 10 Hz, under a table half to twice as heavy as the robot."""
    long = max(float(sum(np.linalg.norm(joint.xyz) for joint in stand.robot.urdf.joints)), 0.5)
    table = float(random.uniform(0.5, 2.0)) * stand.mass
    omega = 2 * np.pi * float(random.uniform(4.0, 10.0))
    upright = (stand.mass + table) * omega**2 / 4
    chambers = float(random.uniform(0.5, 3.0))
    return {
        "vertical_stiffness": upright,
        "horizontal_stiffness": float(random.uniform(0.5, 1.5)) * upright,
        "damping_ratio": float(random.uniform(0.02, 0.08)),
        "chambers": chambers,
        "orifice_time": float(random.uniform(0.5, 2.0)) / omega / float(np.sqrt(1 + chambers)),
        "apart": float(random.uniform(0.4, 0.9)) * long,
        "table_mass": table,
        "thickness": float(random.uniform(0.05, 0.25)),
    }


def _act_isolated(assembly: PlantAssembly, site: Site) -> None:
    """Upright k (1 + N τ s/(1 + τ s)) of each mount: air that flows into a second chamber, or has no time to.

    A chain in a plane has two mounts before and two behind it.
    """
    flat, root = assembly.normal is not None, assembly.robot.urdf.root
    own = base_directions(assembly.normal)[1]
    level, up = own[:3, 0], own[:3, 1 if flat else 2]
    beside = np.cross(up, level)
    world, half, table = assembly.orientation(root).T, site["apart"] / 2, site["table_mass"]
    total = site.stand.mass + table
    k, swayed = site["vertical_stiffness"], site["horizontal_stiffness"]
    loss = 2 * site["damping_ratio"] * float(np.sqrt(total / 4 / swayed))
    for along, over in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        place = half * (along * level + (0 if flat else over) * beside) - site["thickness"] * up
        moved = assembly.motion(root, world @ place)[:3]
        assembly.add_spring(up @ moved, k)
        assembly.branches.append(Branch(up @ moved, site["chambers"] * k, site["orifice_time"]))
        for way in (level, beside):
            assembly.add_spring(way @ moved, swayed, loss * swayed)
    axes = world @ np.column_stack([level, beside, up])
    plate = cuboid(table, np.array([1.2 * site["apart"], 1.2 * site["apart"], site["thickness"]]))
    assembly.add_body(root, -site["thickness"] / 2 * (world @ up), table, axes @ plate @ axes.T)


def _draw_sheet(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A sheet about as long as its link, and narrower, held anywhere."""
    drawn = ADDED_MASS.draw(stand, where, random)
    size = max(float(np.linalg.norm(reach(stand.robot, where))), 0.2)
    normal = stand.normal_in(where)
    way = random.standard_normal(3)
    way = way if normal is None else way - (way @ normal) * normal
    second = np.cross(way, random.standard_normal(3) if normal is None else normal)
    return {
        "mass": drawn["mass"],
        **dict(zip(("x", "y", "z"), map(float, reach(stand.robot, where)), strict=True)),
        "long": float(random.uniform(0.5, 1.5)) * size,
        "wide": float(random.uniform(0.2, 0.8)) * size,
        **dict(zip(("lx", "ly", "lz"), map(float, way / np.linalg.norm(way)), strict=True)),
        **dict(zip(("wx", "wy", "wz"), map(float, second / np.linalg.norm(second)), strict=True)),
    }


def _act_sheet(assembly: PlantAssembly, site: Site) -> None:
    """A thin, even plate, held in the middle of an edge: m l²/12 and m w²/12, and both about its normal."""
    along, wide = site.vector("lx", "ly", "lz"), site.vector("wx", "wy", "wz")
    along = along / np.linalg.norm(along)
    wide = wide - (wide @ along) * along
    wide = wide / np.linalg.norm(wide)
    axes = np.column_stack([along, wide, np.cross(along, wide)])
    plate = cuboid(site["mass"], np.array([site["long"], site["wide"], 0.0]))
    place = site.vector("x", "y", "z") + site["long"] / 2 * along
    assembly.add_body(site.where, place, site["mass"], axes @ plate @ axes.T)


def _draw_wire_rope(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A hard blow, whose peak acceleration over ω² is a length, takes the strands well into sliding."""
    drawn = drawing(ABSORBER.draw, strands=(0.3, 0.6))(stand, where, random)
    swing = max(stand.acceleration.values()) / (2 * np.pi * drawn["frequency"]) ** 2
    return {
        **drawn,
        "mass": 1.5 * drawn["mass"],
        "damping_ratio": float(random.uniform(0.005, 0.02)),
        "travel": float(random.uniform(0.03, 0.15)) * swing,
    }


def _act_wire_rope(assembly: PlantAssembly, site: Site) -> None:
    """(1 − p) k y beside the strands' loop by Bouc and Wen, which begins with p k and levels off."""
    way, _ = ways(assembly, site)
    (own,) = coordinates(assembly, 1)
    moved, mass = assembly.motion(site.where, site.vector("x", "y", "z"))[:3], site["mass"]
    for axis in range(3):
        assembly.add_inertia(moved[axis] + way[axis] * own, mass)
    omega, part = 2 * np.pi * site["frequency"], site["strands"]
    spring = mass * omega**2
    assembly.add_spring(own, (1 - part) * spring, 2 * site["damping_ratio"] * mass * omega)
    law = (part * spring, part * spring * site["travel"], 0.0)
    assembly.elements.append(NonlinearElement(own, BOUC_WEN, law))


HOUSINGS: Effect = replace(
    LINK,
    form="housings",
    says="a rectangular tube between two castings, the housings of both joints, which do not bend themselves",
    source="Weaver and Gere, Matrix Analysis of Framed Structures, 3rd ed., 1990 (members with rigid ends); "
    "Rivin, Mechanical Design of Robots, McGraw-Hill 1988, on links",
    units={
        **LINK.units,
        "near": "length of the near casting over the link's",
        "far": "of the far one, likewise",
        "flat": "EI the other way over that one way",
    },
    draw=_draw_housings,
    check=each(LINK.check, within(near=(0.0, 0.8), far=(0.0, 0.8), flat=(0.01, 100.0)), _check_housings),
    shape=_shape_housings,
)
ISOLATED: Effect = replace(
    BASE,
    form="isolated",
    says="the robot stands on a heavy table on four air mounts, whose air flows through an orifice",
    source="DeBra, Annals of the CIRP 41 (1992) 711 (vibration isolation of precision machines); Rivin, "
    "Passive Vibration Isolation, ASME Press 2003, on pneumatic isolators",
    units={
        "vertical_stiffness": "N/m, of each mount while it is slow", "horizontal_stiffness": "N/m, of each",
        "damping_ratio": "sideways", "chambers": "stiffness that the orifice adds, over the other",
        "orifice_time": "s, of the air to flow over", "apart": "m, between the mounts", "table_mass": "kg",
        "thickness": "m, of the table",
    },
    draw=_draw_isolated,
    scaled=divided("vertical_stiffness", "horizontal_stiffness"),
    check=each(
        positive("vertical_stiffness", "horizontal_stiffness", "orifice_time", "apart", "table_mass"),
        within(damping_ratio=(0.0, 1.0), chambers=(0.0, 100.0), thickness=(0.0, 10.0)),
    ),
    shape=base_coordinates,
    act=_act_isolated,
)  # fmt: skip
SHEET: Effect = replace(
    ADDED_MASS,
    form="sheet",
    says="a sheet that the arm holds by an edge, a workpiece or a glass pane, which stands out from there",
    source="Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 2.13; Beer and Johnston, "
    "Vector Mechanics for Engineers: Dynamics, McGraw-Hill (thin plates)",
    units={
        "mass": "kg", "x": "m", "y": "m", "z": "m", "long": "m, away from the edge", "wide": "m, along it",
        "lx": "", "ly": "", "lz": "away from the edge", "wx": "", "wy": "", "wz": "along it",
    },
    draw=_draw_sheet,
    check=each(positive("mass", "long", "wide"), directed("lx", "ly", "lz"), directed("wx", "wy", "wz")),
    act=_act_sheet,
)  # fmt: skip
WIRE_ROPE: Effect = replace(
    ABSORBER,
    form="wire_rope",
    says="a camera or a box of electronics on wire-rope mounts, whose strands slide on one another: the "
    "wider it swings, the softer and the more damped",
    source="Demetriades, Constantinou and Reinhorn, Engineering Structures 15 (1993) 321 (wire-rope mounts); "
    "Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249",
    units={
        **ABSORBER.units,
        "strands": "part of the stiffness at rest that goes as strands slide",
        "travel": "m, over which they do",
    },
    draw=_draw_wire_rope,
    scaled=multiplied("mass"),
    check=each(ABSORBER.check, positive("travel"), within(strands=(0.01, 0.95))),
    act=_act_wire_rope,
    linear=False,
)

FORMS = (HOUSINGS, ISOLATED, SHEET, WIRE_ROPE)
