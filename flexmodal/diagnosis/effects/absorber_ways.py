"""The directions in which something that is attached to a link gives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import along, sides
from flexmodal.structure.arm import crossed


def ways_of(angles: Float[np.ndarray, " angle"]) -> Float[np.ndarray, "way axis"]:
    """Directions in which an absorber gives, and the one in which it does not.

    Args:
        angles: out of the plane across the link; in space also about the link, and about the first direction.

    Returns:
        Along the link and across it; the first two give.
    """
    cosine, sine = np.cos(angles[0]), np.sin(angles[0])
    if len(angles) == 1:
        return np.array([[sine, cosine], [cosine, -sine]])
    side = np.array([0.0, np.cos(angles[1]), np.sin(angles[1])])
    axis = np.array([1.0, 0.0, 0.0])
    first, second = cosine * side + sine * axis, cosine * axis - sine * side
    third = np.cross(first, second)
    cosine, sine = np.cos(angles[2]), np.sin(angles[2])
    return np.array([first, cosine * second + sine * third, cosine * third - sine * second])


def directions(context: Context, where: str, values: Mapping[str, float]) -> tuple[np.ndarray, ...]:
    """The directions in which it gives and, in space, the one in which it does not, in the frame of the link.

    The first is across the link, turned about it and out of that; the second is rolled about the first.

    Args:
        context: of the diagnosis.
        where: the link.
        values: of the effect: angle, in space turn and roll [rad].
    """
    _, axis = along(context, where)
    across = sides(context, where, axis)
    names = ("angle",) if len(across) == 1 else ("angle", "turn", "roll")
    found = ways_of(np.array([values[name] for name in names])) @ np.array([axis, *across])
    return (*found, crossed(*found)) if len(across) == 1 else tuple(found)
