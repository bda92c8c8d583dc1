"""A link of two plates that only their ends tie: it sways like a portal, and bends as a beam edgewise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, each, positive, within
from flexmodal.rig.effects.link_flexibility import EFFECT as OWN
from flexmodal.rig.effects.link_flexibility import plane_in, span
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam
from flexmodal.rig.plant.geometry import across, turn


@dataclass(frozen=True, eq=False)
class Sway:
    """Plates held against turning at both ends: the far end shifts and does not tilt.

    A plate deflects by 3 ξ² − 2 ξ³ of that; its coordinate is the shift of the far end [m].
    """

    length: float
    """[m]"""
    spring: float
    """12 EI/length³ of both plates together [N/m]."""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "1 1"]:
        """Of the shift."""
        return np.array([[self.spring]])

    def shape(self, place: float) -> tuple[Float[np.ndarray, " 1"], Float[np.ndarray, " 1"]]:
        """Deflection and slope of a plate at a distance from the clamp [m]."""
        part = place / self.length
        return np.array([3 * part**2 - 2 * part**3]), np.array([6 * (part - part**2) / self.length])


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Plates that give as much under a load at the far end as the rig's own beam does."""
    drawn = OWN.draw(stand, where, random)
    length, _ = span(where, stand)
    return {
        "sway_stiffness": 3 * drawn["bending_stiffness"] / length**3,
        "edgewise": float(np.exp(random.uniform(np.log(1.0), np.log(6.0)))),
        "angle": float(random.uniform(0.0, np.pi)),
        "damping_ratio": drawn["damping_ratio"],
    }


def _shape(assembly: PlantAssembly, site: Site) -> None:
    """Thin way of the plates: in the plane of a planar chain, at an angle to the first side of another."""
    length, axis = span(site.where, site.stand)
    sides = across(axis, plane_in(assembly, site.where))
    mass = max(site.stand.true.bodies[site.where].mass, 1e-9)
    spring = site["sway_stiffness"]
    loss = 2 * site["damping_ratio"] * float(np.sqrt(mass / 3 / spring))
    if len(sides) == 2:
        sides = tuple(turn(axis, site["angle"]) @ side for side in sides)
    for number, side in enumerate(sides):
        edge = Beam(length, site["edgewise"] * spring * length**3 / 3, mass / length)
        assembly.add_flexure(site.where, edge if number else Sway(length, spring), axis, side, loss)


PLATES: Effect = replace(
    OWN,
    form="plates",
    says="two plates that only their ends tie: the far end shifts and does not tilt",
    source="Weaver and Gere, Matrix Analysis of Framed Structures, 3rd ed., 1990 (frames that sway)",
    units={
        "sway_stiffness": "N/m, at the far end", "edgewise": "stiffness there the other way over that",
        "angle": "rad, of the thin way", "damping_ratio": "of the link on a clamped root",
    },
    draw=_draw,
    scaled=divided("sway_stiffness"),
    check=each(positive("sway_stiffness", "edgewise"), within(damping_ratio=(0.0, 1.0))),
    shape=_shape,
)  # fmt: skip

FORMS = (PLATES,)
