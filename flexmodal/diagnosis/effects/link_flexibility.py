"""A link bends: hinges with springs and dampers along it, in each plane it can bend in.

For a load at its far end all that a link in bending does is in three figures: its compliance, where along it
that sits on average, and how far it spreads. Two hinges have them: of a compliance c with its mean at a part
p of the length and a deviation s √(p (1 − p)) they sit at p (1 − s) with (1 − p) c and at p + s (1 − p) with
p c. One hinge, the pseudo-joint of Hearne, section 2.3, is s = 0; an even beam p = ½ and s = 1/√3, which are
Gauss's points; shear adds to the spread. Where that is not enough there are more hinges, see `hinges`. In
space the two planes have stiffnesses of their own, about axes turned by an angle, and the link twists about
its length on one spring more.

The link's mass is taken as spread evenly along it, or as far as its inertia allows; what that has beyond the
inertia of thin rods is shared out in the same way, so that mass, mass centre and inertia of the whole link
stay what they were.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Bodies, Effect, Placement, along, positive, sides, signed
from flexmodal.diagnosis.effects.hinges import EVEN, fixed, shares, stiffest
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, bodies_of
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.robot_terms import scaled

SHORTEST = 0.05
"""Links shorter than this do not bend [m]."""
TWIST = 3.0
"""Stiffness against twist over that against bending, about: G J over E I, and more where little twists it."""


def _places(context: Context) -> tuple[str, ...]:
    return tuple(link for link in context.links if along(context, link)[0] >= SHORTEST)


def bending(placement: Placement) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """Where the hinges sit, as parts of the length, and their shares of the compliance."""
    mean, spread = placement["position"], placement["spread"]
    known = fixed(placement.context, placement.where)
    if known is not None:
        return known[0], shares(mean, spread, *known)
    return (
        np.array([mean * (1 - spread), mean + spread * (1 - mean)]),
        np.array([1 - mean, mean]),
    )


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = stiffest(context, where)
    found = (
        positive("stiffness", "N·m/rad", k, 1.5, k / 300, k * 3e4),
        positive("damping", "N·m·s/rad", k * 3e-4, 1.5, k * 1e-7, k * 10),
        signed("position", "", 0.1, 0.03, 0.97, centre=0.5),
        signed("spread", "", 0.1, 0.02, 0.98, centre=EVEN),
    )
    if context.normal is not None:
        return found
    return (
        *found,
        positive("ratio", "", 1.0, 0.4, 0.05, 20.0),
        signed("angle", "rad", 0.8, -1.6, 1.6),
        positive("twist_ratio", "", TWIST, 1.5, 0.02, 1e4),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    k = stiffest(context, where)
    grid = (0.2, 0.8, 3.0, 12.0, 40.0, 400.0, 4000.0)  # the stiffest where a slide comes before the link
    found: list[Mapping[str, float]] = [
        {"stiffness": factor * k, "damping": 3e-4 * factor * k} for factor in grid
    ]
    ends = [{"position": place, "spread": 0.1} for place in (0.06, 0.94)]
    return found + [{**one, **more} for one in found[1:4] for more in ends]


def names_of(context: Context, where: str, count: int) -> list[str]:
    """Coordinates of so many hinges, those of one place side by side; in space the twist is the last.

    Args:
        context: whose robot.
        where: the link.
        count: of hinges.
    """
    planes = 1 if context.normal is not None else 2
    bends = [f"{where} bend {hinge + 1}.{plane + 1}" for hinge in range(count) for plane in range(planes)]
    return bends if planes == 1 else [*bends, f"{where} twist"]


def add_hinges(assembly: Assembly, placement: Placement, places: Float[np.ndarray, " hinge"]) -> None:
    """Let a link bend at these parts of its length, and in space twist at one of them.

    The torque along a link is the same everywhere, and so is where it twists.

    Args:
        assembly: the robot, its motions not complete yet.
        placement: of the effect; its place is the link.
        places: of the hinges, as parts of the length.
    """
    context, where = placement.context, placement.where
    length, axis = along(context, where)
    axes = assembly.axes(where)
    turns = [np.cross(axis, side) for side in sides(context, where, axis)]
    columns = assembly.add_coordinates(names_of(context, where, len(places)))
    for number, place in enumerate(np.repeat(places, len(turns)).tolist()):
        turned = axes @ turns[number % len(turns)]
        assembly.hinge(where, place * length * axis, axis, columns.start + number, turned)
    if context.normal is None:
        place = float(places[len(places) // 2])
        assembly.hinge(where, place * length * axis, axis, columns.stop - 1, axes @ axis)


def cut_body(
    assembly: Assembly, placement: Placement, bodies: Bodies, link: str, places: Float[np.ndarray, " hinge"]
) -> bool:
    """Share the body of the link out between its hinges; says whether it is that link's.

    Args:
        assembly: that gets the parts.
        placement: of the effect; its place is the link that bends.
        bodies: of all links, by name.
        link: the one whose body is to be put in.
        places: of the hinges, as parts of the length.
    """
    if link != placement.where:
        return False
    body, tags = bodies[link], {"mass": f"mass.{link}"}
    parts, whole = _rods(placement, body, places)
    for section, rod in parts:
        share = rod.mass / body.mass
        turning = Body(0.0, section, share * body.inertia)
        assembly.add_body(link, rod, section=section, **tags)
        assembly.add_body(link, turning, section=section, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, section, -share * whole), section=section, **tags)
    return True


def _rods(
    placement: Placement, body: Body, places: Float[np.ndarray, " hinge"]
) -> tuple[list[tuple[np.ndarray, Body]], np.ndarray]:
    """Parts of a link as thin rods, each with its place along it, and the inertia of all about its centre."""
    end, axis = along(placement.context, placement.where)
    thin = np.eye(3) - np.outer(axis, axis)
    length = min(end, _spread(placement, body, axis))
    ends = np.concatenate([[0.0], places, [1.0]])
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


def _planes(placement: Placement) -> list[tuple[float, list[tuple[int, float]]]]:
    """Stiffness of each principal plane over the first's, and its shares in those of the coordinates."""
    if placement.context.normal is not None:
        return [(1.0, [(0, 1.0)])]
    cosine, sine = np.cos(placement["angle"]), np.sin(placement["angle"])
    return [(1.0, [(0, cosine), (1, sine)]), (placement["ratio"], [(0, -sine), (1, cosine)])]


def _act(assembly: Assembly, placement: Placement) -> None:
    context, where = placement.context, placement.where
    time, planes = placement["damping"] / placement["stiffness"], _planes(placement)
    springs = placement["stiffness"] / bending(placement)[1]
    names = names_of(context, where, len(springs))
    for hinge, spring in enumerate(springs.tolist()):
        own = names[len(planes) * hinge :]
        for ratio, parts in planes:
            row = np.sum([share * assembly.row(own[plane]) for plane, share in parts], axis=0)
            assembly.add_spring(row, ratio * spring)
            assembly.add_damper(row, time * ratio * spring)
    if context.normal is None:
        twist = placement["twist_ratio"] * placement["stiffness"]
        assembly.add_spring(assembly.row(names[-1]), twist)
        assembly.add_damper(assembly.row(names[-1]), time * twist)


def _extend(draft: Draft, placement: Placement) -> None:
    context, link = placement.context, placement.where
    length, axis = along(context, link)
    turns_of = [np.cross(axis, side) for side in sides(context, link, axis)]
    time, names = placement["damping"] / placement["stiffness"], [link]
    places, compliance = bending(placement)
    for hinge, spring in enumerate((placement["stiffness"] / compliance).tolist()):
        turns, stiffness = {}, {}
        for plane, (ratio, parts) in enumerate(_planes(placement)):
            joint = draft.fresh(f"{link}_bend_{hinge + 1}" + (f"_{plane + 1}" if len(turns_of) > 1 else ""))
            turns[joint] = np.sum([share * turns_of[number] for number, share in parts], axis=0)
            stiffness[joint] = ratio * spring
        if context.normal is None and hinge == len(places) // 2:
            joint = draft.fresh(f"{link}_twist")
            turns[joint], stiffness[joint] = axis, placement["twist_ratio"] * placement["stiffness"]
        names.append(draft.hinge(link, places[hinge] * length * axis, axis, turns))
        for joint, one in stiffness.items():
            draft.flexible(joint, one, time * one)
    card = bodies_of(placement.context.robot.urdf)[link]
    whole = scaled(card, link, placement.values)
    grown = whole.mass / card.mass
    rods, thin = _rods(placement, card, places)
    for number, (_, rod) in enumerate(rods):
        inertia = grown * rod.inertia + rod.mass / card.mass * (whole.inertia - grown * thin)
        shift = places[number - 1] * length * axis if number else np.zeros(3)
        draft.set_body(names[number], Body(grown * rod.mass, rod.centre - shift, inertia))


EFFECT = Effect(
    name="link_flexibility",
    says="the link bends",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    shape=lambda assembly, placement: add_hinges(assembly, placement, bending(placement)[0]),
    geometry=("position", "spread"),
    bodies=lambda assembly, placement, bodies, link: cut_body(
        assembly, placement, bodies, link, bending(placement)[0]
    ),
    act=_act,
    extend=_extend,
)
