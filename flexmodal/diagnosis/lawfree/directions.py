"""Whether a sensor that reads something else in each posture lies otherwise than recorded, and no more.

What the other points say foretells the motion of this one along three axes. A sensor that lies otherwise, in
each posture in its own way, reads along axes that are turned, perhaps one of them the other way round: three
angles for each posture, the same at every frequency and for every blow. The nearest turn is that of Wahba's
problem (SIAM Review 7, 1965, 409), each axis weighted by what is known of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.identification import Observations, predict
from flexmodal.identification.gap import over_noise

LEAVES = 1.6
"""Times the noise that turned axes leave at most."""
ERROR = 0.01
"""Relative error of what is foretold, beside the noise of what is read."""

_Axes = Mapping[int, tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]]
"""By channel the triangle R and the vector q of its least squares |R a − q|² for the direction a it reads."""


def lies_otherwise(
    observations: Observations, model: Hypothesis, x: Float[np.ndarray, " parameter"], point: int
) -> bool:
    """Whether turned axes, other ones in each posture, explain what a point's sensor reads.

    Args:
        observations: of all points.
        model: fitted to those of the others.
        x: its coordinates.
        point: id.
    """
    seen = observations.keeping(observations.response[:, 0] == point)
    if not len(seen):
        return False
    moved = np.array([predict(model, x, _along(seen, axis)) for axis in (1, 2, 3)])
    if not np.isfinite(moved).all():
        return False
    read = np.zeros_like(seen.value)
    for posture in np.unique(seen.posture).tolist():
        here = {
            int(axis): (seen.posture == posture) & (seen.response[:, 1] == axis)
            for axis in np.unique(seen.response[seen.posture == posture, 1])
        }
        axes = nearest({axis: _reduced(seen, moved, rows) for axis, rows in here.items()})
        for axis, rows in here.items():
            read[rows] = np.einsum("a,aol->ol", axes[axis - 1], moved[:, rows])
    return over_noise(seen, read) <= LEAVES


def _along(seen: Observations, axis: int) -> Observations:
    """As if all of it had been read along one axis."""
    return replace(seen, response=np.column_stack([seen.response[:, 0], np.full(len(seen), axis)]))


def _reduced(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"], rows: np.ndarray
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    """Least squares of what some observations read over the motions, in real numbers."""
    used, value = seen.used[rows], seen.value[rows]
    size = np.where(used, np.abs(value), 1.0)
    weight = np.where(used, 1 / (size * np.sqrt(seen.variance[rows] + ERROR**2)), 0.0).ravel()
    columns, target = (moved[:, rows].reshape(3, -1) * weight).T, value.ravel() * weight
    q, r = np.linalg.qr(np.concatenate([columns.real, columns.imag]))
    return r, q.T @ np.concatenate([target.real, target.imag])


def nearest(known: _Axes) -> Float[np.ndarray, "3 3"]:
    """Three axes square to one another that come nearest to what channels read.

    Args:
        known: least squares by channel 1, 2 and 3; those of which nothing is known are left out.

    Returns:
        Axis by axis, turned from those of the world, or mirrored besides.
    """
    free = np.eye(3)
    for axis, (r, q) in known.items():
        free[axis - 1] = np.linalg.lstsq(r, q, rcond=1e-6)[0]
    u, _, v = np.linalg.svd(free)

    def far(vector: np.ndarray, mirror: np.ndarray) -> np.ndarray:
        axes = mirror @ Rotation.from_rotvec(vector).as_matrix()
        return np.concatenate([r @ axes[axis - 1] - q for axis, (r, q) in known.items()])

    found = []
    for mirror in (np.eye(3), -np.eye(3)):
        begins = [np.eye(3), mirror @ u @ np.diag([1.0, 1.0, np.linalg.det(mirror @ u @ v)]) @ v]
        for begin in begins:
            vector = Rotation.from_matrix(begin).as_rotvec()
            made = least_squares(far, vector, args=(mirror,))
            found.append((float(made.cost), mirror @ Rotation.from_rotvec(made.x).as_matrix()))
    return min(found, key=lambda one: one[0])[1]
