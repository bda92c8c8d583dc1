"""Z of one point factored and solved with: written for the compiler."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from flexmodal.frf.kernels.factor import GROWTH, SMALLEST_PIVOT


def factor_symmetric(matrix, size):
    """LDLᵀ in place: 1/D on the diagonal, the rows of Lᵀ beside it; False if a pivot is not to be trusted."""
    n = len(matrix)
    trusted = True
    for k in range(n):
        pivot = matrix[k, k]
        square = pivot.real * pivot.real + pivot.imag * pivot.imag
        least = SMALLEST_PIVOT if k == n - 1 else 0.0
        trusted = trusted and (least * size[k]) ** 2 < square <= (GROWTH * size[k]) ** 2
        inverse = complex(pivot.real / square, -pivot.imag / square)
        matrix[k, k] = inverse
        for j in range(k + 1, n):
            factor = matrix[k, j] * inverse
            for i in range(j, n):
                matrix[j, i] -= factor * matrix[k, i]
            matrix[j, k] = factor
    return trusted


def solve_factored(matrix, row, pick, work, out):
    """Solve Z y = row with what `factor_symmetric` left; y's parts go to the flexible places of `out`."""
    n = len(matrix)
    for k in range(n):
        value = complex(row[pick[k]], 0.0)
        for i in range(k):
            value -= matrix[k, i] * work[i]
        work[k] = value
    for k in range(n - 1, -1, -1):
        value = work[k] * matrix[k, k]
        for i in range(k + 1, n):
            value -= matrix[i, k] * work[i]
        work[k] = value
        out[0, pick[k]], out[1, pick[k]] = value.real, value.imag
