"""A foundation that is a carriage: on guides, held along its rail by a drive that gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.base_flexibility import EFFECT as OWN
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import cuboid
from flexmodal.structure.arm import carried


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A carriage of a third to one and a half times the robot's mass; guides stiffer than the drive."""
    drawn = OWN.draw(stand, where, random)
    over = float(random.uniform(0.3, 1.5))
    drive = drawn["translation_stiffness"] * (1 + over)
    block = float(random.uniform(2.0, 8.0)) * drive / 4
    length = float(np.sqrt(drawn["tilt_stiffness"] * (1 + over) / (4 * block)))
    return {
        "drive_stiffness": drive,
        "drive_damping_ratio": float(random.uniform(0.05, 0.2)),
        "block_stiffness": block,
        "sideways": float(random.uniform(0.5, 1.0)),
        "damping_ratio": float(random.uniform(0.01, 0.05)),
        "half_length": length,
        "half_width": float(random.uniform(0.6, 1.2)) * length,
        "below": float(random.uniform(0.1, 0.5)) * length,
        "carriage_mass": over * stand.mass,
        "angle": float(random.uniform(0.0, np.pi)),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    """Four blocks of the guides hold upright and across the rail, the drive along it, all at one height."""
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name) for name in names])
    up, level = np.array([0.0, 0.0, 1.0]), motion[:3, 0]
    angle = site["angle"] if assembly.normal is None else 0.0
    rail = np.cos(angle) * level + np.sin(angle) * np.cross(up, level)
    side = np.cross(up, rail)

    def row(place: np.ndarray, way: np.ndarray) -> np.ndarray:
        return np.asarray(way @ carried(motion, place)[:3] @ own)

    axes = assembly.orientation(assembly.robot.urdf.root)
    centre, mass = -site["below"] * up, site["carriage_mass"]
    inertia = cuboid(mass, 2 * np.array([site["half_length"], site["half_width"], site["below"]]))
    turned = np.column_stack([rail, side, up])
    assembly.add_body(
        assembly.robot.urdf.root, axes.T @ centre, mass, axes.T @ turned @ inertia @ turned.T @ axes
    )
    total, drive, block = site.stand.mass + mass, site["drive_stiffness"], site["block_stiffness"]
    for one, other in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        place = centre + one * site["half_length"] * rail + other * site["half_width"] * side
        for way, spring in ((up, block), (side, site["sideways"] * block)):
            damper = 2 * site["damping_ratio"] * float(np.sqrt(spring * total / 4))
            assembly.add_spring(row(place, way), spring, damper)
    damper = 2 * site["drive_damping_ratio"] * float(np.sqrt(drive * total))
    assembly.add_spring(row(centre, rail), drive, damper)


CARRIAGE: Effect = replace(
    OWN,
    form="carriage",
    says="the robot stands on a carriage whose drive gives along its rail",
    source="Altintas, Verl, Brecher, Uriarte and Pritschow, CIRP Annals 60 (2011) 779, on feed drives",
    units={
        "drive_stiffness": "N/m, along the rail", "drive_damping_ratio": "",
        "block_stiffness": "N/m, upright",
        "sideways": "stiffness of a block over upright", "damping_ratio": "of the blocks",
        "half_length": "m, of the carriage", "half_width": "m", "below": "m", "carriage_mass": "kg",
        "angle": "rad, of the rail",
    },
    draw=_draw,
    scaled=divided("drive_stiffness", "block_stiffness"),
    check=positive("drive_stiffness", "block_stiffness", "sideways", "half_length", "half_width", "below"),
    act=_act,
)  # fmt: skip

FORMS = (CARRIAGE,)
