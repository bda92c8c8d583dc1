"""A link bends: a hinge with spring and damper somewhere along it, one in each plane it can bend in.

The pseudo-joint of Hearne, section 2.3. The link's mass is taken as spread evenly along it, cut at the hinge;
what its inertia has beyond that of two thin rods is shared out in the same proportion, so that mass, mass
centre and inertia of the whole link stay what they were.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.effect import Bodies, Effect, Scene, Site, along, positive, sides, signed
from flexmodal.identification import Parameter
from flexmodal.identification.arm import Body, beyond, bodies_of
from flexmodal.identification.assembly import Assembly, scaled

SHORTEST = 0.05
"""Links shorter than this do not bend [m]."""


def _places(scene: Scene) -> tuple[str, ...]:
    return tuple(link for link in scene.links if along(scene, link)[0] >= SHORTEST)


def _stiffest(scene: Scene, link: str) -> float:
    """Stiffness of the stiffest joint between the base and a link [N·m/rad]."""
    urdf = scene.robot.urdf
    return max(
        float(joint.stiffness)
        for name, joint in scene.robot.joints.items()
        if link in beyond(urdf, urdf.joint_by_name[name].child)
    )


def _parameters(scene: Scene, where: str) -> tuple[Parameter, ...]:
    k = _stiffest(scene, where)
    return (
        positive("stiffness", "N·m/rad", k, 1.5, k / 300, k * 300),
        positive("damping", "N·m·s/rad", k * 3e-4, 1.5, k * 1e-7, k * 0.03),
        signed("position", "", 0.15, 0.02, 0.98, centre=0.4),
    )


def _starts(scene: Scene, where: str) -> list[Mapping[str, float]]:
    k = _stiffest(scene, where)
    return [
        {"stiffness": factor * k, "position": place} for factor in (0.4, 1.2, 4.0) for place in (0.25, 0.55)
    ]


def _shape(assembly: Assembly, site: Site) -> None:
    length, axis = along(site.scene, site.where)
    axes = assembly.axes(site.where)
    across = sides(site.scene, site.where, axis, axes)
    names = [f"{site.where} bend {k + 1}" for k in range(len(across))]
    columns = assembly.add_coordinates(names)
    for k, side in enumerate(across):
        turned = axes @ np.cross(axis, side)
        assembly.hinge(site.where, site["position"] * length * axis, axis, columns.start + k, turned)


def _bodies(assembly: Assembly, site: Site, bodies: Bodies, link: str) -> bool:
    if link != site.where:
        return False
    body, tags = bodies[link], {"mass": f"mass.{link}"}
    halves, rods = _rods(site, body)
    for inner, rod in halves.items():
        part = rod.mass / body.mass
        turning = Body(0.0, rod.centre, part * body.inertia)
        assembly.add_body(link, rod, inner=inner, **tags)
        assembly.add_body(link, turning, inner=inner, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, rod.centre, -part * rods), inner=inner, **tags)
    return True


def _rods(site: Site, body: Body) -> tuple[dict[bool, Body], np.ndarray]:
    """Near (True) and far half (False) of a link as thin rods, and the inertia of both about its centre."""
    length, axis = along(site.scene, site.where)
    cut, thin = site["position"], np.eye(3) - np.outer(axis, axis)
    halves, both = {}, np.zeros((3, 3))
    for part, middle, inner in ((cut, cut / 2, True), (1 - cut, (1 + cut) / 2, False)):
        lever = (middle - 0.5) * length * axis
        own = part * body.mass * (part * length) ** 2 / 12 * thin
        both += own + part * body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        halves[inner] = Body(part * body.mass, body.centre + lever, own)
    return halves, both


def _act(assembly: Assembly, site: Site) -> None:
    for name in assembly.coordinates:
        if name.startswith(f"{site.where} bend "):
            assembly.add_spring(assembly.row(name), site["stiffness"])
            assembly.add_damper(assembly.row(name), site["damping"])


def _extend(draft: Draft, site: Site) -> None:
    length, axis = along(site.scene, site.where)
    axes = site.scene.arm(0).placed[site.where][:3, :3]
    across = sides(site.scene, site.where, axis, axes)
    ends = [f"_{k + 1}" for k in range(len(across))] if len(across) > 1 else [""]
    names = [draft.fresh(f"{site.where}_bend{end}") for end in ends]
    turns = {name: np.cross(axis, side) for name, side in zip(names, across, strict=True)}
    outer = draft.hinge(site.where, site["position"] * length * axis, axis, turns)
    for name in names:
        draft.flexible(name, site["stiffness"], site["damping"])
    card = bodies_of(site.scene.robot.urdf)[site.where]
    whole = scaled(card, site.where, site.values)
    halves, rods = _rods(site, Body(whole.mass, card.centre, card.inertia))
    for inner, rod in halves.items():
        inertia = rod.inertia + rod.mass / whole.mass * (whole.inertia - rods)
        shift = np.zeros(3) if inner else site["position"] * length * axis
        draft.set_body(site.where if inner else outer, Body(rod.mass, rod.centre - shift, inertia))


EFFECT = Effect(
    name="link_flexibility",
    says="the link bends",
    looks_like="a resonance that rigid links do not have, and a bend in the shape along the link",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    geometry=("position",),
    bodies=_bodies,
    act=_act,
    extend=_extend,
)
