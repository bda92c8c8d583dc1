"""A payload, motor or tool that the card lacks: a compact mass fixed to a link, on its axis or beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.effect import Effect, Scene, Site, along, positive, sides, signed
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly


def _parameters(scene: Scene, where: str) -> tuple[Parameter, ...]:
    mass = scene.arm_mass
    found = [
        positive("mass", "kg", 0.05 * mass, 1.2, 1e-4 * mass, 3 * mass),
        signed("along", "", 0.35, -0.3, 1.3, centre=0.65),
        signed("beside", "m", 0.06, -0.5, 0.5),
        positive("gyration", "m", 0.05, 0.7, 2e-3, 0.5),
    ]
    if scene.normal is None:
        found.append(signed("above", "m", 0.06, -0.5, 0.5))
    return tuple(found)


def place_on(scene: Scene, where: str, values: Mapping[str, float], axes: np.ndarray) -> np.ndarray:
    """A place part of the way along a link and beside its axis, in its frame [m]."""
    length, axis = along(scene, where)
    across = sides(scene, where, axis, axes)
    place = values["along"] * max(length, 0.05) * axis
    for name, side in zip(("beside", "above"), across, strict=False):
        place = place + values[name] * side
    return place


def _compact(site: Site, place: np.ndarray) -> Body:
    """With the same moment of inertia about every axis, as a ball or a cube has."""
    return Body(site["mass"], place, site["mass"] * site["gyration"] ** 2 * np.eye(3))


def _act(assembly: Assembly, site: Site) -> None:
    place = place_on(site.scene, site.where, site.values, assembly.axes(site.where))
    assembly.add_body(site.where, _compact(site, place))


def _physical(scene: Scene, where: str, values: Mapping[str, float]) -> dict[str, float]:
    axes = scene.arm(0).placed[where][:3, :3]
    x, y, z = place_on(scene, where, values, axes).tolist()
    return {"mass": values["mass"], "x": x, "y": y, "z": z, "gyration": values["gyration"]}


def _extend(draft: Draft, site: Site) -> None:
    place = place_on(site.scene, site.where, site.values, site.scene.arm(0).placed[site.where][:3, :3])
    draft.attach(site.where, _compact(site, place), name=f"{site.where}_payload")


EFFECT = Effect(
    name="added_mass",
    says="the link carries a mass that the card lacks",
    looks_like="lower frequencies, most in postures where the link's end moves most, and a lower mass line",
    places=lambda scene: scene.links,
    parameters=_parameters,
    starts=lambda scene, where: [
        {"mass": share * scene.arm_mass, "along": place} for share in (0.04, 0.15) for place in (0.4, 0.95)
    ],
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"x": "m", "y": "m", "z": "m"},
)
