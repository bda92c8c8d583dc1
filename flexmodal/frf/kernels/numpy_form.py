"""The same algebra in numpy, over many points at once, for where numba is missing or not worth its start."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.frf.kernels.factor import GROWTH, SMALLEST_PIVOT, Pairs


def ldlt_receptances(
    matrix: Complex[np.ndarray, "dof dof point"],
    size: Float[np.ndarray, "dof point"],
    rows: Float[np.ndarray, "row dof point"],
    pairs: Pairs,
) -> tuple[Complex[np.ndarray, "pair point"], np.ndarray]:
    """Receptances by LDLᵀ without pivoting; see `flexmodal.frf.kernels.factor`.

    Args:
        matrix: Z, of which the upper half is read and overwritten.
        size: |K_kk| + ω²M_kk + ωB_kk.
        rows: Jacobian rows.
        pairs: numbers of the rows wanted.

    Returns:
        The receptances, and whether all pivots of a point are to be trusted.
    """
    n, points = size.shape
    columns = np.array(np.swapaxes(rows, 0, 1), dtype=complex)
    result = np.zeros((len(pairs), points), dtype=complex)
    trusted = np.ones(points, dtype=bool)
    with np.errstate(all="ignore"):  # a pivot of 1e-310 overflows what follows, which is then not trusted
        for k in range(n):
            pivot = matrix[k, k]
            least = SMALLEST_PIVOT if k == n - 1 else 0.0
            magnitude = np.abs(pivot)
            trusted &= (magnitude <= GROWTH * size[k]) & (magnitude > least * size[k])
            inverse = 1 / np.where(trusted, pivot, 1)
            for place, (u, v) in enumerate(pairs):
                result[place] += columns[k, u] * inverse * columns[k, v]
            for j in range(k + 1, n):
                factor = matrix[k, j] * inverse
                matrix[j, j:] -= factor * matrix[k, j:]
                columns[j] -= factor * columns[k]
    return result, trusted
