"""A link bends: hinges with springs and dampers along it, in each plane it can bend in.

For a load at its far end all that a link in bending does is in three figures: its compliance, where along it
that sits on average, and how far it spreads. Two hinges have them: of a compliance c with its mean at a part
p of the length and a deviation s √(p (1 − p)) they sit at p (1 − s) with (1 − p) c and at p + s (1 − p) with
p c. One hinge, the pseudo-joint of Hearne, section 2.3, is s = 0; an even beam p = ½ and s = 1/√3, which are
Gauss's points; shear adds to the spread. Where that is not enough there are more hinges, see `hinges`. In
space the two planes have stiffnesses of their own, about axes turned by an angle, and the link twists about
its length on one spring more.

Where a link is looked at or struck between its ends it twists evenly along its length. There, and where it
has modes of its own, shear is what it is: slides of a spring 12 k/(Φ L²) in each plane, k the stiffness
against bending and Φ = 12 EI/(κGA L²) (Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968,
section 5.6).

The link's mass is taken as spread evenly along it as far as its centre and its inertia allow, the rest as a
lump, see `cut_body`. At the next level how much is in the lump is free, and hinges that have fixed places may
move towards an end of their piece, as those of a link on one hinge do; and there may be a crack, which is a
hinge with a spring that opens in one plane (Dimarogonas, Engineering Fracture Mechanics 55, 1996, 831),
and where what lies beyond may slide too, as beside an opening. And it may sway in each plane, with a spring
12 k/(s L²) at its end: two plates tied at their ends hardly bend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.cut_body import SPREAD, TUBE, cut
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, along, positive, sides, signed
from flexmodal.diagnosis.effects.hinges import EVEN, fixed, stiffest
from flexmodal.diagnosis.effects.link_motion import (
    SHIFT,
    SWAYS,
    add_hinges,
    bending,
    cut_body,
    sections,
)
from flexmodal.diagnosis.effects.link_springs import (
    CRACK,
    CRACK_AT,
    SLIDE,
    act,
    planes,
    shares_of,
    sideways,
    sliding,
)
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, bodies_of, crossed
from flexmodal.structure.robot_terms import scaled

SHORTEST = 0.05
"""Links shorter than this do not bend [m]."""
OPENINGS = (0.25, 0.4, 0.6)
"""Places of an opening beside which the walls give, from which fits start."""
SHEAR = 0.03
"""Φ, about: of a thin tube sixteen times as long as wide, κ = ½."""
BENDS = ("position", "spread")
"""What two hinges sit by."""
HARDLY = 1e-3
"""s of a link that does not sway, about."""
SEEN = 0.01
"""s from which it is told how files have it."""
NONE = 1e-6
"""s below which they have no joint for it."""
STIFFER = 10.0
"""How much stiffer against bending a link is that sways than one that bends as much, where fits start."""
TWIST = 3.0
"""Stiffness against twist over that against bending, about: G J over E I, and more where little twists it."""


@dataclass(frozen=True, eq=False)
class _New:
    """A joint of the improved robot: its axis in the frame of the link, its spring, and whether it slides."""

    name: str
    way: Float[np.ndarray, "3"]
    stiffness: float
    slides: bool = False


def _places(context: Context) -> tuple[str, ...]:
    found = ((link, *along(context, link)) for link in context.links)
    return tuple(link for link, length, axis in found if length >= SHORTEST and sides(context, link, axis))


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = stiffest(context, where)
    found: tuple[Parameter, ...] = (
        positive("stiffness", "N·m/rad", k, 1.5, k / 300, k * 3e4),
        positive("damping", "N·m·s/rad", k * 3e-4, 1.5, k * 1e-7, k * 10),
        signed("position", "", 0.1, 0.03, 0.97, centre=0.5),
        signed("spread", "", 0.1, 0.02, 0.98, centre=EVEN),
    )
    if fixed(context, where) is not None:
        found = (*found, positive("shear", "", SHEAR, 2.0, 1e-4, 20.0))
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


def _joints_at(placement: Placement, hinge: int, places: Float[np.ndarray, " hinge"]) -> list[_New]:
    """Joints of a cut for bending, and for what of shear and twist sits there.

    Args:
        placement: of the effect; its place is the link.
        hinge: number of the cut.
        places: of all cuts, as parts of the length.
    """
    context, link, stiffness = placement.context, placement.where, placement["stiffness"]
    _, axis = along(context, link)
    across, found = sides(context, link, axis), []
    there = [
        (section, section.share * share)
        for section in sections(context, link, places)
        for place, share in section.cuts
        if place == places[hinge] and section.twist
    ]
    slides = [
        spring / share
        for section, spring in sliding(placement, places)
        for place, share in section.cuts
        if place == places[hinge]
    ]
    halfway = hinge == len(places) // 2
    for plane, (ratio, parts) in enumerate(planes(placement)):
        side = np.sum([share * across[number] for number, share in parts], axis=0)
        end = f"{hinge + 1}" + (f"_{plane + 1}" if len(across) > 1 else "")
        bend = ratio * stiffness / shares_of(placement, plane)[hinge]
        found.append(_New(f"{link}_bend_{end}", crossed(axis, side), bend))
        found += [_New(f"{link}_shear_{end}", side, ratio * spring, slides=True) for spring in slides]
        if halfway and placement.values.get(SWAYS[plane], 0.0) > NONE:
            swaying = sideways(placement, SWAYS[plane])
            found.append(_New(f"{link}_sway_{plane + 1}", side, swaying, slides=True))
    for section, share in there:
        end = f"_{hinge + 1}" if len(section.cuts) > 1 else ""
        found.append(_New(f"{link}_twist{end}", axis, placement["twist_ratio"] * stiffness / share))
    return found


def _extend(draft: Draft, placement: Placement) -> None:
    context, link = placement.context, placement.where
    length, axis = along(context, link)
    time, names = placement["damping"] / placement["stiffness"], [link]
    places, _ = bending(placement)
    if any(placement.values.get(name, 0.0) > SEEN for name in SWAYS):
        draft.notes.append(f"the files have the sway of {link} as a slide halfway along it")
    if any(len(section.cuts) > 1 for section in sections(context, link, places)):
        draft.notes.append(f"in the files {link} twists and shears in each place by itself, not evenly")
    for hinge, place in enumerate(places.tolist()):
        made = [replace(one, name=draft.fresh(one.name)) for one in _joints_at(placement, hinge, places)]
        slides = [one.name for one in made if one.slides]
        ways = {one.name: one.way for one in made}
        names.append(draft.hinge(link, place * length * axis, axis, ways, slides))
        for one in made:
            draft.flexible(one.name, one.stiffness, time * one.stiffness)
    card = bodies_of(placement.context.robot.urdf)[link]
    whole = scaled(card, link, placement.values)
    grown = whole.mass / card.mass
    parts, thin = cut(placement, card, places)
    for number, part in enumerate(parts):
        inertia = grown * part.body.inertia + part.turning * (whole.inertia - grown * thin)
        shift = places[number - 1] * length * axis if number else np.zeros(3)
        draft.set_body(names[number], Body(grown * part.body.mass, part.body.centre - shift, inertia))


def _wider_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    space = context.normal is None
    narrow = [one for one in _parameters(context, where) if one.name != "ratio"]
    found = (
        *narrow,
        signed(TUBE, "", 0.3, 0.0, 1.0, centre=1.0),
        signed(SPREAD, "", 0.3, 0.0, 1.0, centre=1.0),
        *((positive("ratio", "", 1.0, 0.8, 1e-3, 1e3),) if space else ()),
        *(positive(name, "", HARDLY, 3.0, 1e-7, 1e6) for name in SWAYS[: 1 + space]),
    )
    if fixed(context, where) is None:
        return found
    return (
        *found,
        signed(SHIFT, "", 0.3, -0.8, 0.8),
        positive(CRACK, "", 0.03, 1.5, 1e-4, 30.0),
        signed(CRACK_AT, "", 0.25, 0.03, 0.97, centre=0.4),
        positive(SLIDE, "", 1e-4, 3.0, 1e-6, 100.0),
    )


def _wider_starts(context: Context, where: str, values: Mapping[str, float]) -> Sequence[Mapping[str, float]]:
    bodies, swaying = ((1.0, 1.0), (0.5, 0.8), (0.3, 0.2)), _that_sway(values)
    found = [{**values, TUBE: tube, SPREAD: spread} for tube, spread in bodies]
    moved = [{**values, SHIFT: shift, "spread": 0.1} for shift in (-0.5, 0.5)]
    cracked = [{**values, CRACK: 0.7, CRACK_AT: place, "spread": EVEN} for place in (0.2, 0.5, 0.8)]
    if fixed(context, where) is None:
        return [*found, *swaying]
    opened = [{**values, CRACK: 10.0, CRACK_AT: place, "spread": EVEN, SLIDE: 3.0} for place in OPENINGS]
    return [*found[:2], *moved, *cracked, *opened, *swaying]


def _that_sway(values: Mapping[str, float]) -> list[dict[str, float]]:
    """As far off under a load at the end, and upright: in the first plane; in space the second, or both."""
    place, spread = values["position"], values["spread"]
    size = 12 * (place**2 + spread**2 * place * (1 - place))
    first = {**values, **{name: STIFFER * values[name] for name in ("stiffness", "damping")}}
    first[SWAYS[0]] = STIFFER * size
    if "ratio" not in values:
        return [first]
    ratio = values["ratio"]
    return [
        {**first, "ratio": ratio / STIFFER},
        {**values, "ratio": ratio * STIFFER, SWAYS[1]: size / ratio},
        {**first, SWAYS[1]: STIFFER * size / ratio},
    ]


NARROW = Effect(
    name="link_flexibility",
    says="the link bends",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    shape=lambda assembly, placement: add_hinges(assembly, placement, bending(placement)[0]),
    geometry=BENDS,
    held=lambda context, where: BENDS if fixed(context, where) is not None else (),
    bodies=lambda assembly, placement, bodies, link: cut_body(
        assembly, placement, bodies, link, bending(placement)[0]
    ),
    act=act,
    extend=_extend,
)
WIDE = replace(NARROW, parameters=_wider_parameters, geometry=(*BENDS, TUBE, SPREAD, SHIFT))
EFFECT = replace(NARROW, next_level=Level(WIDE, _wider_starts))
