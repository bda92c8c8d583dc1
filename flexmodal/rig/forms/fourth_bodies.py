"""Fourth forms of what bends, carries and hangs: a squeezed link, wheels, a slung cable, a leaf spring."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.rig.effects.added_mass import on_link
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
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam, sections
from flexmodal.rig.plant.geometry import across, cuboid
from flexmodal.structure.arm import carried

FIRST = 1.875104068711961
"""First root of cos βL cosh βL = −1, for the clamped-free beam."""


@dataclass(frozen=True, eq=False)
class Squeezed:
    """A beam that a taut cable squeezes: it runs straight from the clamp to the far end.

    As the beam bends its ends come nearer by ∫ w'²/2 dx, and the cable is shorter by that less w(L)²/(2 L).
    """

    beam: Beam
    pull: float
    """Of the cable [N]."""

    @property
    def length(self) -> float:
        """From the clamp to the far end [m]."""
        return self.beam.length

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "kept kept"]:
        """The beam's, less what the pull gives back; above 0 for a pull below π² E I/L²."""
        places, weights = sections()
        slopes = np.array([self.shape(float(place) * self.length)[1] for place in places])
        end, _ = self.shape(self.length)
        shortened = self.length * slopes.T @ (weights[:, None] * slopes) - np.outer(end, end) / self.length
        return self.beam.condensed_stiffness - self.pull * shortened

    def shape(self, place: float) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, " kept"]]:
        """Deflection and slope at a distance from the clamp [m], the beam's."""
        return self.beam.shape(place)


def _shape_squeezed(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    rigidity, weight = site["bending_stiffness"], max(site.stand.true.bodies[site.where].mass, 1e-9) / length
    pull = site["load"] * np.pi**2 * rigidity / length**2
    squeezed = Squeezed(Beam(length, rigidity, weight), float(pull))
    first = FIRST**2 * float(np.sqrt(rigidity / (weight * length**4)))
    for side in across(axis, plane_in(assembly, site.where)):
        assembly.add_flexure(site.where, squeezed, axis, side, 2 * site["damping_ratio"] / first)


def _draw_wheels(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Four wheels that carry the robot about as stiffly as the rig's own foundation does."""
    drawn = BASE.draw(stand, where, random)
    upright = drawn["translation_stiffness"] * drawn["vertical_over_horizontal"]
    width, tyre = float(np.sqrt(drawn["tilt_stiffness"] / upright)), float(random.uniform(1.5, 5.0))
    return {
        "suspension_stiffness": upright / 4 * (1 + tyre) / tyre,
        "tyre": tyre,
        "side": float(random.uniform(0.4, 1.0)),
        "half_width": width,
        "half_depth": float(random.uniform(0.7, 1.3)) * width,
        "height": float(random.uniform(0.3, 0.8)) * width,
        "wheel_mass": float(random.uniform(0.02, 0.06)) * stand.mass,
        "platform_mass": float(random.uniform(0.2, 1.0)) * stand.mass,
        "damping_ratio": float(random.uniform(0.05, 0.2)),
        "damping_time": damping_time(random),
    }


def _act_wheels(assembly: PlantAssembly, site: Site) -> None:
    """At each corner a suspension, a wheel and its tyre, one above the other; on the ground the tyre shears.

    Upright (k_s (z − u), m ü, k_t u), level a part of k_t where the wheel stands, `height` below the root.
    """
    wheels = [f"wheel {number}" for number in (1, 2, 3, 4)]
    assembly.add_coordinates(wheels)
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    beside, k = np.cross(up, level), site["suspension_stiffness"]
    damper = site["damping_ratio"] * float(np.sqrt(k * (site.stand.mass + site["platform_mass"])))
    tyre, time = site["tyre"] * k, site["damping_time"]
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    for name, (one, other) in zip(wheels, corners, strict=True):
        place = one * site["half_width"] * level + other * site["half_depth"] * beside
        wheel, top = assembly.row(name), carried(motion, place) @ own
        assembly.add_spring(up @ top[:3] - wheel, k, damper)
        assembly.add_spring(wheel, tyre, time * tyre)
        assembly.add_inertia(wheel, site["wheel_mass"])
        ground = carried(motion, place - site["height"] * up) @ own
        for way in (level, beside):
            assembly.add_spring(way @ ground[:3], site["side"] * tyre, time * site["side"] * tyre)
    root = assembly.robot.urdf.root
    axes = assembly.orientation(root).T @ np.column_stack([level, beside, up])
    sizes = np.array([2 * site["half_width"], 2 * site["half_depth"], site["height"]])
    inertia = axes @ cuboid(site["platform_mass"], sizes) @ axes.T
    assembly.add_body(root, -site["height"] / 2 * axes[:, 2], site["platform_mass"], inertia)


def _draw_slung(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """From shortly before the joint of a link to somewhere in its farther half."""
    joint = next(joint for joint in stand.robot.urdf.joints if joint.child == where)
    near = np.asarray(joint.xyz, dtype=float) * random.uniform(0.7, 0.95)
    far = on_link(stand, where, random.uniform(0.5, 1.0), random.uniform(-0.12, 0.12))
    mass = ADDED_MASS.draw(stand, where, random)["mass"]
    names = ("x", "y", "z", "x2", "y2", "z2")
    return {"mass": mass, **dict(zip(names, map(float, np.concatenate([near, far])), strict=True))}


def _act_slung(assembly: PlantAssembly, site: Site) -> None:
    """What hangs between two clips moves as a straight line between theirs: m/3 (a² + a b + b²) each way."""
    joint = next(joint for joint in assembly.robot.urdf.joints if joint.child == site.where)
    near = assembly.motion(joint.parent, site.vector("x", "y", "z"))[:3]
    far = assembly.motion(site.where, site.vector("x2", "y2", "z2"))[:3]
    points, weights = np.polynomial.legendre.leggauss(2)
    for part, weight in zip(((points + 1) / 2).tolist(), (weights / 2).tolist(), strict=True):
        for row in (1 - part) * near + part * far:
            assembly.add_inertia(row, weight * site["mass"])


def leaf(overhang: float, gyration: float) -> float:
    """Lowest eigenvalue of a body on a cantilever of length 1 and E I = 1; the body's mass is 1.

    Args:
        overhang: of its centre beyond the end of the leaf, over the length.
        gyration: its radius of gyration, likewise.
    """
    stiffness = np.array([[12.0, -6.0], [-6.0, 4.0]])
    mass = np.array([[1.0, overhang], [overhang, overhang**2 + gyration**2]])
    return float(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min())


def _act_leaf(assembly: PlantAssembly, site: Site) -> None:
    """A leaf of height h that stands along `d`: its end sways by u and nods by θ, and the body with it.

    E I/h³ (12 u² − 12 h u θ + 4 h² θ²) = 12 E I/h³ (u − h θ/2)² + E I/h θ².
    """
    up, side = ways(assembly, site)
    sway, nod = coordinates(assembly, 2)
    mass, height, over = site["mass"], site["height"], site["overhang"]
    axis = np.cross(up, side)
    centre = site.vector("x", "y", "z") + (height + over) * (assembly.orientation(site.where).T @ up)
    moved = assembly.motion(site.where, centre)
    for k in range(3):
        assembly.add_inertia(moved[k] + side[k] * (sway + over * nod), mass)
        assembly.add_inertia(moved[3 + k] + axis[k] * nod, mass * site["gyration"] ** 2)
    omega = 2 * np.pi * site["frequency"]
    rigidity = mass * height**3 * omega**2 / leaf(over / height, site["gyration"] / height)
    loss = 2 * site["damping_ratio"] / omega
    for row, spring in ((sway - height / 2 * nod, 12 * rigidity / height**3), (nod, rigidity / height)):
        assembly.add_spring(row, spring, loss * spring)


SQUEEZED: Effect = replace(
    LINK,
    form="squeezed",
    says="a link that a taut cable from end to end squeezes: it bends as a beam that is about to buckle",
    source="Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., McGraw-Hill 1961, chapters 1 and 2 "
    "(beam-columns; a force that passes through a fixed point)",
    units={
        "bending_stiffness": "N·m²", "load": "pull of the cable over π² E I/L²",
        "damping_ratio": "of the first clamped mode, were there no cable",
    },
    draw=drawing(LINK.draw, load=(0.35, 0.8)),
    check=each(positive("bending_stiffness"), within(damping_ratio=(0.0, 1.0), load=(0.0, 0.95))),
    shape=_shape_squeezed,
)  # fmt: skip
WHEELS: Effect = replace(
    BASE,
    form="wheels",
    says="the robot stands on a platform with four wheels, each on a suspension and a tyre",
    source="Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992, chapter 5 (sprung and unsprung masses)",
    units={
        "suspension_stiffness": "N/m, of a wheel", "tyre": "stiffness of a tyre upright over that",
        "side": "of a tyre level over upright", "half_width": "m", "half_depth": "m",
        "height": "m, of the root over the ground", "wheel_mass": "kg", "platform_mass": "kg",
        "damping_ratio": "of the suspension", "damping_time": "of the tyre, s",
    },
    draw=_draw_wheels,
    scaled=divided("suspension_stiffness"),
    check=each(
        positive("suspension_stiffness", "tyre", "side", "half_width", "half_depth", "height", "wheel_mass"),
        within(platform_mass=(0.0, np.inf), damping_ratio=(0.0, 2.0), damping_time=(0.0, 0.1)),
    ),
    act=_act_wheels,
)  # fmt: skip
SLUNG: Effect = replace(
    ADDED_MASS,
    form="slung",
    says="cables that hang between a clip before the joint and one on the link: both clips carry them",
    source="Archer, J. Structural Division ASCE 89 (1963) 161 (consistent mass: what lies between moves in "
    "proportion)",
    units={
        "mass": "kg, of the cables", "x": "m", "y": "m", "z": "m, of the clip on the link before",
        "x2": "m", "y2": "m", "z2": "m, of the clip on the link",
    },
    draw=_draw_slung,
    act=_act_slung,
)  # fmt: skip
LEAF: Effect = replace(
    ABSORBER,
    form="leaf",
    says="a body on a bracket of sheet, which sways and nods on it as on a leaf spring",
    source="Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, section 5.6 (the end of a "
    "clamped beam); Den Hartog, Mechanical Vibrations, 4th ed., chapter 3",
    units={
        **ABSORBER.units,
        "height": "m, of the leaf",
        "overhang": "m, of the body's centre beyond it",
        "gyration": "m, radius",
    },
    draw=drawing(ABSORBER.draw, height=(0.04, 0.2), overhang=(0.01, 0.1), gyration=(0.02, 0.08)),
    check=each(positive("height", "gyration"), within(overhang=(0.0, 10.0)), ABSORBER.check),
    act=_act_leaf,
)

FORMS = (SQUEEZED, WHEELS, SLUNG, LEAF)
