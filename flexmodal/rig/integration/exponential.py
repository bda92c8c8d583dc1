"""Matrix exponentials, many small ones at once.

Padé approximation of order 13 with scaling and squaring (Higham, SIAM J. Matrix Anal. 26, 2005), every matrix
of a stack alike. One call for a hundred small matrices costs about what a library call for one does.

The matrices are balanced first, by powers of two and so without rounding (Parlett and Reinsch, Numer. Math.
13, 1969). A stiff link makes entries of a state matrix 10¹⁷ times as large as others, though no pole is as
fast: by their norm it would be squared thirty times, and rounding, doubled each time, would make the arm ring
up.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

_PADE = (
    64764752532480000.0, 32382376266240000.0, 7771770303897600.0, 1187353796428800.0, 129060195264000.0,
    10559470521600.0, 670442572800.0, 33522128640.0, 1323241920.0, 40840800.0, 960960.0, 16380.0, 182.0, 1.0,
)  # fmt: skip
"""Coefficients of the numerator of the [13/13] approximant."""
_RADIUS = 5.371920351148152
"""1-norm up to which the approximant is exact to double precision."""


def exponential(matrices: Float[np.ndarray, "*many n n"]) -> Float[np.ndarray, "*many n n"]:
    """Exp of each matrix of a stack."""
    scale = _balance(matrices)
    matrices = matrices * (scale / scale[:, None])
    norm = float(np.max(np.sum(np.abs(matrices), axis=-2), initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(norm / _RADIUS)))) if norm > _RADIUS else 0
    a = matrices / 2.0**halvings
    one = np.eye(a.shape[-1])
    c = _PADE
    a2 = a @ a
    a4 = a2 @ a2
    a6 = a4 @ a2
    odd = a @ (a6 @ (c[13] * a6 + c[11] * a4 + c[9] * a2) + c[7] * a6 + c[5] * a4 + c[3] * a2 + c[1] * one)
    even = a6 @ (c[12] * a6 + c[10] * a4 + c[8] * a2) + c[6] * a6 + c[4] * a4 + c[2] * a2 + c[0] * one
    value = np.linalg.solve(even - odd, even + odd)
    for _ in range(halvings):
        value = value @ value
    return value * (scale[:, None] / scale)


def _balance(matrices: Float[np.ndarray, "*many n n"]) -> Float[np.ndarray, " n"]:
    """Powers of two d that make rows and columns of A d_j/d_i alike in size; one for all of a stack."""
    from scipy.linalg import matrix_balance

    size = np.abs(matrices).reshape(-1, *matrices.shape[-2:]).max(axis=0)
    return np.asarray(matrix_balance(size, permute=False, separate=True)[1][0], dtype=float)


def polynomial(weights: Float[np.ndarray, " power"], a: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """Σ_j weights[j] Aʲ, by Horner's rule over blocks of powers.

    Args:
        weights: of each power.
        a: the matrix A.
    """
    width = int(np.ceil(np.sqrt(len(weights))))
    powers = [np.eye(len(a))]
    for _ in range(width):
        powers.append(powers[-1] @ a)
    padded = np.pad(weights, (0, -len(weights) % width)).reshape(-1, width)
    blocks = np.tensordot(padded, np.array(powers[:width]), 1)
    total = blocks[-1]
    for block in blocks[-2::-1]:
        total = total @ powers[width] + block
    return total
