"""How a link moves that bends, twists, shears and sways, and how its body is shared out to its hinges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.cut_body import cut
from flexmodal.diagnosis.effects.effect import Bodies, Placement, along, sides
from flexmodal.diagnosis.effects.hinges import (
    fixed,
    has_modes,
    inner,
    pieces,
    seen_inside,
    shares,
    shifted,
)
from flexmodal.structure.arm import Body, crossed
from flexmodal.structure.assembly import Assembly

_Part = tuple[float, tuple[tuple[float, float], ...]]
"""Share of the length, and the cuts in it; see `Section`."""
SHIFT = "shift"
"""Parameter of the wider law: see `hinges.shifted`."""
SWAYS = ("sway", "second_sway")
"""Likewise, one in each plane: far ends that shift and do not tilt, see `turned_by`."""
KEPT = 64
"""Values of means and spreads whose shares are kept, and places of hinges whose sections are."""


def bending(placement: Placement) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """Where the hinges sit, as parts of the length, and their shares of the compliance."""
    shift = placement.values.get(SHIFT, 0.0)
    return shares_at(placement.context, placement.where, placement["position"], placement["spread"], shift)


@lru_cache(maxsize=KEPT)
def shares_at(
    context: Context, where: str, mean: float, spread: float, shift: float = 0.0
) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """The same by mean and spread: derivatives along other parameters ask for one pair again and again.

    Args:
        context: whose robot.
        where: the link.
        mean: of the places of the compliance, as a part of the length.
        spread: their standard deviation over √(mean (1 − mean)).
        shift: of hinges that are fixed, see `hinges.shifted`.
    """
    known = fixed(context, where)
    if known is not None:
        places = shifted(context, where, shift) if shift else known[0]
        return places, shares(mean, spread, places, known[1])
    return (
        np.array([mean * (1 - spread), mean + spread * (1 - mean)]),
        np.array([1 - mean, mean]),
    )


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a link that twists evenly, or shears evenly."""

    share: float
    """Of the length, and so of the compliance."""
    cuts: tuple[tuple[float, float], ...]
    """Where it is cut for that, as parts of the length of the link, and what of its motion each has."""
    twist: tuple[str, ...] = ()
    """Its coordinate, if it twists."""
    shears: tuple[str, ...] = ()
    """Its coordinates, one in each plane, if it shears."""


def names_of(context: Context, where: str, count: int) -> list[str]:
    """Coordinates of so many hinges, those of one place side by side.

    Args:
        context: whose robot.
        where: the link.
        count: of hinges.
    """
    planes = planes_of(context)
    return [f"{where} bend {hinge + 1}.{plane + 1}" for hinge in range(count) for plane in range(planes)]


def sections(context: Context, where: str, places: Float[np.ndarray, " hinge"]) -> tuple[Section, ...]:
    """The parts of a link that twist, in space, and those that shear, where its hinges are fixed.

    Between places where it is seen it twists evenly, and shears evenly unless it has modes of its own in the
    band: there each cut slides by itself, as what lies between the ends lags behind them.

    Args:
        context: whose robot.
        where: the link.
        places: of its hinges, as parts of the length.
    """
    return _sections(context, where, tuple(places.tolist()))


@lru_cache(maxsize=KEPT)
def _sections(context: Context, where: str, along_it: tuple[float, ...]) -> tuple[Section, ...]:
    places = np.array(along_it)
    twisting = _twisting(context, where, places)
    return (*(twisting if planes_of(context) > 1 else ()), *_shearing(context, where, places))


def _twisting(context: Context, where: str, places: Float[np.ndarray, " hinge"]) -> list[Section]:
    """One at one place where nobody sees it between its ends."""
    if not seen_inside(context, where):
        middle = float(places[len(places) // 2])
        return [Section(1.0, ((middle, 1.0),), (f"{where} twist",))]
    parts = enumerate(_pieces(context, where, places), start=1)
    return [Section(share, cuts, (f"{where} twist {number}",)) for number, (share, cuts) in parts]


def _shearing(context: Context, where: str, places: Float[np.ndarray, " hinge"]) -> list[Section]:
    parts = _pieces(context, where, places)
    if has_modes(context, where):
        inside, weights = inner(context, where)
        each = zip(places[inside].tolist(), weights.tolist(), strict=True)
        parts = [(share, ((place, 1.0),)) for place, share in each]
    planes = range(1, planes_of(context) + 1)
    return [
        Section(share, cuts, shears=tuple(f"{where} shear {number}.{plane}" for plane in planes))
        for number, (share, cuts) in enumerate(parts, start=1)
    ]


def _pieces(context: Context, where: str, places: Float[np.ndarray, " hinge"]) -> Sequence[_Part]:
    """Parts of the length between places where a link is seen; the cuts in each, and what of it they have."""
    known, found = fixed(context, where), []
    if known is None:
        return []
    for start, end in pairwise(pieces(context, where)):
        here = (known[0] > start) & (known[0] < end)
        parts = (known[1][here] / (end - start)).tolist()
        found.append((end - start, tuple(zip(places[here].tolist(), parts, strict=True))))
    return found


def turned_by(placement: Placement, places: Float[np.ndarray, " hinge"]) -> Float[np.ndarray, " hinge"]:
    """How far each hinge turns as the link sways, bent to one side and back, over the shift of its end [1/m].

    As each of two plates does that only their ends tie, and a column of a frame: where ξ is the part of the
    length its end stays upright and it is shifted by 3 ξ² − 2 ξ³ of that, so that hinges of weights w turn by
    w (6 − 12 ξ) over the length (Weaver and Gere, Matrix Analysis of Framed Structures, 3rd ed., 1990).

    Args:
        placement: of the effect; its place is the link.
        places: of its hinges, as parts of the length.
    """
    known = fixed(placement.context, placement.where)
    weights = np.full(len(places), 1 / len(places)) if known is None else known[1]
    turns = weights * (0.5 - places)
    turns -= weights * turns.sum()  # the end stays upright wherever the hinges sit
    return turns / (turns @ (1 - places)) / along(placement.context, placement.where)[0]


def planes_of(context: Context) -> int:
    """In how many planes a link bends."""
    return 1 if context.normal is not None else 2


def add_hinges(assembly: Assembly, placement: Placement, places: Float[np.ndarray, " hinge"]) -> None:
    """Let a link bend at these parts of its length, and in space twist; shear where that is seen.

    Args:
        assembly: the robot, its motions not complete yet.
        placement: of the effect; its place is the link.
        places: of the hinges, as parts of the length.
    """
    context, where = placement.context, placement.where
    length, axis = along(context, where)
    axes, across = assembly.axes(where), sides(context, where, axis)
    parts = sections(context, where, places)
    own = [name for part in parts for name in (*part.twist, *part.shears)]
    assembly.add_coordinates([*names_of(context, where, len(places)), *own])

    def cut(name: str, place: float, way: np.ndarray, *, turns: bool) -> None:
        moved, column = axes @ way, assembly.number(name)
        motion = np.concatenate([np.zeros_like(moved), moved] if turns else [moved, np.zeros_like(moved)], -1)
        assembly.hinge(where, place * length * axis, axis, column, motion)

    names = iter(names_of(context, where, len(places)))
    for place in places.tolist():
        for side in across:
            cut(next(names), place, crossed(axis, side), turns=True)
    for part in parts:
        for place, share in part.cuts:
            for name in part.twist:
                cut(name, place, share * axis, turns=True)
            for name, side in zip(part.shears, across, strict=False):
                cut(name, place, share * side, turns=False)


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
    parts, whole = cut(placement, body, places)
    for part in parts:
        place, share = part.section, part.turning
        turning = Body(0.0, place, share * body.inertia)
        assembly.add_body(link, part.body, section=place, **tags)
        assembly.add_body(link, turning, section=place, inertia=f"inertia.{link}", **tags)
        assembly.add_body(link, Body(0.0, place, -share * whole), section=place, **tags)
    return True
