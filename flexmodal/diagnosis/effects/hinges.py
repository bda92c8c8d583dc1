"""Where the hinges of a link that bends sit, and how they share its compliance.

A link that is looked at or struck between its ends is cut there: two of Gauss's points in each piece, and at
either end of the link one more, where a flange gives, are exact for what slow motion shows at the cuts, as
the moment of a load is linear between them. One with modes of its own in the band has three to five and those
two, as the bars between them then move as the beam does in its first modes. Coarse looks have one in each
piece beside those at the ends. Their compliance goes with exp(r x + q x²) and has any mean and spread that it
can have.
"""

from __future__ import annotations

from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from scipy.special import roots_jacobi

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import along
from flexmodal.structure.arm import beyond, bodies_of

MANY_IN_SPACE, MANY_IN_PLANE = 5, 7
"""Hinges of a link whose own modes lie in the band; in space each bends in two planes and is half of the
coordinates."""
NEAR = 0.06
"""A place this near to an end of a link, or to another place, makes no piece of its own."""
MOST_INSIDE = 2
"""Places between the ends that make pieces."""
INSET = 0.02
"""How far from its ends the last hinges of a link are, over its length."""
EVEN = 3**-0.5
"""Spread of an even beam."""
SOFT = 1 / 8
"""The stiffness at which that is asked, over that of the stiffest joint below."""
LEAST = 1e-6
"""Share of a hinge at least: what is stiffer still leaves no digits for anything else."""
LONGEST = 2.0
"""Longest step in the exponent of the shares."""
RIDGE = 1e-12
"""Added to the second derivatives, which vanish where one hinge takes nearly everything."""


def stiffest(context: Context, link: str) -> float:
    """Stiffness of the stiffest joint between the base and a link [N·m/rad].

    Args:
        context: of the diagnosis.
        link: its name.
    """
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


@cache
def quadrature(
    start: float, end: float, count: int
) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    """Points of a piece and their weights, one of them near each end of the link that it reaches.

    The others are Gauss's for what is left of the weight (Radau's and Lobatto's formulas: Abramowitz and
    Stegun, Handbook of Mathematical Functions, 25.4.31 and 32); the weights then follow from the moments.

    Args:
        start: of the piece, as a part of the length of the link.
        end: likewise.
        count: of points.
    """
    first, last = start <= 0.0, end >= 1.0
    free, _ = roots_jacobi(count - first - last, float(last), float(first))
    place = start + (end - start) * (1 + free) / 2
    place = np.concatenate([[INSET] * first, place, [1 - INSET] * last])
    moments = np.zeros(count)
    moments[0] = end - start
    inside = 2 * (place - start) / (end - start) - 1
    return place, np.linalg.solve(np.polynomial.legendre.legvander(inside, count - 1).T, moments)


@lru_cache(maxsize=128)
def has_modes(context: Context, where: str) -> bool:
    """Whether a link may have modes of its own in the band.

    A beam of stiffness k = EI/L, mass m and rotary inertia J, held at both ends, has its first modes at
    22.4 √(k/m)/L (bending) and π √(k/J) (turning) [rad/s]: modes of the link itself, whatever it carries.
    Of modes alone nobody lists those.

    Args:
        context: of the diagnosis.
        where: name of the link.
    """
    body, length = bodies_of(context.robot.urdf)[where], along(context, where)[0]
    k, turning = SOFT * stiffest(context, where), float(np.linalg.eigvalsh(body.inertia)[-1])
    first = min(22.4 * np.sqrt(k / body.mass) / length, np.pi * np.sqrt(k / max(turning, 1e-12)))
    return bool(context.every_line and first < 2 * np.pi * context.band[1])


@lru_cache(maxsize=128)
def pieces(context: Context, where: str) -> tuple[float, ...]:
    """Ends of the pieces of a link, as parts of its length: 0, where it is looked at or struck, 1.

    Args:
        context: of the diagnosis.
        where: name of the link.
    """
    length, axis = along(context, where)
    inside = [0.0]
    for number in sorted({number for number, _ in (*context.responses, *context.references)}):
        point = context.point(number)
        place = float(np.array(point.xyz) @ axis) / length
        near = min(abs(place - other) for other in (*inside, 1.0))
        if point.link == where and 0 < place < 1 and near > NEAR and len(inside) <= MOST_INSIDE:
            inside.append(place)
    return (*sorted(inside), 1.0)


def seen_inside(context: Context, where: str) -> bool:
    """Whether a link is looked at or struck between its ends, so that how it moves there counts.

    Args:
        context: of the diagnosis.
        where: name of the link.
    """
    return len(pieces(context, where)) > 2


@lru_cache(maxsize=128)
def fixed(
    context: Context, where: str
) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]] | None:
    """Where the hinges sit, as parts of the length, and their weights; None where two are enough anywhere.

    Args:
        context: of the diagnosis.
        where: name of the link.
    """
    ends, modes = pieces(context, where), has_modes(context, where)
    if len(ends) == 2 and not modes:
        return None
    whole = 0 if not modes else MANY_IN_SPACE if context.normal is None else MANY_IN_PLANE
    found = []
    for start, end in pairwise(ends):
        at_ends = (start <= 0.0) + (end >= 1.0)
        fine = max(2 + at_ends, round(whole * (end - start)))
        found.append(quadrature(start, end, 1 + at_ends if context.is_rough else fine))
    places, weights = zip(*found, strict=True)
    return np.concatenate(places), np.concatenate(weights)


def shifted(context: Context, where: str, shift: float) -> Float[np.ndarray, " hinge"]:
    """Where the hinges sit when those of each piece are moved from its ends towards one of them.

    Args:
        context: of the diagnosis.
        where: name of a link whose hinges are fixed.
        shift: by how much, over four times the length of the piece, in its middle; between -1 and 1 their
            order stays.

    Raises:
        LookupError: its hinges are not fixed.
    """
    place, _ = _known(context, where)
    ends = np.array(pieces(context, where))
    piece = np.searchsorted(ends[1:-1], place)
    start, size = ends[piece], np.diff(ends)[piece]
    part = (place - start) / size
    return np.asarray(start + size * (part + shift * part * (1 - part)))


def shares(
    mean: float, spread: float, place: Float[np.ndarray, " hinge"], weight: Float[np.ndarray, " hinge"]
) -> Float[np.ndarray, " hinge"]:
    """Parts of the compliance at given places with this mean and spread, or the nearest they can have.

    They go with exp(r x + q x²) times the weights; Newton's method finds r and q, where the logarithm of the
    sum less r times the mean and q times the mean of squares is least.

    Args:
        mean: of the places, as a part of the length.
        spread: their standard deviation over √(mean (1 − mean)), 0 to 1.
        place: of the hinges, in order.
        weight: of each where the compliance is even.
    """
    mean = float(np.clip(mean, place[0] + 0.01, place[-1] - 0.01))
    after = int(np.clip(np.searchsorted(place, mean), 1, len(place) - 1))
    least = (mean - place[after - 1]) * (place[after] - mean)
    most = (mean - place[0]) * (place[-1] - mean)
    variance = float(np.clip(spread**2 * mean * (1 - mean), 1.1 * least + 1e-4, 0.95 * most))
    one, other = place - mean, (place - mean) ** 2 - variance
    largest = float(np.abs(one).max()), float(np.abs(other).max())
    powers = np.stack([one, other, one**2, one * other, other**2])
    r = q = 0.0
    for _ in range(200):
        exponent = r * one + q * other
        part = weight * np.exp(exponent - exponent.max())
        part /= part.sum()
        a, b, aa, ab, bb = (powers @ part).tolist()
        if max(abs(a), abs(b)) < 1e-14:
            break
        aa, ab, bb = aa - a * a + RIDGE * largest[0] ** 2, ab - a * b, bb - b * b + RIDGE * largest[1] ** 2
        size = max(aa * bb - ab * ab, RIDGE * aa * bb)
        along = (bb * a - ab * b) / size, (aa * b - ab * a) / size
        longest = max(abs(along[0]) * largest[0], abs(along[1]) * largest[1])
        r, q = (rate - step / max(1.0, longest / LONGEST) for rate, step in zip((r, q), along, strict=True))
    return np.maximum(part, LEAST)


def inner(context: Context, where: str) -> tuple[np.ndarray, Float[np.ndarray, " hinge"]]:
    """Numbers of the fixed hinges but those at the ends of the link, whose weights their neighbours have.

    Args:
        context: of the diagnosis.
        where: name of a link with such hinges.

    Raises:
        LookupError: the link has none.
    """
    place, weight = _known(context, where)
    (inside,) = np.nonzero((place > INSET) & (place < 1 - INSET))
    nearest = np.abs(place[:, None] - place[inside]).argmin(axis=1)
    return inside, np.bincount(nearest, weights=weight)


def _known(context: Context, where: str) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
    known = fixed(context, where)
    if known is None:
        raise LookupError(where)
    return known
