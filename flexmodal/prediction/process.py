"""A smooth function of posture: Gaussian processes on the coefficients of a reduced basis.

Rows of data, one a posture, are written as Y = U S Vᵀ (proper orthogonal decomposition, not centred). The
coefficients of each of the first vectors are samples of a Gaussian process over the posture with the
covariance

    a² + b² exp(−d²/2ℓ²) + σ² δ,    d² = Σ_j |e^{iq_j} − e^{iq'_j}|²,

so that a part is the same for all postures, a part goes smoothly from one to the next, and the rest is
chance; a, b, ℓ and σ are those of the largest marginal likelihood (Rasmussen and Williams, Gaussian Processes
for Machine Learning, MIT Press 2006, section 5.4.1). A prismatic joint counts by its way over the spread of
ways.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.text.extras import extra

VECTORS = 3
"""Of the basis, at most."""
LENGTHS = (0.3, 6.0)
"""In which ℓ is looked for, in units of d; angles count nearly as themselves [rad]."""
NEGLIGIBLE = 1e-3
"""Vectors with less than this part of the sum of squares are left out."""


@dataclass(frozen=True)
class Features:
    """Coordinates in which the distance of two postures is d above."""

    joints: tuple[str, ...]
    spread: Mapping[str, float]
    """Of the ways of prismatic joints among the measured postures [m]; 0 where they stood still."""

    @classmethod
    def of(cls, postures: Sequence[Mapping[str, float]], sliding: Sequence[str] = ()) -> Features:
        """Those in which measured postures are told apart.

        Args:
            postures: values of the joints [rad, m]; a joint left out is 0.
            sliding: names of prismatic joints.
        """
        names = tuple(sorted({name for posture in postures for name in posture}))
        ways = {name: [posture.get(name, 0.0) for posture in postures] for name in names if name in sliding}
        return cls(names, {name: float(np.std(way)) for name, way in ways.items()})

    def at(self, posture: Mapping[str, float]) -> Float[np.ndarray, " feature"]:
        """Coordinates of a posture.

        Args:
            posture: values of the joints [rad, m]; a joint left out is 0.
        """
        found: list[float] = []
        for name in self.joints:
            way = posture.get(name, 0.0)
            if name in self.spread:
                found.append(way / self.spread[name] if self.spread[name] > 0 else 0.0)
            else:
                found += [np.cos(way), np.sin(way)]
        return np.array(found)


def likeness(one: Float[np.ndarray, " feature"], other: Float[np.ndarray, " feature"]) -> float:
    """Correlation of what the smooth part leaves in two postures: exp(−d²/2λ²), λ a third of the least ℓ.

    From one posture to another far away that is chance. In one that is nearly the same it is no chance: an
    FRF is a continuous function of posture.

    Args:
        one: coordinates of a posture, see `Features`.
        other: of another.
    """
    return float(np.exp(-np.sum((one - other) ** 2) / (2 * (LENGTHS[0] / 3) ** 2)))


@dataclass(frozen=True, eq=False)
class Learnt:
    """Rows over the posture, learnt once and asked for at any."""

    vectors: Float[np.ndarray, "vector number"]
    """Of the reduced basis, each times the root mean square of its coefficients."""
    processes: tuple[Any, ...]
    """Of the coefficients, which have a mean square of 1."""

    def at(self, wanted: Float[np.ndarray, " feature"]) -> Float[np.ndarray, " number"]:
        """The row of a posture that was not measured.

        Args:
            wanted: its coordinates, see `features`.
        """
        found = np.zeros(self.vectors.shape[1])
        for vector, process in zip(self.vectors, self.processes, strict=True):
            found = found + float(process.predict(wanted[None])[0]) * vector
        return found


def learn(rows: Float[np.ndarray, "posture number"], at: Float[np.ndarray, "posture feature"]) -> Learnt:
    """Fit a process to each coefficient of the reduced basis.

    Args:
        rows: of the postures that were measured.
        at: their coordinates, see `features`.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    left, size, right = np.linalg.svd(rows, full_matrices=False)
    total, count = float(np.sum(size**2)), len(rows)
    kept = [k for k in range(min(VECTORS, count)) if size[k] ** 2 > NEGLIGIBLE * total]
    processes = tuple(_process(at, left[:, k] * np.sqrt(count)) for k in kept)
    return Learnt(right[kept] * size[kept, None] / np.sqrt(count), processes)


def _process(at: Float[np.ndarray, "posture feature"], value: Float[np.ndarray, " posture"]) -> Any:
    """A Gaussian process given its values, which have a mean square of 1."""
    processes = extra("sklearn.gaussian_process", "predict", "a prediction between postures")
    kernels = processes.kernels
    covariance = (
        kernels.ConstantKernel(1.0, (1e-3, 10.0))
        + kernels.ConstantKernel(0.5, (1e-3, 10.0)) * kernels.RBF(1.0, LENGTHS)
        + kernels.WhiteKernel(0.3, (1e-3, 3.0))
    )
    model = processes.GaussianProcessRegressor(covariance)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an optimum at a bound of the list above is one
        return model.fit(at, value)
