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

import numpy as np
from jaxtyping import Float

from flexmodal.text.extras import extra

VECTORS = 3
"""Of the basis, at most."""
NEGLIGIBLE = 1e-3
"""Vectors with less than this part of the sum of squares are left out."""


def features(
    postures: Sequence[Mapping[str, float]], sliding: Sequence[str] = ()
) -> Float[np.ndarray, "posture feature"]:
    """Coordinates in which the distance of two postures is d above.

    Args:
        postures: values of the joints [rad, m]; a joint left out is 0.
        sliding: names of prismatic joints.
    """
    names = sorted({name for posture in postures for name in posture})
    columns = []
    for name in names:
        way = np.array([posture.get(name, 0.0) for posture in postures])
        if name in sliding:
            spread = float(way.std())
            columns.append(way / spread if spread > 0 else 0 * way)
        else:
            columns += [np.cos(way), np.sin(way)]
    return np.array(columns).reshape(len(columns), len(postures)).T


def interpolated(
    rows: Float[np.ndarray, "posture number"],
    at: Float[np.ndarray, "posture feature"],
    wanted: Float[np.ndarray, " feature"],
) -> Float[np.ndarray, " number"]:
    """The row of a posture that was not measured.

    Args:
        rows: of those measured.
        at: their coordinates.
        wanted: coordinates of the one asked for.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    found = np.zeros(rows.shape[1])
    left, size, right = np.linalg.svd(rows, full_matrices=False)
    total, count = float(np.sum(size**2)), len(rows)
    for number in range(min(VECTORS, count)):
        if not size[number] ** 2 > NEGLIGIBLE * total:
            break
        coefficient = _process(at, left[:, number] * np.sqrt(count), wanted)
        found = found + coefficient / np.sqrt(count) * size[number] * right[number]
    return found


def _process(
    at: Float[np.ndarray, "posture feature"],
    value: Float[np.ndarray, " posture"],
    wanted: Float[np.ndarray, " feature"],
) -> float:
    """Mean of a Gaussian process given its values, which have a mean square of 1."""
    processes = extra("sklearn.gaussian_process", "predict", "a prediction between postures")
    kernels = processes.kernels
    covariance = (
        kernels.ConstantKernel(1.0, (1e-3, 10.0))
        + kernels.ConstantKernel(0.5, (1e-3, 10.0)) * kernels.RBF(1.0, (0.3, 6.0))
        + kernels.WhiteKernel(0.3, (1e-3, 3.0))
    )
    model = processes.GaussianProcessRegressor(covariance)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an optimum at a bound of the list above is one
        model.fit(at, value)
        return float(model.predict(wanted[None])[0])
