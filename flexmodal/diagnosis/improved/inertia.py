"""Inertias that a body can have."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

Vector = Float[np.ndarray, "3"]

_ROUNDING = 1e-9


def nearest_inertia(
    inertia: Float[np.ndarray, "3 3"], normal: Vector | None
) -> tuple[Float[np.ndarray, "3 3"], bool]:
    """An inertia that a body can have, and whether it differs from the one given where it matters.

    A fit changes moments of inertia by factors and may end where one exceeds the sum of the two others. The
    second moments of the mass, tr(I)/2 − I, are what has to be positive: negative ones become 0. In a planar
    chain only the moment about the normal of the plane counts; it is kept, if it is not negative.

    Args:
        inertia: about the mass centre [kg·m²].
        normal: of the plane of a planar chain, in the frame of the link; none for a spatial one.
    """
    spread = np.trace(inertia) / 2 * np.eye(3) - inertia
    values, vectors = np.linalg.eigh((spread + spread.T) / 2)
    size = float(np.abs(values).max())
    if values[0] >= -_ROUNDING * size:
        return inertia, False
    if normal is not None:
        about = max(float(normal @ inertia @ normal), 0.0)
        return about / 2 * (np.eye(3) + np.outer(normal, normal)), bool(normal @ inertia @ normal < 0)
    kept = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.trace(kept) * np.eye(3) - kept, True
