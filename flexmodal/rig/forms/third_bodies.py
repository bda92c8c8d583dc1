"""Third forms of what bends, carries and hangs: a telescope, rubber mounts, liquid in a pipe, a panel."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.rig.effects.added_mass import on_link
from flexmodal.rig.effects.base_flexibility import EFFECT as BASE
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, drawing, each, positive, within
from flexmodal.rig.effects.link_flexibility import EFFECT as LINK
from flexmodal.rig.effects.link_flexibility import plane_in, span
from flexmodal.rig.effects.local_absorber import EFFECT as ABSORBER
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.forms.maxwell_rows import fractional
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import slender_links
from flexmodal.rig.plant.geometry import across
from flexmodal.rig.plant.plant import Branch
from flexmodal.structure.arm import carried


@dataclass(frozen=True, eq=False)
class Pads:
    """A stiff tube that two pads hold in another one; its coordinates are how far the pads give [m].

    What stands out of the outer tube moves by the straight line through both.
    """

    length: float
    """[m]"""
    near: float
    """From the clamp to the pad at the end of the inner tube [m]."""
    far: float
    """From there to the pad at the end of the outer tube [m]."""
    springs: tuple[float, float]
    """Of the near pad and the far one [N/m]."""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "2 2"]:
        """The pads, each on its own."""
        return np.diag(self.springs)

    def shape(self, place: float) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]]:
        """Deflection and slope at a distance from the clamp [m], each a row over the pads."""
        if place < self.far:
            return np.zeros(2), np.zeros(2)
        apart = self.far - self.near
        slope = np.array([-1.0, 1.0]) / apart
        return np.array([self.far - place, place - self.near]) / apart, slope


def _draw_telescoped(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Pads against which the inner tube tilts as stiffly as the rig's own beam bends."""
    drawn, (length, _) = LINK.draw(stand, where, random), span(where, stand)
    overlap = float(random.uniform(0.15, 0.35))
    return {
        "pad_stiffness": 2 * drawn["bending_stiffness"] / length / (overlap * length) ** 2,
        "place": float(random.uniform(0.15, 0.45)),
        "overlap": overlap,
        "far": float(np.exp(random.uniform(np.log(0.5), np.log(2.0)))),
        "sideways": float(np.exp(random.uniform(np.log(0.4), np.log(1.5)))),
        "damping_ratio": drawn["damping_ratio"],
    }


def _shape_telescoped(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    near, wide = site["place"] * length, site["overlap"] * length
    mass = max(site.stand.true.bodies[site.where].mass, 1e-9)
    turning = site["pad_stiffness"] * wide**2 / 2
    loss = 2 * site["damping_ratio"] * float(np.sqrt(mass * length**2 / 3 / turning))
    for plane, side in enumerate(across(axis, plane_in(assembly, site.where))):
        spring = site["pad_stiffness"] * (site["sideways"] if plane else 1.0)
        pads = Pads(length, near, near + wide, (spring, site["far"] * spring))
        assembly.add_flexure(site.where, pads, axis, side, loss)


def _draw_mounts(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Mounts that carry the robot about as stiffly as the rig's own foundation does."""
    drawn = BASE.draw(stand, where, random)
    upright = drawn["translation_stiffness"] * drawn["vertical_over_horizontal"]
    width = float(np.sqrt(drawn["tilt_stiffness"] / upright))
    return {
        "mount_stiffness": upright / 4,
        "shear": float(random.uniform(0.2, 0.5)),
        "inclination": float(random.uniform(0.2, 0.7)),
        "half_width": width,
        "half_depth": float(random.uniform(0.7, 1.3)) * width,
        "below": float(random.uniform(0.1, 0.5)) * width,
        "loss_factor": float(random.uniform(0.05, 0.2)),
        "order": float(random.uniform(0.2, 0.5)),
    }


def _act_mounts(assembly: PlantAssembly, site: Site) -> None:
    """Four mounts that lean towards the middle: k along each, a part of it across; all of 1 + c (iω)^α."""
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    beside, lean = np.cross(up, level), site["inclination"]
    stiffness = np.zeros((len(names), len(names)))
    for one, other in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        place = one * site["half_width"] * level + other * site["half_depth"] * beside - site["below"] * up
        moved = carried(motion, place)[:3]
        along = np.cos(lean) * up - one * np.sin(lean) * level
        for way, part in ((along, 1.0), (np.cross(along, beside), site["shear"]), (beside, site["shear"])):
            stiffness += part * site["mount_stiffness"] * np.outer(way @ moved, way @ moved)
    made = fractional(site["loss_factor"], site["order"], site.stand.plan.band)
    values, vectors = np.linalg.eigh(stiffness)
    for value, row in zip(values.tolist(), vectors.T @ own, strict=True):
        assembly.add_spring(row, made.static * value, made.damper * value)
        assembly.branches += [
            Branch(row, float(part) * value, float(time))
            for part, time in zip(made.strengths, made.times, strict=True)
        ]


def _draw_pipe(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A pipe beside a link from somewhere near its root to somewhere near its far end."""
    mass, beside = ADDED_MASS.draw(stand, where, random)["mass"], float(random.uniform(-0.15, 0.15))
    ends = [on_link(stand, where, random.uniform(*part), beside) for part in ((0.0, 0.25), (0.75, 1.0))]
    names = ("x", "y", "z", "x2", "y2", "z2")
    return {"mass": mass, **dict(zip(names, map(float, np.concatenate(ends)), strict=True))}


def _act_pipe(assembly: PlantAssembly, site: Site) -> None:
    """Liquid that the wall takes along across the pipe only: along it, it stays where it is."""
    start, end = site.vector("x", "y", "z"), site.vector("x2", "y2", "z2")
    axis = (end - start) / np.linalg.norm(end - start)
    sides = assembly.orientation(site.where) @ np.column_stack(across(axis, None))
    points, weights = np.polynomial.legendre.leggauss(4)
    for place, weight in zip(((points + 1) / 2).tolist(), weights / 2, strict=True):
        moved = assembly.motion(site.where, start + place * (end - start))[:3]
        for side in sides.T:
            assembly.add_inertia(side @ moved, float(weight) * site["mass"])


def _act_panel(assembly: PlantAssembly, site: Site) -> None:
    """A sheet held all round: three modes, n half waves along and one across; what they leave is stiff.

    Of mode n goes 64/(π⁴ n²) of the mass with its frame's shift where n is odd, and 16 m a²/(π⁴ n²) with its
    turn where n is even; frequencies are as n² + (a/b)². In its own plane the sheet is stiff.
    """
    out, along = ways(assembly, site)
    mass, length, width = site["mass"], site["length"], site["width"]
    modes = coordinates(assembly, 3)
    motion = assembly.motion(site.where, site.vector("x", "y", "z"))
    axis = np.cross(along, out)
    framed = out @ motion[:3], axis @ motion[3:]
    left = [mass, mass * length**2 / 12]
    over = (length / width) ** 2
    for number, own in enumerate(modes, start=1):
        even = 1 - number % 2
        part = mass * (16 * length**2 if even else 64) / (np.pi**4 * number**2)
        left[even] -= part
        assembly.add_inertia(framed[even] + own, part)
        omega = 2 * np.pi * site["frequency"] * (number**2 + over) / (1 + over)
        assembly.add_spring(own, part * omega**2, 2 * site["damping_ratio"] * part * omega)
    for row, rest in zip(framed, left, strict=True):
        assembly.add_inertia(row, rest)
    for way, inertia in ((along, width**2), (out, length**2 + width**2)):
        assembly.add_inertia(way @ motion[3:], mass * inertia / 12)
    for way in (along, axis):
        assembly.add_inertia(way @ motion[:3], mass)


TELESCOPED: Effect = replace(
    LINK,
    form="telescoped",
    says="a tube that slides in another one and sits there on two pads, which give",
    source="Rivin, Mechanical Design of Robots, McGraw-Hill 1988, on telescopic links; a stiff bar on two "
    "springs",
    units={
        "pad_stiffness": "N/m, of the near pad",
        "place": "of the near pad, over the length",
        "overlap": "of both tubes, over the length",
        "far": "stiffness of the far pad over that of the near one",
        "sideways": "of stiffness in the second plane",
        "damping_ratio": "of the link on a clamped root",
    },
    draw=_draw_telescoped,
    scaled=divided("pad_stiffness"),
    check=each(
        positive("pad_stiffness", "overlap", "far", "sideways"),
        within(damping_ratio=(0.0, 1.0), place=(0.0, 0.6), overlap=(0.0, 0.4)),
    ),
    shape=_shape_telescoped,
)
MOUNTS: Effect = replace(
    BASE,
    form="rubber_mounts",
    says="the robot stands on four rubber mounts that lean towards the middle and stiffen with frequency",
    source="Rivin, Passive Vibration Isolation, ASME Press 2003, on inclined mounts; Sjöberg and Kari, "
    "Vehicle System Dynamics 37 (2002) 217 (rubber by a fractional derivative)",
    units={
        "mount_stiffness": "N/m, along a mount, mid-band", "shear": "stiffness across over along",
        "inclination": "rad, from upright", "half_width": "m", "half_depth": "m",
        "below": "m, of the mounts", "loss_factor": "mid-band", "order": "α",
    },
    draw=_draw_mounts,
    scaled=divided("mount_stiffness"),
    check=each(
        positive("mount_stiffness", "shear", "half_width", "half_depth"),
        within(inclination=(0.0, 1.5), loss_factor=(0.0, 0.6), order=(0.05, 0.7)),
    ),
    act=_act_mounts,
)  # fmt: skip
PIPE: Effect = replace(
    ADDED_MASS,
    form="pipe",
    says="liquid in a pipe along a link: the pipe takes it along sideways, not lengthways",
    source="Païdoussis, Fluid-Structure Interactions: Slender Structures and Axial Flow, Academic Press 1998 "
    "(pipes full of liquid, here at rest)",
    units={
        "mass": "kg, of the liquid",
        "x": "m", "y": "m", "z": "m", "x2": "m", "y2": "m", "z2": "m, of its other end",
    },
    places=lambda robot, points: slender_links(robot),
    place_is="a link that is long enough to carry a pipe",
    draw=_draw_pipe,
    act=_act_pipe,
)  # fmt: skip
PANEL: Effect = replace(
    ABSORBER,
    form="panel",
    says="a cover of sheet that is held all round and swings as a drum",
    source="Leissa, Vibration of Plates, NASA SP-160, 1969, chapter 4 (simply supported); effective masses "
    "by integrating its modes",
    units={**ABSORBER.units, "length": "m, along the link or so", "width": "m"},
    draw=drawing(ABSORBER.draw, length=(0.2, 0.6), width=(0.1, 0.4)),
    check=each(positive("length", "width"), ABSORBER.check),
    act=_act_panel,
)

FORMS = (TELESCOPED, MOUNTS, PIPE, PANEL)
