"""The kernel for any number of coordinates: the algebra of `flexmodal.frf.kernels.factor` in loops."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from flexmodal.frf.kernels.factor import GROWTH, LANES, SMALLEST_PIVOT

TOGETHER = 4
"""Rows subtracted at a time: what they change is loaded and stored a quarter as often."""


def room(n: int, rows: int) -> int:
    """Length of the working array: U with its further columns, and as columns L, 1/D, sizes and trust."""
    return (2 * (n + rows + 3) * n + 1) * LANES


def kernel(tile, rows, out, n, pairs, work):
    """One tile of points; arguments as `flexmodal.frf.kernels.factor.write_kernel` says.

    Row k of U = DLᵀ follows from those above it, U_kc = Z_kc − Σ_{m<k} L_km U_mc with L_km = U_mk/D_m. The
    rows of the Jacobian are further columns of Z: column c = n + r of coordinate k is entry k of row r.
    Columns are kept together, an entry's real lanes before its imaginary ones, so that the rows m of one
    column follow one another and a compiler sees what can and what cannot overlap.
    """
    more = len(rows) // (n * LANES)
    columns, column = n + more, 2 * n * LANES
    factor = work[columns * column : (columns + 1) * column]
    inverse, trust = work[(columns + 1) * column : (columns + 2) * column], work[len(work) - LANES :]
    size = work[(columns + 2) * column : (columns + 2) * column + n * LANES]
    fill(tile, rows, n, work, size)
    for e in range(2 * len(pairs) * LANES):
        out[e] = 0.0
    for p in range(LANES):
        trust[p] = 1.0
    for k in range(n):
        row = work[k * column : (k + 1) * column]
        for m in range(k):
            w, d = row[2 * m * LANES : 2 * (m + 1) * LANES], inverse[2 * m * LANES : 2 * (m + 1) * LANES]
            f = factor[2 * m * LANES : 2 * (m + 1) * LANES]
            for p in range(LANES):
                f[p] = w[p] * d[p] - w[LANES + p] * d[LANES + p]
                f[LANES + p] = w[p] * d[LANES + p] + w[LANES + p] * d[p]
        whole = k - k % TOGETHER
        for m in range(0, whole, TOGETHER):
            f = factor[2 * m * LANES : 2 * (m + TOGETHER) * LANES]
            for c in range(k, columns):
                w = work[c * column + 2 * k * LANES : c * column + 2 * (k + 1) * LANES]
                u = work[c * column + 2 * m * LANES : c * column + 2 * (m + TOGETHER) * LANES]
                for p in range(LANES):
                    x, y = w[p], w[LANES + p]
                    for j in range(TOGETHER):  # unrolled by the compiler
                        a, b = f[2 * j * LANES + p], f[(2 * j + 1) * LANES + p]
                        s, t = u[2 * j * LANES + p], u[(2 * j + 1) * LANES + p]
                        x = x - a * s + b * t
                        y = y - a * t - b * s
                    w[p], w[LANES + p] = x, y
        for m in range(whole, k):
            f = factor[2 * m * LANES : 2 * (m + 1) * LANES]
            for c in range(k, columns):
                w = work[c * column + 2 * k * LANES : c * column + 2 * (k + 1) * LANES]
                u = work[c * column + 2 * m * LANES : c * column + 2 * (m + 1) * LANES]
                for p in range(LANES):
                    a, b, s, t = f[p], f[LANES + p], u[p], u[LANES + p]
                    x = w[p] - a * s + b * t
                    y = w[LANES + p] - a * t - b * s
                    w[p], w[LANES + p] = x, y
        w, d = row[2 * k * LANES : 2 * (k + 1) * LANES], inverse[2 * k * LANES : 2 * (k + 1) * LANES]
        least = SMALLEST_PIVOT**2 if k == n - 1 else 0.0
        own = size[k * LANES : (k + 1) * LANES]
        for p in range(LANES):
            square, limit = w[p] * w[p] + w[LANES + p] * w[LANES + p], own[p] * own[p]
            d[p], d[LANES + p] = w[p] / square, -w[LANES + p] / square
            trust[p] = min(trust[p], GROWTH**2 * limit - square, square - least * limit)
        add_products(k, n, pairs, work, d, out)
    for p in range(LANES):
        out[2 * len(pairs) * LANES + p] = trust[p]


def add_products(k, n, pairs, work, d, out):
    """Add coordinate k's share of every receptance, u_k v_k / D_k; `d` is 1/D_k."""
    column = 2 * n * LANES
    for place in range(len(pairs)):
        start = (n + pairs[place, 0]) * column + 2 * k * LANES
        u = work[start : start + 2 * LANES]
        start = (n + pairs[place, 1]) * column + 2 * k * LANES
        v = work[start : start + 2 * LANES]
        w = out[2 * place * LANES : 2 * (place + 1) * LANES]
        for p in range(LANES):
            a = u[p] * d[p] - u[LANES + p] * d[LANES + p]
            b = u[p] * d[LANES + p] + u[LANES + p] * d[p]
            w[p] += a * v[p] - b * v[LANES + p]
            w[LANES + p] += a * v[LANES + p] + b * v[p]


def fill(tile, rows, n, work, size):
    """Z and the rows, and |K_kk| + ω²M_kk + ωB_kk of each coordinate."""
    half = n * (n + 1) // 2
    entries = len(tile) // LANES - 1
    width = n if entries == half + 3 * n else half
    extra = entries > half + 3 * width
    column = 2 * n * LANES
    e = 0
    for i in range(n):
        for j in range(i, n):
            place = e if width == half else (i if i == j else -1)
            w = work[j * column + 2 * i * LANES : j * column + 2 * (i + 1) * LANES]
            for p in range(LANES):
                omega = tile[p]
                inertia = -omega * omega * tile[(1 + e) * LANES + p]
                spring, im, added = 0.0, 0.0, 0.0
                if place >= 0:
                    spring = tile[(1 + half + place) * LANES + p]
                    im = (
                        tile[(1 + half + 2 * width + place) * LANES + p]
                        + omega * tile[(1 + half + width + place) * LANES + p]
                    )
                if extra:
                    added = tile[(1 + half + 3 * width + e) * LANES + p]
                    im += tile[(1 + 2 * half + 3 * width + e) * LANES + p]
                w[p], w[LANES + p] = spring + inertia + added, im
                if i == j:
                    size[i * LANES + p] = spring - inertia + abs(added) + abs(im)
            e += 1
        for r in range(len(rows) // (n * LANES)):
            start = (n + r) * column + 2 * i * LANES
            for p in range(LANES):
                work[start + p], work[start + LANES + p] = rows[(r * n + i) * LANES + p], 0.0
