"""A link bends: two hinges with springs and dampers along it, in each plane it can bend in.

For a load at its far end the bending moment in a beam is linear along it, so that its strain energy is that
of springs at the two points of Gauss's quadrature, (1 ± 1/√3)/2 of its length: a uniform beam is exact with
2EI/L each, and shares between the two stand for beams that are stiffer at one end. One hinge, the
pseudo-joint of Hearne, section 2.3, is what both together are worth: the stiffness of the two in series, at
their weighted place. The link's mass is taken as spread evenly along it, or as far as its inertia allows;
what that has beyond the inertia of thin rods is shared out in the same way, so that mass, mass centre and
inertia of the whole link stay what they were.
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
HINGES = ((1 - 3**-0.5) / 2, (1 + 3**-0.5) / 2)
"""Where the hinges sit, as parts of the length."""


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
        signed("position", "", 0.1, HINGES[0] + 0.02, HINGES[1] - 0.02, centre=0.5),
    )


def _starts(scene: Scene, where: str) -> list[Mapping[str, float]]:
    k = _stiffest(scene, where)
    return [{"stiffness": factor * k} for factor in (0.2, 0.8, 3.0, 12.0, 40.0)]


def _names(scene: Scene, where: str) -> list[str]:
    planes = 1 if scene.normal is not None else 2
    return [f"{where} bend {hinge + 1}.{plane + 1}" for hinge in range(2) for plane in range(planes)]


def _shape(assembly: Assembly, site: Site) -> None:
    length, axis = along(site.scene, site.where)
    axes = assembly.axes(site.where)
    across = sides(site.scene, site.where, axis, axes)
    columns = assembly.add_coordinates(_names(site.scene, site.where))
    for number in range(2 * len(across)):
        hinge, plane = divmod(number, len(across))
        turned = axes @ np.cross(axis, across[plane])
        assembly.hinge(site.where, HINGES[hinge] * length * axis, axis, columns.start + number, turned)


def _bodies(assembly: Assembly, site: Site, bodies: Bodies, link: str) -> bool:
    if link != site.where:
        return False
    body, tags = bodies[link], {"mass": f"mass.{link}"}
    parts, whole = _rods(site, body)
    for section, rod in parts:
        share = rod.mass / body.mass
        turning = Body(0.0, section, share * body.inertia)
        assembly.add_body(link, rod, section=section, **tags)
        assembly.add_body(link, turning, section=section, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, section, -share * whole), section=section, **tags)
    return True


def _rods(site: Site, body: Body) -> tuple[list[tuple[np.ndarray, Body]], np.ndarray]:
    """Parts of a link as thin rods, each with its place along it, and the inertia of all about its centre."""
    end, axis = along(site.scene, site.where)
    thin = np.eye(3) - np.outer(axis, axis)
    length = min(end, _spread(site, body, axis))
    shares = (HINGES[0], HINGES[1] - HINGES[0], 1 - HINGES[1])
    middles = (HINGES[0] / 2, 0.5, 1 - HINGES[0] / 2)
    parts, whole = [], np.zeros((3, 3))
    for share, middle in zip(shares, middles, strict=True):
        lever = (middle - 0.5) * length * axis
        own = share * body.mass * (share * length) ** 2 / 12 * thin
        whole += own + share * body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        parts.append((middle * end * axis, Body(share * body.mass, body.centre + lever, own)))
    return parts, whole


def _spread(site: Site, body: Body, axis: np.ndarray) -> float:
    """Length of the longest thin rod in the body, beside a disc with its moment about the axis [m]."""
    across = sides(site.scene, site.where, axis, site.scene.arm(0).placed[site.where][:3, :3])
    turns = np.array([np.cross(axis, side) for side in across])
    least = float(np.linalg.eigvalsh(turns @ body.inertia @ turns.T)[0])
    disc = 0.0 if site.scene.normal is not None else float(axis @ body.inertia @ axis) / 2
    return float(np.sqrt(12 * max(least - disc, 0.0) / body.mass))


def shares(stiffness: float, position: float) -> tuple[float, float]:
    """Stiffnesses of the two hinges that are worth one of `stiffness` at `position` [N·m/rad]."""
    width = HINGES[1] - HINGES[0]
    return stiffness * width / (HINGES[1] - position), stiffness * width / (position - HINGES[0])


def _act(assembly: Assembly, site: Site) -> None:
    springs = shares(site["stiffness"], site["position"])
    for name in _names(site.scene, site.where):
        spring = springs[int(name.rsplit(" ", 1)[1][0]) - 1]
        row = assembly.row(name)
        assembly.add_spring(row, spring)
        assembly.add_damper(row, site["damping"] / site["stiffness"] * spring)


def _extend(draft: Draft, site: Site) -> None:
    link = site.where
    length, axis = along(site.scene, link)
    across = sides(site.scene, link, axis, site.scene.arm(0).placed[link][:3, :3])
    springs, names = shares(site["stiffness"], site["position"]), [link]
    for hinge, spring in enumerate(springs):
        turns = {}
        for plane, side in enumerate(across):
            end = f"_{plane + 1}" if len(across) > 1 else ""
            turns[draft.fresh(f"{link}_bend_{hinge + 1}{end}")] = np.cross(axis, side)
        names.append(draft.hinge(link, HINGES[hinge] * length * axis, axis, turns))
        for joint in turns:
            draft.flexible(joint, spring, site["damping"] / site["stiffness"] * spring)
    card = bodies_of(site.scene.robot.urdf)[link]
    whole = scaled(card, link, site.values)
    grown = whole.mass / card.mass
    parts, rods = _rods(site, card)
    for number, (_, rod) in enumerate(parts):
        inertia = grown * rod.inertia + rod.mass / card.mass * (whole.inertia - grown * rods)
        shift = HINGES[number - 1] * length * axis if number else np.zeros(3)
        draft.set_body(names[number], Body(grown * rod.mass, rod.centre - shift, inertia))


EFFECT = Effect(
    name="link_flexibility",
    says="the link bends",
    looks_like="a resonance that rigid links do not have, and a bend in the shape along the link",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    bodies=_bodies,
    act=_act,
    extend=_extend,
)
