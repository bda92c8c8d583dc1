"""A foundation that is a pedestal: a column on the floor that bends, stretches and twists."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.base_flexibility import EFFECT as OWN
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, damping_time, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly

PART = 33 / 140
"""Of a clamped beam's mass that moves with its end, as if it were bent by a load there."""


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A tube whose top would tilt as the rig's own base does, somewhat slender."""
    tilt, height = OWN.draw(stand, where, random)["tilt_stiffness"], float(random.uniform(0.3, 1.2))
    return {
        "bending_stiffness": 4 * tilt * height,
        "height": height,
        "radius": float(random.uniform(0.15, 0.4)) * height,
        "ratio": float(np.exp(random.uniform(np.log(0.5), np.log(2.0)))),
        "pedestal_mass": float(random.uniform(0.1, 0.6)) * stand.mass,
        "damping_time": damping_time(random),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    """The end of a clamped column: E I/h³ (12 u² − 12 h u φ + 4 h² φ²) each way, a thin tube's A and J.

    That is 12 E I/h³ (u − h φ/2)² + E I/h φ².
    """
    names, motion = base_directions(assembly.normal)
    own = motion @ np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    ways = (level,) if assembly.normal is not None else (level, np.cross(up, level))
    height, rigidity, mass = site["height"], site["bending_stiffness"], site["pedestal_mass"]
    held = [(up @ own[:3], 2 * rigidity / (site["radius"] ** 2 * height))]
    for number, way in enumerate(ways):
        bending = rigidity * (site["ratio"] if number else 1.0)
        shift, turn = way @ own[:3], np.cross(up, way) @ own[3:]
        held += [(shift - height / 2 * turn, 12 * bending / height**3), (turn, bending / height)]
        assembly.add_inertia(shift, PART * mass)
    if assembly.normal is None:
        held.append((up @ own[3:], rigidity / 1.3 / height))  # G J of a thin tube, ν = 0.3
    assembly.add_inertia(up @ own[:3], mass / 3)
    for row, spring in held:
        assembly.add_spring(row, spring, site["damping_time"] * spring)


PEDESTAL: Effect = replace(
    OWN,
    form="pedestal",
    says="the robot stands on a column that bends, softer one way",
    source="Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, section 5.6 (a beam)",
    units={
        "bending_stiffness": "N·m², one way", "height": "m", "radius": "m, of the tube",
        "ratio": "E I the other way over that", "pedestal_mass": "kg", "damping_time": "s",
    },
    draw=_draw,
    scaled=divided("bending_stiffness"),
    check=positive("bending_stiffness", "height", "radius", "ratio"),
    act=_act,
)  # fmt: skip

FORMS = (PEDESTAL,)
