"""How the body of a link that bends is shared out between its hinges.

As much of its mass as its centre and its inertia allow is spread evenly along the link, as of a tube; the
rest is a lump beside it, and what inertia both lack is spread along the link again. Mass, mass centre and
inertia of the whole link stay what they were. A wider law has less in the tube, and that inertia where the
mass is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.structure.arm import Body, crossed

TUBE, SPREAD = "tube", "turning_spread"
"""Parameters of the wider law: mass of the tube over what it can have, and how much of the lacking inertia is
spread evenly along the link instead of where the mass is."""
LUMP = 0.1
"""Half of the length of a lump, over the link's, if its inertia allows that."""
SOME = 0.05
"""Part of the mass that is spread about the mass centre, so that nothing between two hinges is without."""
STEPS = 12
"""Halvings in the search for the heaviest tube."""
MOST = 1 - 1e-3
"""Share of a tube at most, as there is a lump."""


@dataclass(frozen=True, eq=False)
class Part:
    """What lies between two hinges."""

    section: Float[np.ndarray, "3"]
    """A place there on the axis of the link, in its frame [m]."""
    body: Body
    """Its mass, as thin rods along the axis."""
    turning: float
    """Its share of the inertia that the rods lack."""


@dataclass(frozen=True, eq=False)
class _Rod:
    """An even thin rod along the link."""

    mass: float
    start: float
    """Where it begins, and ends [m]."""
    end: float
    aside: Float[np.ndarray, "3"]
    """Off the axis [m]."""

    def between(self, low: float, high: float) -> _Rod:
        """What of it lies between two cuts [m]."""
        a, b = min(max(low, self.start), self.end), min(max(high, self.start), self.end)
        return _Rod(self.mass * (b - a) / (self.end - self.start), a, b, self.aside)


def cut(
    placement: Placement, body: Body, places: Float[np.ndarray, " hinge"]
) -> tuple[list[Part], Float[np.ndarray, "3 3"]]:
    """Parts of a link between its hinges, and the inertia of all their rods about its mass centre.

    Between two hinges in one place there is no mass.

    Args:
        placement: of the effect; its place is the link.
        body: of the whole link.
        places: of the hinges, as parts of the length.
    """
    end, axis = along(placement.context, placement.where)
    ends = np.concatenate([[0.0], places, [1.0]])
    edges = np.concatenate([[-np.inf], end * places, [np.inf]])
    rods, about_centre = _tube_and_lump(placement, body), _about_centre(placement, body)
    spread = placement.values.get(SPREAD, 1.0)
    parts, whole = [], np.zeros((3, 3))
    for number, (low, high) in enumerate(pairwise(edges.tolist())):
        start, stop = ends[number : number + 2].tolist()
        some = [rod.between(low, high) for rod in rods] + [
            about_centre.between(*_of(about_centre, start, stop))
        ]
        mass = sum(rod.mass for rod in some)
        middle = (start + stop) / 2 * end * axis
        centre = sum((rod.mass / mass * _middle(rod, axis) for rod in some), np.zeros(3)) if mass else middle
        inertia = _inertia(some, axis, centre)
        whole += inertia + mass * _about(centre - body.centre)
        turning = spread * (stop - start) + (1 - spread) * mass / body.mass
        parts.append(Part(middle, Body(mass, centre, inertia), turning))
    return parts, whole


def _of(rod: _Rod, start: float, stop: float) -> tuple[float, float]:
    """Parts of the length of a rod [m]."""
    return rod.start + start * (rod.end - rod.start), rod.start + stop * (rod.end - rod.start)


def _middle(rod: _Rod, axis: np.ndarray) -> Float[np.ndarray, "3"]:
    return (rod.start + rod.end) / 2 * axis + rod.aside


def _inertia(rods: Sequence[_Rod], axis: np.ndarray, centre: np.ndarray) -> Float[np.ndarray, "3 3"]:
    """About a point."""
    thin = np.eye(3) - np.outer(axis, axis)
    own = sum(rod.mass * (rod.end - rod.start) ** 2 for rod in rods) / 12 * thin
    return sum((rod.mass * _about(_middle(rod, axis) - centre) for rod in rods), own)


def _about(lever: np.ndarray) -> Float[np.ndarray, "3 3"]:
    return float(lever @ lever) * np.eye(3) - np.outer(lever, lever)


def _tube_and_lump(placement: Placement, body: Body) -> list[_Rod]:
    """With mass and mass centre of the body, less what is spread about that."""
    least, most = 0.0, MOST
    if not _has_room(placement, body, most):
        for _ in range(STEPS):
            middle = (least + most) / 2
            least, most = (middle, most) if _has_room(placement, body, middle) else (least, middle)
        most = least
    return _divided(placement, body, placement.values.get(TUBE, 1.0) * most)


def _divided(placement: Placement, body: Body, share: float, half: float = LUMP) -> list[_Rod]:
    end, axis = along(placement.context, placement.where)
    mass, centre = (1 - SOME) * body.mass, float(body.centre @ axis)
    at = (centre - share * end / 2) / (1 - share)
    aside = (body.centre - centre * axis) / (1 - share)
    lump = (1 - share) * mass
    tube = _Rod(share * mass, 0.0, end, np.zeros(3))
    left = _smallest(placement, body, [tube, _Rod(lump, at, at, aside)]) if half else 0.0
    wide = min(half * end, float(np.sqrt(3 * max(left, 0.0) / lump)))
    wide = max(wide, 1e-6 * end)
    return [tube, _Rod(lump, at - wide, at + wide, aside)]


def _has_room(placement: Placement, body: Body, share: float) -> bool:
    """Whether so heavy a tube leaves a lump on the link, with an inertia that a body can have."""
    end, axis = along(placement.context, placement.where)
    rods = _divided(placement, body, share, half=0.0)
    at = float(_middle(rods[1], axis) @ axis)
    return 0 <= at <= end and _smallest(placement, body, rods) >= 0


def _smallest(placement: Placement, body: Body, rods: Sequence[_Rod]) -> float:
    """Smallest second moment of mass that the body has beside rods, of those that count [kg·m²]."""
    _, axis = along(placement.context, placement.where)
    left = (1 - SOME) * body.inertia - _inertia(rods, axis, body.centre)
    if placement.context.normal is None:
        return float(np.linalg.eigvalsh(np.trace(left) / 2 * np.eye(3) - left)[0])
    (side,) = sides(placement.context, placement.where, axis)
    turn = crossed(axis, side)
    return float(turn @ left @ turn)


def _about_centre(placement: Placement, body: Body) -> _Rod:
    """A rod about the mass centre, as long as the link or as the inertia of the body allows beside a disc."""
    end, axis = along(placement.context, placement.where)
    turns = np.array([crossed(axis, side) for side in sides(placement.context, placement.where, axis)])
    least = float(np.linalg.eigvalsh(turns @ body.inertia @ turns.T)[0])
    disc = 0.0 if placement.context.normal is not None else float(axis @ body.inertia @ axis) / 2
    length = max(min(end, float(np.sqrt(12 * max(least - disc, 0.0) / body.mass))), 1e-6 * end)
    centre = float(body.centre @ axis)
    return _Rod(SOME * body.mass, centre - length / 2, centre + length / 2, body.centre - centre * axis)
