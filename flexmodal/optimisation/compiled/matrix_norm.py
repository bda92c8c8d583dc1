"""The size of a small symmetric receptance matrix A in three senses, and its derivative.

With force and toward unit vectors w and t: |tᵀAw|, ‖Aw‖, or a smooth largest singular value. The last is the
40-norm N of the singular values, for which none has to be found: N⁴⁰ = Σσ⁴⁰ = tr H²⁰ with H = AᴴA. Its
derivative is d ln N = Re tr(W dA) with W = H¹⁹Aᴴ / tr H²⁰, which has no kink where two singular values meet.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.optimisation.compiled.arrays import FORCE, PAIR

FLOOR = 1e-36
"""Square of the size that is added so that a logarithm stays finite."""


def matrix_size(judge, a, work):
    """The size of A."""
    if judge.measure == PAIR:
        return abs(motion_along(a, judge.toward, judge.force))
    if judge.measure == FORCE:
        total = 0.0
        for u in range(len(a)):
            part = motion(a, u, judge.force)
            total += part.real * part.real + part.imag * part.imag
        return math.sqrt(total)
    scale = square_sum(a)
    if not (scale > 0.0 and math.isfinite(scale)):
        return scale
    return math.sqrt(scale) * gram_power(a, scale, work) ** (1.0 / 40.0)


def size_slope(judge, a, size, work, out):
    """Set `out` to the symmetric G with d ln size = Re Σ_uv G_uv dA_uv; `size` is that of A."""
    many, floored, force = len(a), size * size + FLOOR, judge.force
    w = work[2]  # not symmetric yet
    if judge.measure == PAIR:
        toward = judge.toward
        factor = motion_along(a, toward, force).conjugate() / floored
        for u in range(many):
            for v in range(many):
                w[u, v] = factor * (toward[u] * force[v])
    elif judge.measure == FORCE:
        for u in range(many):
            factor = motion(a, u, force).conjugate() / floored
            for v in range(many):
                w[u, v] = factor * force[v]
    else:
        scale = square_sum(a)
        factor = size * size / (floored * scale * gram_power(a, scale, work)) + 0.0j if scale > 0.0 else 0.0j
        for u in range(many):
            for v in range(many):
                total = 0.0j  # Σ_m (H¹⁹)_um conj(A_vm)
                for m in range(many):
                    total += work[1, u, m] * a[v, m].conjugate()
                w[u, v] = factor * total
    for u in range(many):
        for v in range(many):
            out[u, v] = 0.5 * (w[u, v] + w[v, u])


def motion(a, u, force):
    """Entry u of A w."""
    total = 0.0j
    for v in range(len(a)):
        total += a[u, v] * force[v]
    return total


def motion_along(a, toward, force):
    """The number tᵀ A w."""
    total = 0.0j
    for u in range(len(a)):
        total += toward[u] * motion(a, u, force)
    return total


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
