"""Z y = jᵀ at a tile of points side by side: written for the compiler, which makes vectors of the lanes.

LDLᵀ without pivoting as in `flexmodal.model.batch.gradient_kernel`, one lane a point, be it another
posture or another frequency. One point alone leaves most of a core idle: a division waits for the one before
it. An entry's real lanes come before its imaginary ones.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from flexmodal.frf.kernels.factor import GROWTH, SMALLEST_PIVOT

TILE = 16
"""Points worked on together: two vectors' worth of the widest; their postures stay in the cache."""


def fill_lane(pick, matrices, lag, w, full, lane, matrix, size):
    """Upper half of Z at an angular frequency into one lane, and |K_kk| + ω²M_kk + ωB_kk.

    Args:
        pick: which joints are flexible.
        matrices: K and B.
        lag: what hysteresis adds to the diagonal there, real and imaginary part; 2 × n.
        w: angular frequency [rad/s].
        full: mass matrix over all joints.
        lane: of the point.
        matrix: receives Z; n × n × part × lane.
        size: receives the sizes; n × lane.
    """
    for i in range(len(pick)):
        for j in range(i, len(pick)):
            z = matrix[i, j]
            z[0, lane] = matrices[0, i, j] - w * w * full[pick[i], pick[j]]
            z[1, lane] = w * matrices[1, i, j]
        matrix[i, i, 0, lane] += lag[0, i]
        matrix[i, i, 1, lane] += lag[1, i]
        spring = matrices[0, i, i] + lag[0, i]
        size[i, lane] = spring + w * w * full[pick[i], pick[i]] + matrix[i, i, 1, lane]


def factor_tile(matrix, size, trust):
    """LDLᵀ in place: 1/D on the diagonal, L below it; `trust` is negative where a pivot is not."""
    n = len(matrix)
    for p in range(TILE):
        trust[p] = 1.0
    for k in range(n):
        d, own = matrix[k, k], size[k]
        least = SMALLEST_PIVOT**2 if k == n - 1 else 0.0
        for p in range(TILE):
            square = d[0, p] * d[0, p] + d[1, p] * d[1, p]
            limit = own[p] * own[p]
            over = 1.0 / square
            d[0, p], d[1, p] = d[0, p] * over, -d[1, p] * over
            trust[p] = min(trust[p], GROWTH**2 * limit - square, square - least * limit)
        for j in range(k + 1, n):
            u, f = matrix[k, j], matrix[j, k]
            for p in range(TILE):
                f[0, p] = u[0, p] * d[0, p] - u[1, p] * d[1, p]
                f[1, p] = u[0, p] * d[1, p] + u[1, p] * d[0, p]
            for i in range(j, n):
                subtract_product(f, matrix[k, i], matrix[j, i])


def solve_tile(matrix, y):
    """Turn jᵀ into Z⁻¹jᵀ in place; n × part × lane."""
    n = len(matrix)
    for k in range(n):
        for i in range(k):
            subtract_product(matrix[k, i], y[i], y[k])
    for k in range(n - 1, -1, -1):
        d, own = matrix[k, k], y[k]
        for p in range(TILE):
            x, z = own[0, p], own[1, p]
            own[0, p] = x * d[0, p] - z * d[1, p]
            own[1, p] = x * d[1, p] + z * d[0, p]
        for i in range(k + 1, n):
            subtract_product(matrix[i, k], y[i], own)


def subtract_product(a, b, c):
    """Complex c ← c − a·b, lane by lane."""
    for p in range(TILE):
        x, z = a[0, p], a[1, p]
        s, t = b[0, p], b[1, p]
        c[0, p] = c[0, p] - x * s + z * t
        c[1, p] = c[1, p] - x * t - z * s
