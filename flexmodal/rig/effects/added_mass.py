"""A payload, motor or tool that the card lacks: a body fixed to a link beside its axis."""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.effect import Effect, Site, Stand, multiplied, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import reach
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.arm import moved_bodies


def on_link(stand: Stand, link: str, along: float, beside: float) -> np.ndarray:
    """A place part of the way along a link and somewhat beside its axis, in its frame [m].

    Args:
        stand: the true robot and its plan.
        link: which.
        along: part of the way to its far end.
        beside: distance from its axis [m].
    """
    end = reach(stand.robot, link)
    length = float(np.linalg.norm(end))
    if length < 1e-6:
        return np.array([beside, 0.0, 0.0])
    axis = end / length
    side = across(axis, None)[0]
    inside = across(axis, stand.normal_in(link))
    side = inside[0] if inside else side
    return along * end + beside * side


def arm_mass(stand: Stand) -> float:
    """Mass of everything that moves [kg]."""
    return sum(stand.true.bodies[link].mass for link in moved_bodies(stand.robot))


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    place = on_link(stand, where, random.uniform(0.3, 1.0), random.uniform(-0.08, 0.08))
    return {
        "mass": float(random.uniform(0.05, 0.2) * arm_mass(stand)),
        "x": float(place[0]),
        "y": float(place[1]),
        "z": float(place[2]),
        "gyration": float(random.uniform(0.02, 0.08)),
    }


def _act(assembly: PlantAssembly, site: Site) -> None:
    inertia = site["mass"] * site["gyration"] ** 2 * np.eye(3)
    assembly.add_body(site.where, site.vector("x", "y", "z"), site["mass"], inertia)


EFFECT = Effect(
    name="added_mass",
    says="a body the card lacks",
    units={"mass": "kg", "x": "m", "y": "m", "z": "m", "gyration": "m, radius"},
    places=lambda robot, points: moved_bodies(robot),
    place_is="a link that moves",
    draw=_draw,
    scaled=multiplied("mass"),
    most=lambda parameters: 5.0,
    check=positive("mass"),
    act=_act,
)
