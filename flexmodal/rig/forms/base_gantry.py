"""A foundation that is a girder: the robot stands on a beam between two supports, as on a gantry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.base_flexibility import EFFECT as OWN
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, damping_time, divided, each, positive, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.structure.arm import carried


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A girder that would let a robot at its middle sink and tilt as the rig's own base does."""
    drawn = OWN.draw(stand, where, random)
    upright, tilt = drawn["translation_stiffness"], drawn["tilt_stiffness"]
    length = float(np.sqrt(12 * tilt / upright))  # 192 EI/L³ upright, 16 EI/L against a tilt
    return {
        "bending_stiffness": tilt * length / 16,
        "length": length,
        "place": float(random.uniform(0.25, 0.75)),
        "sideways": float(np.exp(random.uniform(np.log(0.4), np.log(1.5)))),
        "torsion": float(random.uniform(0.4, 0.9)),
        "gyration": float(random.uniform(0.05, 0.1)) * length,
        "below": float(random.uniform(0.05, 0.15)) * length,
        "angle": float(random.uniform(0.0, np.pi)),
        "girder_mass": float(random.uniform(0.1, 0.6)) * stand.mass,
        "damping_time": damping_time(random),
    }


def _bend(assembly: PlantAssembly, site: Site, rigidity: float, shift: np.ndarray, slope: np.ndarray) -> None:
    """Both spans in one plane: elements of a beam, held at the supports, with consistent masses.

    E I/h³ (12 w² ∓ 12 h w φ + 4 h² φ²) and μ h/420 (156 w² ∓ 44 h w φ + 4 h² φ²), as sums of squares.
    """
    line = site["girder_mass"] / site["length"]
    for side, part in ((-1, site["place"]), (1, 1 - site["place"])):
        h = part * site["length"]
        for row, spring in (
            (shift + side * h / 2 * slope, 12 * rigidity / h**3),
            (slope, rigidity / h),
        ):
            assembly.add_spring(row, spring, site["damping_time"] * spring)
        assembly.add_inertia(shift + side * 11 / 78 * h * slope, 156 / 420 * line * h)
        assembly.add_inertia(slope, (4 - 22**2 / 156) / 420 * line * h**3)


def _act(assembly: PlantAssembly, site: Site) -> None:
    """The robot is bolted onto the girder, whose axis runs some way below it; it bends, stretches, twists."""
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    angle = site["angle"] if assembly.normal is None else 0.0
    along = np.cos(angle) * level + np.sin(angle) * np.cross(up, level)
    side = np.cross(up, along)
    node = carried(motion, -site["below"] * up) @ own
    rigidity = site["bending_stiffness"]
    _bend(assembly, site, rigidity, up @ node[:3], -side @ node[3:])
    if assembly.normal is None:
        _bend(assembly, site, site["sideways"] * rigidity, side @ node[:3], up @ node[3:])
    over = 1 / site["place"] + 1 / (1 - site["place"])
    for row, stiff, inertia in (
        (along @ node[:3], rigidity / site["gyration"] ** 2, site["girder_mass"]),
        (along @ node[3:], site["torsion"] * rigidity, 2 * site["girder_mass"] * site["gyration"] ** 2),
    ):
        spring = stiff * over / site["length"]
        assembly.add_spring(row, spring, site["damping_time"] * spring)
        assembly.add_inertia(row, inertia / 3)


GANTRY: Effect = replace(
    OWN,
    form="gantry",
    says="the robot stands on a girder between two supports",
    source="Clough and Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, chapter 10 (beams)",
    units={
        "bending_stiffness": "N·m², upright", "length": "m, between the supports",
        "place": "of the robot, over the length", "sideways": "E I level over upright",
        "torsion": "G J over E I", "gyration": "m, radius of the section", "below": "m, of its axis",
        "angle": "rad, of the girder", "girder_mass": "kg", "damping_time": "s",
    },
    draw=_draw,
    scaled=divided("bending_stiffness"),
    check=each(
        positive("bending_stiffness", "length", "sideways", "torsion", "gyration"),
        within(place=(0.05, 0.95), girder_mass=(0.0, np.inf)),
    ),
    act=_act,
)  # fmt: skip

FORMS = (GANTRY,)
