"""Fifth forms of what bends, carries and hangs: an opening in a link, a console, a heap, a loop of hose."""

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
    each,
    positive,
    within,
)
from flexmodal.rig.effects.link_flexibility import EFFECT as LINK
from flexmodal.rig.effects.link_flexibility import plane_in, span
from flexmodal.rig.effects.local_absorber import EFFECT as ABSORBER
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import across

HEAP_LOW = 3 / 8
"""Depth of a half ball's mass centre below the middle of its flat face, over its radius."""
HEAP_ROUND = 2 / 5
"""Moment of a half ball about its own axis, over m R²."""
HEAP_ACROSS = 83 / 320
"""Likewise about an axis across that, through its mass centre."""


@dataclass(frozen=True, eq=False)
class Opening:
    """A stiff box whose walls give beside an opening; what lies beyond tilts and shifts by it.

    Its coordinates are the tilt [rad], about the middle of the opening, and the shift [m].
    """

    length: float
    """Of the box [m]."""
    place: float
    """From the clamp to the middle of the opening [m]."""
    springs: tuple[float, float]
    """Against the tilt [N·m/rad] and the shift [N/m]."""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "2 2"]:
        """Both, each on its own."""
        return np.diag(self.springs)

    def shape(self, place: float) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]]:
        """Deflection and slope at a distance from the clamp [m], each a row over tilt and shift."""
        if place < self.place:
            return np.zeros(2), np.zeros(2)
        return np.array([place - self.place, 1.0]), np.array([1.0, 0.0])


def _draw_opening(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Its walls tilt about as the rig's own beam bends, and shift besides as two short beams."""
    drawn, (length, _) = LINK.draw(stand, where, random), span(where, stand)
    tilt = float(random.uniform(1.5, 3.0)) * drawn["bending_stiffness"] / length
    return {
        "tilt_stiffness": tilt,
        "shift_stiffness": tilt / (float(random.uniform(0.3, 0.9)) * length) ** 2,
        "place": float(random.uniform(0.2, 0.6)),
        "sideways": float(np.exp(random.uniform(np.log(1.0), np.log(5.0)))),
        "damping_ratio": drawn["damping_ratio"],
    }


def _shape_opening(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    mass, tilt, shift = (
        site.stand.true.bodies[site.where].mass,
        site["tilt_stiffness"],
        site["shift_stiffness"],
    )
    loss = 2 * site["damping_ratio"] * float(np.sqrt(max(mass, 1e-9) * length**2 / 3 / tilt))
    for plane, side in enumerate(across(axis, plane_in(assembly, site.where))):
        stiffer = site["sideways"] if plane else 1.0
        opening = Opening(length, site["place"] * length, (stiffer * tilt, stiffer * shift))
        assembly.add_flexure(site.where, opening, axis, side, loss)


def _draw_console(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A console whose end would tilt and sink as the rig's own foundation does."""
    drawn = BASE.draw(stand, where, random)
    tilt, upright = drawn["tilt_stiffness"], drawn["translation_stiffness"]
    part = float(random.uniform(0.15, 0.6))  # of the tilt, what the anchors give
    length = float(np.sqrt(tilt / upright / ((1 - part) / 3 + part)))
    return {
        "bending_stiffness": tilt * length / (1 - part),
        "anchor_stiffness": tilt / part,
        "length": length,
        "depth": float(random.uniform(0.3, 0.8)) * length,
        "sideways": float(np.exp(random.uniform(np.log(0.3), np.log(1.0)))),
        "torsion": float(random.uniform(0.3, 0.9)),
        "angle": float(random.uniform(0.0, 2 * np.pi)),
        "console_mass": float(random.uniform(0.1, 0.5)) * stand.mass,
        "damping_time": damping_time(random),
    }


def console(length: float, rigidity: float, anchor: float) -> Float[np.ndarray, "2 2"]:
    """What shift and slope of the end of a cantilever cost, whose clamp turns on a spring.

    Args:
        length: [m].
        rigidity: E I [N·m²].
        anchor: of the clamp [N·m/rad].
    """
    by_beam = np.array([[length**3 / 3, length**2 / 2], [length**2 / 2, length]]) / rigidity
    lever = np.array([length, 1.0])
    return np.asarray(np.linalg.inv(by_beam + np.outer(lever, lever) / anchor))


def _act_console(assembly: PlantAssembly, site: Site) -> None:
    """The robot stands at the end of a beam that stands level out of a wall; a third of its mass goes along.

    Lengthways E A/l with A = 12 I/h², and a twist G J/l.
    """
    names, motion = base_directions(assembly.normal)
    own = motion @ np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    angle = site["angle"] if assembly.normal is None else 0.0
    along = np.cos(angle) * level + np.sin(angle) * np.cross(up, level)
    beside, length, rigidity = np.cross(up, along), site["length"], site["bending_stiffness"]
    held = [(along @ own[:3], 12 * rigidity / (site["depth"] ** 2 * length))]
    ways = ((up, 1.0),) if assembly.normal is not None else ((up, 1.0), (beside, site["sideways"]))
    for way, part in ways:
        both = np.array([way @ own[:3], np.cross(along, way) @ own[3:]])
        stiffness = part * console(length, rigidity, site["anchor_stiffness"])
        values, vectors = np.linalg.eigh(stiffness)
        held += list(zip(vectors.T @ both, values.tolist(), strict=True))
    if assembly.normal is None:
        held.append((along @ own[3:], site["torsion"] * rigidity / length))
    for row, spring in held:
        assembly.add_spring(row, spring, site["damping_time"] * spring)
    for row in own[:3]:
        assembly.add_inertia(row, site["console_mass"] / 3)


def _draw_heap(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = ADDED_MASS.draw(stand, where, random)
    place = {name: drawn[name] for name in ("mass", "x", "y", "z")}
    return {**place, "radius": float(random.uniform(0.08, 0.2))}


def _act_heap(assembly: PlantAssembly, site: Site) -> None:
    """Half a ball of grain, whose flat face is level: its centre lies 3/8 R below that of the vessel."""
    mass, radius = site["mass"], site["radius"]
    down = -assembly.orientation(site.where)[2]
    ball = mass * radius**2 * (HEAP_ACROSS * np.eye(3) + (HEAP_ROUND - HEAP_ACROSS) * np.outer(down, down))
    place = site.vector("x", "y", "z") + HEAP_LOW * radius * down
    assembly.add_body(site.where, place, mass, ball)


def _draw_loop(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """From shortly before the joint of a link to its farther half; as heavy as the rig's own, or twice."""
    joint = next(joint for joint in stand.robot.urdf.joints if joint.child == where)
    drawn = ABSORBER.draw(stand, where, random)
    near = np.asarray(joint.xyz, dtype=float) * random.uniform(0.6, 0.95)
    far = on_link(stand, where, random.uniform(0.5, 1.0), random.uniform(-0.12, 0.12))
    places = dict(
        zip(("nx", "ny", "nz", "x", "y", "z"), map(float, np.concatenate([near, far])), strict=True)
    )
    mass = float(random.uniform(1.0, 2.0)) * drawn["mass"]
    return {**drawn, **places, "mass": mass, "other": float(random.uniform(0.5, 0.9))}


def _act_loop(assembly: PlantAssembly, site: Site) -> None:
    """Between its clips it moves by (1 − s) a + s b, and swings by sin(π s) y besides, in space two ways.

    That is m/3 (a² + a b + b²) + 2 m/π (a + b) y + m/2 y² each way, on a spring m/2 ω².
    """
    joint = next(joint for joint in assembly.robot.urdf.joints if joint.child == site.where)
    sides = ways(assembly, site)[: 1 if assembly.normal is not None else 2]
    own = coordinates(assembly, len(sides))
    near = assembly.motion(joint.parent, site.vector("nx", "ny", "nz"))[:3]
    far = assembly.motion(site.where, site.vector("x", "y", "z"))[:3]
    points, weights = np.polynomial.legendre.leggauss(8)
    for part, weight in zip(((points + 1) / 2).tolist(), (weights / 2).tolist(), strict=True):
        moved = (1 - part) * near + part * far
        for side, swings in zip(sides, own, strict=True):
            moved = moved + np.sin(np.pi * part) * np.outer(side, swings)
        for row in moved:
            assembly.add_inertia(row, weight * site["mass"])
    for number, swings in enumerate(own):
        omega = 2 * np.pi * site["frequency"] * (site["other"] if number else 1.0)
        spring = site["mass"] / 2 * omega**2
        assembly.add_spring(swings, spring, 2 * site["damping_ratio"] * spring / omega)


OPENING: Effect = replace(
    LINK,
    form="opening",
    says="a hollow link with an opening for hands or cables: beside it the walls give, which tilts and "
    "shifts what lies beyond",
    source="Blodgett, Design of Welded Structures, Lincoln Arc Welding Foundation 1966 (open panels of "
    "Vierendeel girders); Rivin, Mechanical Design of Robots, McGraw-Hill 1988",
    units={
        "tilt_stiffness": "N·m/rad",
        "shift_stiffness": "N/m",
        "place": "of the opening's middle, over the length",
        "sideways": "of both in the second plane",
        "damping_ratio": "of the link on a clamped root",
    },
    draw=_draw_opening,
    scaled=divided("tilt_stiffness", "shift_stiffness"),
    check=each(
        positive("tilt_stiffness", "shift_stiffness", "sideways"),
        within(damping_ratio=(0.0, 1.0), place=(0.0, 0.9)),
    ),
    shape=_shape_opening,
)
CONSOLE: Effect = replace(
    BASE,
    form="console",
    says="the robot stands at the end of a console that stands out of a wall, on anchors that give",
    source="Eligehausen, Mallée and Silva, Anchorage in Concrete Construction, Ernst & Sohn 2006; "
    "Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, section 5.6 (a beam)",
    units={
        "bending_stiffness": "N·m²", "anchor_stiffness": "N·m/rad, of the anchors", "length": "m",
        "depth": "m: E A is 12 E I over its square", "sideways": "of stiffness level over upright",
        "torsion": "G J over E I", "angle": "rad, which way it stands out of the wall",
        "console_mass": "kg", "damping_time": "damping over stiffness, s",
    },
    draw=_draw_console,
    scaled=divided("bending_stiffness", "anchor_stiffness"),
    check=each(
        positive("bending_stiffness", "anchor_stiffness", "length", "depth", "sideways", "torsion"),
        within(console_mass=(0.0, np.inf), damping_time=(0.0, 0.1)),
    ),
    act=_act_console,
)  # fmt: skip
HEAP: Effect = replace(
    ADDED_MASS,
    form="heap",
    says="a round vessel half full of grain, which has run to its lowest place and lies still there",
    source="Schulze, Powders and Bulk Solids, Springer 2008, on how bulk solids settle; Beer and Johnston, "
    "Vector Mechanics for Engineers: Dynamics, McGraw-Hill (a half ball)",
    units={"mass": "kg", "x": "m", "y": "m", "z": "m, of the vessel's centre", "radius": "m"},
    draw=_draw_heap,
    check=positive("mass", "radius"),
    act=_act_heap,
)
LOOP: Effect = replace(
    ABSORBER,
    form="loop",
    says="a loop of hose between a clip before the joint and one on the link, which swings between both",
    source="Meirovitch, Analytical Methods in Vibrations, Macmillan 1967, on strings whose ends move; "
    "Archer, J. Structural Division ASCE 89 (1963) 161",
    units={
        **ABSORBER.units,
        "z": "m, of the clip on the link",
        "nx": "m", "ny": "m", "nz": "m, of the clip on the link before",
        "other": "frequency of the second way over that of the first",
    },
    draw=_draw_loop,
    check=each(ABSORBER.check, positive("other")),
    act=_act_loop,
)  # fmt: skip

FORMS = (OPENING, CONSOLE, HEAP, LOOP)
