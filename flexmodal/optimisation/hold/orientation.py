"""How the held frame is turned: wholly, or one of its axes along a direction and free to turn about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

_SMALL = 1e-4
"""Angle below which the series of an angle function is used [rad]."""


@dataclass(frozen=True, eq=False)
class FixedOrientation:
    """All three axes of the frame held; the error is a rotation vector in world axes [rad]."""

    rotation: Float[np.ndarray, "3 3"]
    """The frame's axes in world coordinates, column by column."""
    components: ClassVar[int] = 3
    """Of the error."""

    def error(self, rotation: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, " turned"]:
        """The turn that is left from target to frame."""
        from scipy.spatial.transform import Rotation

        return np.asarray(Rotation.from_matrix(rotation @ self.rotation.T).as_rotvec())

    def jacobian(
        self, rotation: Float[np.ndarray, "3 3"], turning: Float[np.ndarray, "3 joint"]
    ) -> Float[np.ndarray, "turned joint"]:
        """Derivative of `error`, from the rows rx, ry, rz of the frame's Jacobian.

        dφ = (1 − ½[φ] + (1/θ² − (1 + cos θ)/(2θ sin θ)) [φ]²) ω, the inverse of the left Jacobian of SO(3).

        Args:
            rotation: of the frame, its axes column by column.
            turning: rows rx, ry, rz of the frame's Jacobian.
        """
        error = self.error(rotation)
        angle = float(np.linalg.norm(error))
        across = np.cross(np.eye(3), error)  # [φ], since [φ]ᵀ = −[φ]
        if angle < _SMALL:
            factor = 1 / 12
        else:
            factor = 1 / angle**2 - (1 + np.cos(angle)) / (2 * angle * np.sin(angle))
        return (np.eye(3) - across / 2 + factor * across @ across) @ turning


@dataclass(frozen=True, eq=False)
class AlignedAxis:
    """One axis of the frame held along a world direction; the error is the angle between, by components."""

    axis: Float[np.ndarray, "3"]
    """Unit vector in the frame."""
    target: Float[np.ndarray, "3"]
    """Unit vector in the world."""
    across: Float[np.ndarray, "turned 3"]
    """Unit vectors across the target along which the axis can leave it: two in space, one in a plane."""

    @property
    def components(self) -> int:
        """Of the error."""
        return len(self.across)

    def error(self, rotation: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, " turned"]:
        """Angle from target to axis [rad], by its components across the target."""
        along = rotation @ self.axis
        return _angle_over_sine(float(along @ self.target))[0] * (self.across @ along)

    def jacobian(
        self, rotation: Float[np.ndarray, "3 3"], turning: Float[np.ndarray, "3 joint"]
    ) -> Float[np.ndarray, "turned joint"]:
        """Derivative of `error`: an axis a turns at ω × a.

        Args:
            rotation: of the frame, its axes column by column.
            turning: rows rx, ry, rz of the frame's Jacobian.
        """
        along = rotation @ self.axis
        factor, slope = _angle_over_sine(float(along @ self.target))
        moved = np.cross(turning.T, along).T
        return factor * self.across @ moved + np.outer(slope * (self.across @ along), self.target @ moved)


Orientation = FixedOrientation | AlignedAxis


def _angle_over_sine(cosine: float) -> tuple[float, float]:
    """θ / sin θ as a function of cos θ, and its derivative."""
    cosine = float(np.clip(cosine, -1.0 + 1e-12, 1.0))
    angle = float(np.arccos(cosine))
    if angle < _SMALL:
        return 1 + (1 - cosine) / 3, -1 / 3
    sine = np.sin(angle)
    return float(angle / sine), float((angle * cosine / sine - 1) / sine**2)


def aligned(
    axis: Float[np.ndarray, "3"], target: Float[np.ndarray, "3"], normal: Float[np.ndarray, "3"] | None
) -> AlignedAxis:
    """An axis along a target; in a plane with this normal, if there is one.

    Args:
        axis: unit vector in the frame.
        target: unit vector in the world.
        normal: of the plane that the chain moves in, if it does.
    """
    if normal is not None:
        return AlignedAxis(axis, target, np.cross(normal, target)[None])
    first = np.cross(target, np.eye(3)[int(np.argmin(np.abs(target)))])
    first /= np.linalg.norm(first)
    return AlignedAxis(axis, target, np.array([first, np.cross(target, first)]))
