"""A link bends: a hinge with spring and damper somewhere along it, one in each plane it can bend in.

The pseudo-joint of Hearne, section 2.3. The link's mass is taken as spread evenly along it, cut at the hinge;
what its inertia has beyond that of two thin rods is shared out in the same proportion, so that mass, mass
centre and inertia of the whole link stay what they were.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.effect import Bodies, Effect, Scene, Site, along, positive, sides, signed
from flexmodal.identification import Parameter
from flexmodal.identification.arm import Body, beyond
from flexmodal.identification.assembly import Assembly

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
    length, axis = along(site.scene, link)
    body, cut = bodies[link], site["position"]
    thin = np.eye(3) - np.outer(axis, axis)
    shift = body.centre - length / 2 * axis
    tags = {"mass": f"mass.{link}"}
    rods = np.zeros((3, 3))
    for part, middle, inner in ((cut, cut / 2, True), (1 - cut, (1 + cut) / 2, False)):
        centre = shift + middle * length * axis
        lever = centre - body.centre
        own = part * body.mass * (part * length) ** 2 / 12 * thin
        rods += own + part * body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        assembly.add_body(link, Body(part * body.mass, centre, own), inner=inner, **tags)
    for part, inner in ((cut, True), (1 - cut, False)):
        turning = Body(0.0, shift + (cut if inner else 1.0) * length * axis, part * body.inertia)
        assembly.add_body(link, turning, inner=inner, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, turning.centre, -part * rods), inner=inner, **tags)
    return True


def _act(assembly: Assembly, site: Site) -> None:
    for name in assembly.coordinates:
        if name.startswith(f"{site.where} bend "):
            assembly.add_spring(assembly.row(name), site["stiffness"])
            assembly.add_damper(assembly.row(name), site["damping"])


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
)
