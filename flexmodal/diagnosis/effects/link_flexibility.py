"""A link bends: hinges with springs and dampers along it, in each plane it can bend in.

For a load at its far end the bending moment in a beam is linear along it, so that its strain energy is that
of springs at the points of Gauss's quadrature, each with the flexibility of its share of the length. Two of
them are exact for such loads. A link that has modes of its own in the band takes more, four or six: the bars
between the hinges then move as the beam does in its first modes (with a mass at the end, four are within
0.6 % in the third frequency; two hinges have two). A compliance that grows or falls along the link,
exponentially, stands for links that are stiffer at one end.

One hinge, the pseudo-joint of Hearne, section 2.3, is what all together are worth: the stiffness of all in
series, at the mean of their places weighted by compliance. The link's mass is taken as spread evenly along
it, or as far as its inertia allows; what that has beyond the inertia of thin rods is shared out in the same
way, so that mass, mass centre and inertia of the whole link stay what they were.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.effect import Bodies, Effect, Scene, Site, along, positive, sides, signed
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, beyond, bodies_of
from flexmodal.structure.assembly import Assembly, scaled

SHORTEST = 0.05
"""Links shorter than this do not bend [m]."""
FEW, MANY_IN_SPACE, MANY_IN_PLANE = 2, 4, 6
"""Hinges of a link whose own modes lie above the band, and of others; in space each bends in two planes."""
SOFT = 1 / 8
"""The stiffness at which that is asked, over that of the stiffest joint below."""


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


@cache
def gauss(count: int) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """Gauss's points along the length, as parts of it, and their weights."""
    place, weight = np.polynomial.legendre.leggauss(count)
    return (1 + place) / 2, weight / 2


def _hinges(scene: Scene, where: str) -> Float[np.ndarray, " hinge"]:
    """Where the hinges sit, as parts of the length.

    A beam of stiffness k = EI/L, mass m and rotary inertia J, held at both ends, has its first modes at
    22.4 √(k/m)/L (bending) and π √(k/J) (turning) [rad/s]: modes of the link itself, whatever it carries.
    Of modes alone nobody lists those.
    """
    known = scene.memory.setdefault("hinges", {})
    if where not in known:
        body, length = bodies_of(scene.robot.urdf)[where], along(scene, where)[0]
        k, turning = SOFT * _stiffest(scene, where), float(np.linalg.eigvalsh(body.inertia)[-1])
        first = min(22.4 * np.sqrt(k / body.mass) / length, np.pi * np.sqrt(k / max(turning, 1e-12)))
        many = MANY_IN_SPACE if scene.normal is None else MANY_IN_PLANE
        known[where] = gauss(many if scene.every_line and first < 2 * np.pi * scene.band[1] else FEW)[0]
    return known[where]


def _parameters(scene: Scene, where: str) -> tuple[Parameter, ...]:
    k = _stiffest(scene, where)
    places = _hinges(scene, where)
    return (
        positive("stiffness", "N·m/rad", k, 1.5, k / 300, k * 300),
        positive("damping", "N·m·s/rad", k * 3e-4, 1.5, k * 1e-7, k * 0.03),
        signed("position", "", 0.1, places[0] + 0.02, places[-1] - 0.02, centre=0.5),
    )


def _starts(scene: Scene, where: str) -> list[Mapping[str, float]]:
    k = _stiffest(scene, where)
    return [{"stiffness": factor * k} for factor in (0.2, 0.8, 3.0, 12.0, 40.0)]


def _names(scene: Scene, where: str) -> list[str]:
    planes = 1 if scene.normal is not None else 2
    count = len(_hinges(scene, where))
    return [f"{where} bend {hinge + 1}.{plane + 1}" for hinge in range(count) for plane in range(planes)]


def _shape(assembly: Assembly, site: Site) -> None:
    length, axis = along(site.scene, site.where)
    axes = assembly.axes(site.where)
    across = sides(site.scene, site.where, axis, axes)
    columns = assembly.add_coordinates(_names(site.scene, site.where))
    places = np.repeat(_hinges(site.scene, site.where), len(across))
    for number, place in enumerate(places.tolist()):
        turned = axes @ np.cross(axis, across[number % len(across)])
        assembly.hinge(site.where, place * length * axis, axis, columns.start + number, turned)


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
    ends = np.concatenate([[0.0], _hinges(site.scene, site.where), [1.0]])
    parts, whole = [], np.zeros((3, 3))
    for share, middle in zip(np.diff(ends).tolist(), ((ends[1:] + ends[:-1]) / 2).tolist(), strict=True):
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


def shares(stiffness: float, position: float, count: int) -> Float[np.ndarray, " hinge"]:
    """Stiffnesses of the hinges that together are worth one of `stiffness` at `position` [N·m/rad].

    The compliance along the link goes with exp(r·x); Newton's method finds the r with its mean at `position`.
    """
    place, weight = gauss(count)
    rate = 0.0
    for _ in range(50):
        part = weight * np.exp(rate * (place - 0.5))
        part /= part.sum()
        mean = float(part @ place)
        if abs(position - mean) < 1e-14:
            break
        rate += float(np.clip((position - mean) / (part @ (place - mean) ** 2), -5, 5))
    return stiffness / part


def _act(assembly: Assembly, site: Site) -> None:
    count, names = len(_hinges(site.scene, site.where)), _names(site.scene, site.where)
    springs = np.repeat(shares(site["stiffness"], site["position"], count), len(names) // count)
    for name, spring in zip(names, springs.tolist(), strict=True):
        row = assembly.row(name)
        assembly.add_spring(row, spring)
        assembly.add_damper(row, site["damping"] / site["stiffness"] * spring)


def _extend(draft: Draft, site: Site) -> None:
    link = site.where
    length, axis = along(site.scene, link)
    across = sides(site.scene, link, axis, site.scene.arm(0).placed[link][:3, :3])
    places, names = _hinges(site.scene, link), [link]
    springs = shares(site["stiffness"], site["position"], len(places)).tolist()
    for hinge, spring in enumerate(springs):
        turns = {}
        for plane, side in enumerate(across):
            end = f"_{plane + 1}" if len(across) > 1 else ""
            turns[draft.fresh(f"{link}_bend_{hinge + 1}{end}")] = np.cross(axis, side)
        names.append(draft.hinge(link, places[hinge] * length * axis, axis, turns))
        for joint in turns:
            draft.flexible(joint, spring, site["damping"] / site["stiffness"] * spring)
    card = bodies_of(site.scene.robot.urdf)[link]
    whole = scaled(card, link, site.values)
    grown = whole.mass / card.mass
    parts, rods = _rods(site, card)
    for number, (_, rod) in enumerate(parts):
        inertia = grown * rod.inertia + rod.mass / card.mass * (whole.inertia - grown * rods)
        shift = places[number - 1] * length * axis if number else np.zeros(3)
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
