"""The kernel for any number of coordinates: the algebra of `flexmodal.frf.kernels.factor` in loops."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np

from flexmodal.frf.kernels.factor import GROWTH, LANES, SMALLEST_PIVOT


def kernel(tile, rows, out, n, pairs, work):
    """One tile of points; arguments as `flexmodal.frf.kernels.factor.write_kernel` says.

    Row k of U = DLᵀ follows from those above it, U_kc = Z_kc − Σ_{m<k} L_km U_mc with L_km = U_mk/D_m: it
    stays in the first-level cache while they pass. The rows of the Jacobian are further columns of Z: column
    c = n + r of coordinate k is entry k of row r.
    """
    half = n * (n + 1) // 2
    entries = len(tile) // LANES - 1
    width = n if entries == half + 3 * n else half
    extra = entries > half + 3 * width
    more = len(rows) // (n * LANES)
    columns = n + more
    re = work[: n * columns * LANES].reshape(n, columns, LANES)
    im = work[n * columns * LANES :].reshape(n, columns, LANES)
    im[:] = 0.0
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
    factor_re, factor_im = np.empty(LANES), np.empty(LANES)
    for k in range(n):
        for m in range(k):
            for p in range(LANES):
                a, b = re[m, k, p], im[m, k, p]
                factor_re[p] = a * inverse_re[m, p] - b * inverse_im[m, p]
                factor_im[p] = a * inverse_im[m, p] + b * inverse_re[m, p]
            for c in range(k, columns):
                for p in range(LANES):
                    re[k, c, p] += factor_im[p] * im[m, c, p] - factor_re[p] * re[m, c, p]
                    im[k, c, p] -= factor_re[p] * im[m, c, p] + factor_im[p] * re[m, c, p]
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
