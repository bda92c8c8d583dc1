"""Mass matrices that no structure can have, and the nearest that one can."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

ROUNDING = 1e-10
"""Of eigenvalues, over the largest: what is not farther below 0 is none."""


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
    """Masses with a negative inertia in no direction: it becomes as large a positive one.

    A part of a link that bends may have a small negative one, where the inertia of the link is less than its
    mass would have if it were spread along it. Far below the poles that come of it receptances are the same
    either way, but motion in time has no end where it is negative. Coordinates without any mass stay so.

    Args:
        mass: of several structures, symmetric; the same object where nothing is negative.
    """
    if is_definite(mass):
        return mass
    values, vectors = np.linalg.eigh(mass)
    if (values >= -ROUNDING * values[:, -1:]).all():
        return mass
    return np.asarray((vectors * np.abs(values)[:, None]) @ np.swapaxes(vectors, 1, 2))
