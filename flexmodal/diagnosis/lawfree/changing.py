"""What a sensor that reads something else in each posture does there: lie otherwise, come late, scale.

What the other points say foretells the motion of this one along three axes. A sensor that lies otherwise, in
each posture in its own way, reads along axes that are turned, perhaps one of them the other way round: three
angles for each posture, the same at every frequency and for every blow. The nearest turn is that of Wahba's
problem (SIAM Review 7, 1965, 409), each axis weighted by what is known of it. One whose clock drifts is late
by a time of its own in each posture, and one that warms reads more by a factor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import least_squares, minimize_scalar
from scipy.spatial.transform import Rotation

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.identification import Observations, predict
from flexmodal.identification.gap import over_noise

LEAVES = 1.6
"""Times the noise that it leaves at most."""
HARDLY_MORE = 1.1
"""Times what the best leaves that one of fewer numbers may: an axis that is turned away reads less."""
LATEST = 0.03
"""By how much it is late or early at most [s]."""
ERROR = 0.01
"""Relative error of what is foretold, beside the noise of what is read."""

_Axes = Mapping[int, tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]]
"""By channel the triangle R and the vector q of its least squares |R a − q|² for the direction a it reads."""


def changing(
    observations: Observations, model: Hypothesis, x: Float[np.ndarray, " parameter"], point: int
) -> str | None:
    """Name of the effect that explains what a point's sensor reads, another one of its kind in each posture.

    Args:
        observations: of all points.
        model: fitted to those of the others.
        x: its coordinates.
        point: id.
    """
    seen = observations.keeping(observations.response[:, 0] == point)
    if not len(seen):
        return None
    moved = np.array([predict(model, x, _along(seen, axis)) for axis in (1, 2, 3)])
    if not np.isfinite(moved).all():
        return None
    left: dict[str, float] = {}
    for name, reads in (("sensor_gain", _scaled), ("time_delay", _late), ("sensor_misalignment", _turned)):
        read = np.zeros_like(seen.value)
        for posture in np.unique(seen.posture).tolist():
            rows = np.flatnonzero(seen.posture == posture)
            read[rows] = reads(seen.keeping(seen.posture == posture), moved[:, rows])
        left[name] = over_noise(seen, read)
    least = min(left.values())
    able = (name for name, over in left.items() if over <= min(LEAVES, HARDLY_MORE * least))
    return next(able, None)


def _turned(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"]
) -> Complex[np.ndarray, "observation line"]:
    """What is read in one posture along axes that are turned."""
    here = {int(axis): seen.response[:, 1] == axis for axis in np.unique(seen.response[:, 1])}
    axes = nearest({axis: _reduced(seen, moved, rows) for axis, rows in here.items()})
    return np.einsum("oa,aol->ol", axes[seen.response[:, 1] - 1], moved)


def _late(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"]
) -> Complex[np.ndarray, "observation line"]:
    """What is read in one posture later than it is, by the time that is nearest."""
    recorded, weight, value = _recorded(seen, moved), _weight(seen), _value(seen)
    s = 2j * np.pi * seen.axis.frequency

    def far(time: float) -> float:
        return float(np.sum(np.abs(weight * (value - recorded * np.exp(-s * time))) ** 2))

    step = 0.25 / float(seen.axis.frequency[-1])
    grid = np.arange(-LATEST, LATEST + step, step)
    near = float(grid[int(np.argmin([far(time) for time in grid.tolist()]))])
    time = minimize_scalar(far, bounds=(near - step, near + step), method="bounded", options={"xatol": 1e-9})
    return np.asarray(recorded * np.exp(-s * float(time.x)))


def _scaled(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"]
) -> Complex[np.ndarray, "observation line"]:
    """What is read in one posture larger or smaller than it is."""
    recorded, weight = _recorded(seen, moved), _weight(seen) ** 2
    size = max(float(np.sum(weight * np.abs(recorded) ** 2)), 1e-300)
    return np.asarray(recorded * (float(np.sum(weight * (_value(seen) * recorded.conj()).real)) / size))


def _recorded(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"]
) -> Complex[np.ndarray, "observation line"]:
    """Motion along the axis that each was recorded for."""
    return np.asarray(moved[seen.response[:, 1] - 1, np.arange(len(seen))])


def _weight(seen: Observations) -> Float[np.ndarray, "observation line"]:
    """What each line counts: one over its error; nothing where it is not used."""
    size = np.where(seen.used, np.abs(seen.value), 1.0)
    return np.where(seen.used, 1 / (size * np.sqrt(seen.variance + ERROR**2)), 0.0)


def _value(seen: Observations) -> Complex[np.ndarray, "observation line"]:
    """What was read; nothing where it is not used, whatever stands there."""
    return np.where(seen.used, seen.value, 0.0)


def _along(seen: Observations, axis: int) -> Observations:
    """As if all of it had been read along one axis."""
    return replace(seen, response=np.column_stack([seen.response[:, 0], np.full(len(seen), axis)]))


def _reduced(
    seen: Observations, moved: Complex[np.ndarray, "3 observation line"], rows: np.ndarray
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    """Least squares of what some observations read over the motions, in real numbers."""
    weight = _weight(seen)[rows].ravel()
    columns, target = (moved[:, rows].reshape(3, -1) * weight).T, _value(seen)[rows].ravel() * weight
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
