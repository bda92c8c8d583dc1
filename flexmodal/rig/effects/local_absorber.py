"""Something resilient on a link: a mass on a spring and a damper, free along one direction of the link."""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.added_mass import arm_mass, on_link
from flexmodal.rig.effects.effect import Effect, Site, Stand, directed, each, multiplied, positive, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import heading
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.arm import moved_bodies


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Tuned between a tenth and half of the band, across the link."""
    place = on_link(stand, where, random.uniform(0.3, 1.0), random.uniform(-0.06, 0.06))
    low, high = stand.plan.band
    sides = across(heading(stand.robot, where), stand.normal_in(where))
    angle = random.uniform(0, 2 * np.pi)
    way = sides[0] if len(sides) == 1 else np.cos(angle) * sides[0] + np.sin(angle) * sides[1]
    frequency = np.exp(random.uniform(np.log(max(3 * low, 0.05 * high)), np.log(0.5 * high)))
    return {
        "mass": float(random.uniform(0.03, 0.12) * arm_mass(stand)),
        "frequency": float(frequency),
        "damping_ratio": float(random.uniform(0.01, 0.06)),
        "x": float(place[0]),
        "y": float(place[1]),
        "z": float(place[2]),
        "dx": float(way[0]),
        "dy": float(way[1]),
        "dz": float(way[2]),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    """The mass moves with its link, and besides along its own direction: three rows of (motion + way · y)."""
    place, mass = site.vector("x", "y", "z"), site["mass"]
    way = site.vector("dx", "dy", "dz")
    way = assembly.orientation(site.where) @ (way / np.linalg.norm(way))
    name = f"absorber {len(assembly.coordinates)}"
    assembly.add_coordinates([name])
    own = assembly.row(name)
    carried = assembly.motion(site.where, place)[:3]
    for axis in range(3):
        assembly.add_inertia(carried[axis] + way[axis] * own, mass)
    stiffness = mass * (2 * np.pi * site["frequency"]) ** 2
    assembly.add_spring(own, stiffness, 2 * site["damping_ratio"] * float(np.sqrt(stiffness * mass)))


EFFECT = Effect(
    name="local_absorber",
    says="a mass on a spring and damper, attached to a link",
    units={
        "mass": "kg", "frequency": "Hz, on a link held still", "damping_ratio": "",
        "x": "m", "y": "m", "z": "m", "dx": "", "dy": "", "dz": "",
    },
    places=lambda robot, points: moved_bodies(robot),
    place_is="a link that moves",
    draw=_draw,
    scaled=multiplied("mass"),
    most=lambda parameters: 5.0,
    check=each(
        positive("mass", "frequency"), within(damping_ratio=(0.0, np.inf)), directed("dx", "dy", "dz")
    ),
    act=_act,
)  # fmt: skip
