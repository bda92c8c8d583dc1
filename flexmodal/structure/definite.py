"""Mass matrices that no structure can have, and the nearest that one can."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

LEAST = 1e-12
"""Inertia at least of a direction that had none or less, over the largest."""


def is_definite(mass: Float[np.ndarray, "*system dof dof"]) -> bool:
    """Whether masses are positive definite; what rings up without that has no digits, or is no structure.

    Args:
        mass: of one structure or of several.
    """
    try:
        np.linalg.cholesky(mass)
    except np.linalg.LinAlgError:
        return False
    return True


def with_inertia(mass: Float[np.ndarray, "system dof dof"]) -> Float[np.ndarray, "system dof dof"]:
    """Masses with an inertia in every direction: a negative one becomes as large a positive one.

    A part of a link that bends may have a small negative one, where the inertia of the link is less than its
    mass would have if it were spread along it. Far below the poles that come of it receptances are the same
    either way, but motion in time has no end where it is negative.

    Args:
        mass: of several structures, symmetric; the same object where nothing is negative.
    """
    if is_definite(mass):
        return mass
    values, vectors = np.linalg.eigh(mass)
    most = np.max(values, axis=-1, keepdims=True)
    made = np.where(values > 0, values, np.maximum(np.abs(values), LEAST * most))
    return np.asarray((vectors * made[:, None]) @ np.swapaxes(vectors, 1, 2))
