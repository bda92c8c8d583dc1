"""The kernel for any number of coordinates: the algebra of `flexmodal.frf.kernels.factor` in loops."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np

from flexmodal.frf.kernels.factor import GROWTH, LANES, SMALLEST_PIVOT

CHUNK = 4


def kernel(tile, rows, out, n, pairs):
    """One tile of points; arguments as `flexmodal.frf.kernels.factor.write_kernel` says.

    Row k of U = DLᵀ follows from those above it, U_kc = Z_kc − Σ_{m<k} L_km U_mc with L_km = U_mk/D_m, taken
    `CHUNK` at a time so that most operands stay in registers. The rows of the Jacobian are further columns
    of Z: column c = n + r of coordinate k is entry k of row r.
    """
    half = n * (n + 1) // 2
    entries = len(tile) // LANES - 1
    width = n if entries == half + 3 * n else half
    extra = entries > half + 3 * width
    more = len(rows) // (n * LANES)
    columns = n + more
    re, im = np.zeros((n + CHUNK, columns, LANES)), np.zeros((n + CHUNK, columns, LANES))
    size, trust = np.empty((n, LANES)), np.ones(LANES)
    e = 0
    for i in range(n):
        for j in range(i, n):
            place = e if width == half else (i if i == j else -1)
            for p in range(LANES):
                omega = tile[p]
                inertia = -omega * omega * tile[(1 + e) * LANES + p]
                re[i, j, p] = inertia
                if place >= 0:
                    spring = tile[(1 + half + place) * LANES + p]
                    re[i, j, p] += spring
                    im[i, j, p] = (
                        tile[(1 + half + 2 * width + place) * LANES + p]
                        + omega * tile[(1 + half + width + place) * LANES + p]
                    )
                    if i == j:
                        size[i, p] = spring - inertia + im[i, j, p]
                if extra:
                    added = tile[(1 + half + 3 * width + e) * LANES + p]
                    re[i, j, p] += added
                    im[i, j, p] += tile[(1 + 2 * half + 3 * width + e) * LANES + p]
                    if i == j:
                        size[i, p] = spring - inertia + abs(added) + abs(im[i, j, p])
            e += 1
        for r in range(more):
            for p in range(LANES):
                re[i, n + r, p] = rows[(r * n + i) * LANES + p]
    for e in range(2 * len(pairs) * LANES):
        out[e] = 0.0
    inverse_re, inverse_im = np.empty((n, LANES)), np.empty((n, LANES))
    factor_re, factor_im = np.zeros((CHUNK, LANES)), np.zeros((CHUNK, LANES))
    for k in range(n):
        for first in range(0, k, CHUNK):
            for m in range(CHUNK):
                above = first + m
                for p in range(LANES):
                    if above < k:
                        a, b = re[above, k, p], im[above, k, p]
                        factor_re[m, p] = a * inverse_re[above, p] - b * inverse_im[above, p]
                        factor_im[m, p] = a * inverse_im[above, p] + b * inverse_re[above, p]
                    else:
                        factor_re[m, p] = factor_im[m, p] = 0.0
            for c in range(k, columns):
                for p in range(LANES):
                    a, b = re[k, c, p], im[k, c, p]
                    for m in range(CHUNK):
                        x, y = re[first + m, c, p], im[first + m, c, p]
                        a = a - factor_re[m, p] * x + factor_im[m, p] * y
                        b = b - factor_re[m, p] * y - factor_im[m, p] * x
                    re[k, c, p], im[k, c, p] = a, b
        for p in range(LANES):
            square = re[k, k, p] * re[k, k, p] + im[k, k, p] * im[k, k, p]
            inverse_re[k, p], inverse_im[k, p] = re[k, k, p] / square, -im[k, k, p] / square
            limit = size[k, p] * size[k, p]
            trust[p] = min(trust[p], GROWTH**2 * limit - square)
            if k == n - 1:
                trust[p] = min(trust[p], square - SMALLEST_PIVOT**2 * limit)
        for place in range(len(pairs)):
            u, v = n + pairs[place, 0], n + pairs[place, 1]
            for p in range(LANES):
                a = re[k, u, p] * inverse_re[k, p] - im[k, u, p] * inverse_im[k, p]
                b = re[k, u, p] * inverse_im[k, p] + im[k, u, p] * inverse_re[k, p]
                out[2 * place * LANES + p] += a * re[k, v, p] - b * im[k, v, p]
                out[(2 * place + 1) * LANES + p] += a * im[k, v, p] + b * re[k, v, p]
    for p in range(LANES):
        out[2 * len(pairs) * LANES + p] = trust[p]
