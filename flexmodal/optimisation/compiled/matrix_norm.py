"""A smooth largest singular value of a small symmetric matrix, and its derivative.

N is the 40-norm of the singular values, for which none has to be found: N⁴⁰ = Σσ⁴⁰ = tr H²⁰ with H = AᴴA. Its
derivative is d ln N = Re tr(W dA) with W = H¹⁹Aᴴ / tr H²⁰, which has no kink where two singular values meet.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

FLOOR = 1e-36
"""Square of the size that is added so that a logarithm stays finite."""


def matrix_norm(a, work):
    """The 40-norm of the singular values; |a| of a single number."""
    if len(a) == 1:
        return abs(a[0, 0])
    scale = square_sum(a)
    if not (scale > 0.0 and math.isfinite(scale)):
        return scale
    return math.sqrt(scale) * gram_power(a, scale, work) ** (1.0 / 40.0)


def norm_slope(a, norm, work, out):
    """Set `out` to the symmetric G with d ln N = Re Σ_uv G_uv dA_uv."""
    many = len(a)
    scale = square_sum(a)
    floored = norm * norm + FLOOR
    if many == 1 or not scale > 0.0:
        for u in range(many):
            for v in range(many):
                out[u, v] = a[u, v].conjugate() / floored
        return
    factor = norm * norm / (floored * scale * gram_power(a, scale, work))
    for u in range(many):
        for v in range(many):
            total = 0.0j  # W_uv = Σ_m (H¹⁹)_um conj(A_vm)
            for m in range(many):
                total += work[1, u, m] * a[v, m].conjugate()
            work[2, u, v] = total
    for u in range(many):
        for v in range(many):
            out[u, v] = 0.5 * factor * (work[2, u, v] + work[2, v, u])


def square_sum(a):
    """The sum of the squared magnitudes of the entries, which is that of the singular values."""
    total = 0.0
    for u in range(len(a)):
        for v in range(len(a)):
            total += a[u, v].real * a[u, v].real + a[u, v].imag * a[u, v].imag
    return total


def gram_power(a, scale, work):
    """With H = AᴴA/scale, the trace of H²⁰; leaves H¹⁹ in work[1]."""
    many = len(a)
    gram, kept, even, other = work[0], work[1], work[2], work[3]
    for u in range(many):
        for v in range(many):
            total = 0.0j
            for m in range(many):
                total += a[m, u].conjugate() * a[m, v]
            gram[u, v] = total / scale
    multiply(gram, gram, even)  # H²
    multiply(gram, even, other)  # H³
    multiply(even, even, kept)  # H⁴
    multiply(kept, kept, even)  # H⁸
    multiply(even, even, kept)  # H¹⁶
    multiply(kept, other, even)
    trace = 0.0
    for u in range(many):
        for v in range(many):
            kept[u, v] = even[u, v]
            trace += (gram[u, v] * even[v, u]).real
    return trace


def multiply(a, b, out):
    """A product of small square matrices."""
    for u in range(len(a)):
        for v in range(len(a)):
            total = 0.0j
            for m in range(len(a)):
                total += a[u, m] * b[m, v]
            out[u, v] = total
