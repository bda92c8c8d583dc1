"""Linear algebra of a few rows and columns, written for the compiler, plain Python otherwise."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

_SWEEPS = 40
_ORTHOGONAL = 1e-15
"""Cosine between two rows that counts as none."""
_NOTHING = 1e-100
"""The same relative to the longer row: beside it the other is none, and its square may underflow."""

RANK = 1e-9
"""Share of the largest singular value below which one counts as zero."""


def orthogonal_rows(matrix, left, values):
    """Singular value decomposition A = U Σ Vᵀ of a matrix with few rows, by turning pairs of rows.

    One-sided Jacobi rotations (Golub and Van Loan, Matrix Computations, 4th ed., section 8.6.3).

    Args:
        matrix: A; receives ΣVᵀ, rows orthogonal to one another, in no particular order.
        left: receives U.
        values: receives Σ.
    """
    count, width = matrix.shape
    for i in range(count):
        for j in range(count):
            left[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        turned = False
        for i in range(count - 1):
            for j in range(i + 1, count):
                a, b, c = 0.0, 0.0, 0.0
                for k in range(width):
                    a += matrix[i, k] * matrix[i, k]
                    b += matrix[j, k] * matrix[j, k]
                    c += matrix[i, k] * matrix[j, k]
                if abs(c) <= _ORTHOGONAL * math.sqrt(a * b) or abs(c) <= _NOTHING * (a + b):
                    continue
                turned = True
                half = (b - a) / (2.0 * c)
                tangent = math.copysign(1.0, half) / (abs(half) + math.sqrt(1.0 + half * half))
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = cosine * tangent
                for k in range(width):
                    x, y = matrix[i, k], matrix[j, k]
                    matrix[i, k], matrix[j, k] = cosine * x - sine * y, sine * x + cosine * y
                for k in range(count):
                    x, y = left[k, i], left[k, j]
                    left[k, i], left[k, j] = cosine * x - sine * y, sine * x + cosine * y
        if not turned:
            break
    for i in range(count):
        total = 0.0
        for k in range(width):
            total += matrix[i, k] * matrix[i, k]
        values[i] = math.sqrt(total)


def copy_vector(source, out):
    """Set out = source."""
    for k in range(len(out)):
        out[k] = source[k]


def copy_matrix(source, out):
    """Set out = source."""
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            out[i, k] = source[i, k]


def largest(values):
    """The largest entry, 0 of none."""
    best = 0.0
    for i in range(len(values)):
        best = max(best, values[i])
    return best


def null_space(rows, values, basis):
    """Orthonormal rows orthogonal to those of a matrix that `orthogonal_rows` left.

    Args:
        rows: ΣVᵀ.
        values: Σ.
        basis: receives the row space first, then what is orthogonal to it; square.

    Returns:
        Where the null space begins in `basis`.
    """
    width = len(basis)
    least = RANK * max(largest(values), 1e-30)
    rank = 0
    for i in range(len(values)):
        if values[i] > least and rank < width:
            for k in range(width):
                basis[rank, k] = rows[i, k] / values[i]
            rank += 1
    for row in range(rank, width):
        best, size = 0, -1.0
        for k in range(width):  # the axis least covered so far
            left = 1.0
            for i in range(row):
                left -= basis[i, k] * basis[i, k]
            if left > size:
                best, size = k, left
        for k in range(width):
            basis[row, k] = 1.0 if k == best else 0.0
        for _ in range(2):  # once more, for what rounding left
            for i in range(row):
                share = 0.0
                for k in range(width):
                    share += basis[row, k] * basis[i, k]
                for k in range(width):
                    basis[row, k] -= share * basis[i, k]
        size = 0.0
        for k in range(width):
            size += basis[row, k] * basis[row, k]
        for k in range(width):
            basis[row, k] /= math.sqrt(size)
    return rank


def shortest_solution(rows, left, values, wanted, out):
    """The shortest x with A x nearest to `wanted`, by what `orthogonal_rows` made of A."""
    least = RANK * largest(values)
    out[:] = 0.0
    for i in range(len(values)):
        if values[i] > least:
            share = 0.0
            for k in range(len(wanted)):
                share += left[k, i] * wanted[k]
            share /= values[i] * values[i]
            for k in range(len(out)):
                out[k] += share * rows[i, k]


def multipliers(rows, left, values, gradient, out):
    """The shortest λ with Aᵀλ nearest to `gradient`, likewise."""
    least = 1e-15 * len(gradient) * largest(values)
    out[:] = 0.0
    for i in range(len(values)):
        if values[i] > least:
            share = 0.0
            for k in range(len(gradient)):
                share += rows[i, k] * gradient[k]
            share /= values[i] * values[i]
            for k in range(len(out)):
                out[k] += share * left[k, i]
