"""Terms of a structure that act between two motions."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

Size = float | Float[np.ndarray, " posture"]
"""A number, the same in every posture or one for each."""


def scaled(matrix: Float[np.ndarray, "... dof dof"], size: Size) -> Float[np.ndarray, "*posture dof dof"]:
    """A matrix times a number, or times one for each posture.

    Args:
        matrix: the same in every posture, or one for each.
        size: the number.
    """
    return np.asarray(np.asarray(size)[..., None, None] * matrix)


def rank_one(one: np.ndarray, other: np.ndarray, size: Size) -> Float[np.ndarray, "*posture dof dof"]:
    """What a mass, spring or damper of some size has at [i, j] between two rows.

    Args:
        one: [*posture dof] over the coordinates.
        other: likewise.
        size: of the mass, spring or damper.
    """
    return scaled(one[..., :, None] * other[..., None, :], size)
