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
from functools import cache, lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Bodies, Effect, Placement, along, positive, sides, signed
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, beyond, bodies_of
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.robot_terms import scaled

SHORTEST = 0.05
"""Links shorter than this do not bend [m]."""
FEW, MANY_IN_SPACE, MANY_IN_PLANE = 2, 4, 6
"""Hinges of a link whose own modes lie above the band, and of others; in space each bends in two planes."""
SOFT = 1 / 8
"""The stiffness at which that is asked, over that of the stiffest joint below."""


def _places(context: Context) -> tuple[str, ...]:
    return tuple(link for link in context.links if along(context, link)[0] >= SHORTEST)


def stiffest(context: Context, link: str) -> float:
    """Stiffness of the stiffest joint between the base and a link [N·m/rad]."""
    urdf = context.robot.urdf
    return max(
        float(joint.stiffness)
        for name, joint in context.robot.joints.items()
        if link in beyond(urdf, urdf.joint_by_name[name].child)
    )


@cache
def gauss(count: int) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """Gauss's points along the length, as parts of it, and their weights."""
    place, weight = np.polynomial.legendre.leggauss(count)
    return (1 + place) / 2, weight / 2


@lru_cache(maxsize=128)
def hinges(context: Context, where: str) -> Float[np.ndarray, " hinge"]:
    """Where the hinges sit, as parts of the length.

    A beam of stiffness k = EI/L, mass m and rotary inertia J, held at both ends, has its first modes at
    22.4 √(k/m)/L (bending) and π √(k/J) (turning) [rad/s]: modes of the link itself, whatever it carries.
    Of modes alone nobody lists those.
    """
    body, length = bodies_of(context.robot.urdf)[where], along(context, where)[0]
    k, turning = SOFT * stiffest(context, where), float(np.linalg.eigvalsh(body.inertia)[-1])
    first = min(22.4 * np.sqrt(k / body.mass) / length, np.pi * np.sqrt(k / max(turning, 1e-12)))
    many = MANY_IN_SPACE if context.normal is None else MANY_IN_PLANE
    return gauss(many if context.every_line and first < 2 * np.pi * context.band[1] else FEW)[0]


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = stiffest(context, where)
    places = hinges(context, where)
    return (
        positive("stiffness", "N·m/rad", k, 1.5, k / 300, k * 300),
        positive("damping", "N·m·s/rad", k * 3e-4, 1.5, k * 1e-7, k * 0.03),
        signed("position", "", 0.1, places[0] + 0.02, places[-1] - 0.02, centre=0.5),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    k = stiffest(context, where)
    return [{"stiffness": factor * k} for factor in (0.2, 0.8, 3.0, 12.0, 40.0)]


def names_of(context: Context, where: str) -> list[str]:
    """Coordinates of the hinges, those of one place side by side."""
    planes = 1 if context.normal is not None else 2
    count = len(hinges(context, where))
    return [f"{where} bend {hinge + 1}.{plane + 1}" for hinge in range(count) for plane in range(planes)]


def _shape(assembly: Assembly, placement: Placement) -> None:
    length, axis = along(placement.context, placement.where)
    axes = assembly.axes(placement.where)
    across = sides(placement.context, placement.where, axis)
    columns = assembly.add_coordinates(names_of(placement.context, placement.where))
    places = np.repeat(hinges(placement.context, placement.where), len(across))
    for number, place in enumerate(places.tolist()):
        turned = axes @ np.cross(axis, across[number % len(across)])
        assembly.hinge(placement.where, place * length * axis, axis, columns.start + number, turned)


def _bodies(assembly: Assembly, placement: Placement, bodies: Bodies, link: str) -> bool:
    if link != placement.where:
        return False
    body, tags = bodies[link], {"mass": f"mass.{link}"}
    parts, whole = _rods(placement, body)
    for section, rod in parts:
        share = rod.mass / body.mass
        turning = Body(0.0, section, share * body.inertia)
        assembly.add_body(link, rod, section=section, **tags)
        assembly.add_body(link, turning, section=section, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, section, -share * whole), section=section, **tags)
    return True


def _rods(placement: Placement, body: Body) -> tuple[list[tuple[np.ndarray, Body]], np.ndarray]:
    """Parts of a link as thin rods, each with its place along it, and the inertia of all about its centre."""
    end, axis = along(placement.context, placement.where)
    thin = np.eye(3) - np.outer(axis, axis)
    length = min(end, _spread(placement, body, axis))
    ends = np.concatenate([[0.0], hinges(placement.context, placement.where), [1.0]])
    parts, whole = [], np.zeros((3, 3))
    for share, middle in zip(np.diff(ends).tolist(), ((ends[1:] + ends[:-1]) / 2).tolist(), strict=True):
        lever = (middle - 0.5) * length * axis
        own = share * body.mass * (share * length) ** 2 / 12 * thin
        whole += own + share * body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        parts.append((middle * end * axis, Body(share * body.mass, body.centre + lever, own)))
    return parts, whole


def _spread(placement: Placement, body: Body, axis: np.ndarray) -> float:
    """Length of the longest thin rod in the body, beside a disc with its moment about the axis [m]."""
    across = sides(placement.context, placement.where, axis)
    turns = np.array([np.cross(axis, side) for side in across])
    least = float(np.linalg.eigvalsh(turns @ body.inertia @ turns.T)[0])
    disc = 0.0 if placement.context.normal is not None else float(axis @ body.inertia @ axis) / 2
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


def _act(assembly: Assembly, placement: Placement) -> None:
    count, names = (
        len(hinges(placement.context, placement.where)),
        names_of(placement.context, placement.where),
    )
    springs = np.repeat(shares(placement["stiffness"], placement["position"], count), len(names) // count)
    for name, spring in zip(names, springs.tolist(), strict=True):
        row = assembly.row(name)
        assembly.add_spring(row, spring)
        assembly.add_damper(row, placement["damping"] / placement["stiffness"] * spring)


def _extend(draft: Draft, placement: Placement) -> None:
    link = placement.where
    length, axis = along(placement.context, link)
    across = sides(placement.context, link, axis)
    places, names = hinges(placement.context, link), [link]
    springs = shares(placement["stiffness"], placement["position"], len(places)).tolist()
    for hinge, spring in enumerate(springs):
        turns = {}
        for plane, side in enumerate(across):
            end = f"_{plane + 1}" if len(across) > 1 else ""
            turns[draft.fresh(f"{link}_bend_{hinge + 1}{end}")] = np.cross(axis, side)
        names.append(draft.hinge(link, places[hinge] * length * axis, axis, turns))
        for joint in turns:
            draft.flexible(joint, spring, placement["damping"] / placement["stiffness"] * spring)
    card = bodies_of(placement.context.robot.urdf)[link]
    whole = scaled(card, link, placement.values)
    grown = whole.mass / card.mass
    parts, rods = _rods(placement, card)
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
