"""Springs and dampers of a link that bends, twists, shears and sways: see `link_flexibility`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Placement, along
from flexmodal.diagnosis.effects.link_motion import SWAYS, Section, bending, names_of, sections, turned_by
from flexmodal.structure.assembly import Assembly

CRACK, CRACK_AT, SLIDE = "crack", "crack_at", "crack_slide"
"""Compliance of a crack in the first plane, over that of the link there without it, and its place; and how
what lies beyond it slides, as beside an opening, by what that is to the compliance of the link."""
_Spring = tuple[list[tuple[str, float]], float]
"""What of each coordinate it feels, and its stiffness."""


def planes(placement: Placement) -> list[tuple[float, list[tuple[int, float]]]]:
    """Stiffness of each principal plane over the first's, and its shares in those of the coordinates."""
    if placement.context.normal is not None:
        return [(1.0, [(0, 1.0)])]
    cosine, sine = np.cos(placement["angle"]), np.sin(placement["angle"])
    return [(1.0, [(0, cosine), (1, sine)]), (placement["ratio"], [(0, -sine), (1, cosine)])]


def act(assembly: Assembly, placement: Placement) -> None:
    """Put springs and dampers in.

    Args:
        assembly: with the coordinates of the hinges.
        placement: of the effect; its place is the link.
    """
    context, where = placement.context, placement.where
    time, principal = placement["damping"] / placement["stiffness"], planes(placement)
    names = names_of(context, where, len(bending(placement)[0]))
    found: list[_Spring] = []
    for number, (ratio, parts) in enumerate(principal):
        springs = ratio * placement["stiffness"] / shares_of(placement, number)
        for hinge, spring in enumerate(springs.tolist()):
            own = names[len(principal) * hinge :]
            found.append(([(own[plane], share) for plane, share in parts], spring))
    for section in sections(context, where, bending(placement)[0]):
        twist = [([(name, 1.0)], placement["twist_ratio"] * placement["stiffness"]) for name in section.twist]
        found += [(pulled, spring / section.share) for pulled, spring in twist]
    for section, slide in sliding(placement, bending(placement)[0]):
        found += [
            ([(section.shears[plane], share) for plane, share in parts], ratio * slide)
            for ratio, parts in principal
        ]
    if SWAYS[0] in placement.values:
        found += [_softened(placement, found, plane) for plane in range(len(principal))]
    rows = np.zeros((len(found), len(assembly.coordinates)))
    for number, (pulled, _) in enumerate(found):
        for name, share in pulled:
            rows[number, assembly.number(name)] = share
    stiffness = np.array([each for _, each in found])
    assembly.add_together("stiffness", rows, stiffness)
    assembly.add_together("damping", rows, time * stiffness)


def _softened(placement: Placement, springs: Sequence[_Spring], plane: int) -> _Spring:
    """What sway takes from a plane's springs k against bending: hinges turn by t s besides, s on a spring κ.

    So their compliance is diag(1/k) + t tᵀ/κ, and by Sherman and Morrison their stiffness less by a spring
    1/(κ + Σ k t²) on Σ k t θ. As a coordinate s would move nothing that hinges do not, and have no inertia.

    Args:
        placement: of the effect.
        springs: against bending, hinge by hinge and plane by plane, and others behind them.
        plane: which.
    """
    turns = turned_by(placement, bending(placement)[0])
    bends = springs[plane * len(turns) : (plane + 1) * len(turns)]
    pulls = turns * np.array([spring for _, spring in bends])
    row = [(name, pull * part) for pull, (parts, _) in zip(pulls, bends, strict=True) for name, part in parts]
    return row, -1 / (sideways(placement, SWAYS[plane]) + float(turns @ pulls))


def shares_of(placement: Placement, plane: int) -> Float[np.ndarray, " hinge"]:
    """Of a plane's compliance, of each hinge; by the wider law with a crack in the first plane.

    That is shared by the two hinges beside it, so that it sits there on average.

    Args:
        placement: of the effect.
        plane: which.
    """
    places, shares = bending(placement)
    if plane or CRACK not in placement.values:
        return shares
    near = np.array([np.interp(placement[CRACK_AT], places, each) for each in np.eye(len(places))])
    return np.asarray((shares + placement[CRACK] * near) / (1 + placement[CRACK]))


def sliding(placement: Placement, places: Float[np.ndarray, " hinge"]) -> list[tuple[Section, float]]:
    """Sections that shear and their springs in the first plane, by the wider law softer beside a crack [N/m].

    Args:
        placement: of the effect.
        places: of its hinges, as parts of the length.
    """
    found = [one for one in sections(placement.context, placement.where, places) if one.shears]
    if not found:
        return []
    gives = placement["shear"] * np.array([one.share for one in found])
    if SLIDE in placement.values:
        middles = [sum(place * part for place, part in one.cuts) for one in found]
        gives += placement[SLIDE] * np.array(
            [np.interp(placement[CRACK_AT], middles, each) for each in np.eye(len(found))]
        )
    length, _ = along(placement.context, placement.where)
    springs = 12 * placement["stiffness"] / (gives * length**2)
    return list(zip(found, springs.tolist(), strict=True))


def sideways(placement: Placement, name: str) -> float:
    """Stiffness of the whole link against a shift of its end as it sways [N/m].

    Args:
        placement: of the effect.
        name: of the parameter: what the shift adds to the compliance, in parts of that against bending.
    """
    length, _ = along(placement.context, placement.where)
    return 12 * placement["stiffness"] / (placement[name] * length**2)
