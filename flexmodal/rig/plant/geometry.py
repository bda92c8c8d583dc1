"""Small vectors: cross products as matrices, rotations, directions across a link; a cuboid."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

_SMALL = 1e-12


def cross_matrix(vector: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """The matrix that multiplies from the left as `vector ×` does."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turn(axis: Float[np.ndarray, "3"], angle: float) -> Float[np.ndarray, "3 3"]:
    """Rotation about a direction, by Rodrigues' formula; `axis` of any length above 0, `angle` [rad].

    Args:
        axis: of any length above 0.
        angle: [rad].
    """
    k = cross_matrix(np.asarray(axis) / np.linalg.norm(axis))
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def part_of_turn(whole: Float[np.ndarray, "3 3"], part: float) -> Float[np.ndarray, "3 3"]:
    """A rotation about the same axis by a part of the angle.

    Args:
        whole: a rotation by half a turn at most.
        part: of its angle; below 0 the other way round.
    """
    from scipy.spatial.transform import Rotation

    return np.asarray((Rotation.from_matrix(whole) ** part).as_matrix())


def across(
    axis: Float[np.ndarray, "3"], normal: Float[np.ndarray, "3"] | None
) -> tuple[Float[np.ndarray, "3"], ...]:
    """Unit vectors across `axis`: the one in the plane of a planar chain, or two of a spatial one.

    None where the link of a planar chain stands across its plane.

    Args:
        axis: unit vector along the link.
        normal: unit normal of the plane the chain moves in; None for a spatial chain.
    """
    if normal is not None:
        side = np.cross(normal, axis)
        if np.linalg.norm(side) < _SMALL:
            return ()
        return (side / np.linalg.norm(side),)
    # rounded, or an axis that was turned there and back would choose by its last digits, in each posture anew
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.round(np.abs(axis), 9)))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def cuboid(mass: float, sizes: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """Inertia of an even cuboid about its centre, along its edges [kg·m²].

    Args:
        mass: [kg].
        sizes: lengths of its edges [m].
    """
    return np.asarray(mass / 12 * (sizes @ sizes * np.eye(3) - np.diag(sizes**2)))
