"""Loops over systems and lines, compiled by `solution`: solutions by LDLᵀ.

Plain functions of numbers and arrays. A block of lines is worked on side by side, real and imaginary parts
apart, so that the innermost loops fill vector registers. The elimination is that of
`flexmodal.frf.kernels.factor`, back substitution added; what is zero is left out. Where its pivots grow, a
line is not trusted.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np

from flexmodal.frf.kernels.factor import GROWTH, SMALLEST_PIVOT

WIDTH = 32
"""Lines that are worked on side by side: a matrix of them stays in the first- or second-level cache."""


@no_type_check  # a checker's wrapper cannot be compiled
def ordered(matrices, order, behind, count, linked, gone):
    """Choose an order of elimination in which little becomes more than zero, and say what does.

    Each time the coordinate goes next that is linked to the fewest (minimum degree: Tinney and Walker, Proc.
    IEEE 55, 1967), of several the first. Light ends behind springs, which are linked to one or two, go first.

    Args:
        matrices: K, C, M, H of a system, [4, dof, dof].
        order: filled with the coordinates in that order, [dof].
        behind: filled with places in that order of what a coordinate acts on when it goes, [dof, dof].
        count: filled with how many they are, [dof].
        linked: room for what is linked, [dof, dof].
        gone: room for what has gone, [dof].
    """
    n = len(order)
    linked[:], gone[:] = False, False
    for i in range(n):
        for j in range(i + 1, n):
            for part in range(len(matrices)):
                if matrices[part, i, j] != 0.0:
                    linked[i, j] = linked[j, i] = True
                    break
    for k in range(n):
        fewest = n
        for i in range(n):
            if gone[i]:
                continue
            links = 0
            for j in range(n):
                if linked[i, j] and not gone[j]:
                    links += 1
            if links < fewest:
                order[k], fewest = i, links
        own, gone[order[k]] = linked[order[k]], True
        for i in range(n):
            if own[i] and not gone[i]:
                for j in range(n):
                    if own[j] and not gone[j] and j != i:
                        linked[i, j] = True
    for k in range(n):
        count[k] = 0
        for place in range(k + 1, n):
            if linked[order[k], order[place]]:
                behind[k, count[k]] = place
                count[k] += 1


@no_type_check
def fill(matrices, order, behind, count, fr, fi, z, size):
    """Put Z together on a block of lines, and sizes of its diagonal.

    Args:
        matrices: K, C, M, H of a system, [4, dof, dof].
        order: see `ordered`.
        behind: see `ordered`.
        count: see `ordered`.
        fr: real parts of 1, s, s², h, [4, line].
        fi: imaginary parts.
        z: its upper half in that order is filled where anything comes to stand, [dof, dof, 2, line].
        size: sum of the absolute values in each diagonal element, [dof, line].
    """
    width = fr.shape[1]
    for i in range(len(order)):
        for place in range(-1, count[i]):
            j = i if place < 0 else behind[i, place]
            row, column = min(order[i], order[j]), max(order[i], order[j])
            k, c = matrices[0, row, column], matrices[1, row, column]
            q, h = matrices[2, row, column], matrices[3, row, column]
            x, y = z[i, j, 0], z[i, j, 1]
            for p in range(width):
                x[p] = k + c * fr[1, p] + q * fr[2, p] + h * fr[3, p]
                y[p] = c * fi[1, p] + q * fi[2, p] + h * fi[3, p]
            if i == j:
                for p in range(width):
                    size[i, p] = (
                        abs(k) + abs(c) * (abs(fr[1, p]) + abs(fi[1, p]))
                        + abs(q) * (abs(fr[2, p]) + abs(fi[2, p]))
                        + abs(h) * (abs(fr[3, p]) + abs(fi[3, p]))
                    )  # fmt: skip


@no_type_check
def solve(matrices, rows, wanted, factors, out, trust):
    """Solve Z y = row for the wanted rows of every system on every line.

    Args:
        matrices: K, C, M, H of every system, [system, 4, dof, dof].
        rows: [system, row, dof].
        wanted: whether a row is, [system, row].
        factors: 1, s, s², h by real and imaginary part, [4, 2, line].
        out: y, [system, row, dof, 2, line].
        trust: filled with what is above 0 where the elimination kept its digits, [system, line].
    """
    n, lines = matrices.shape[2], factors.shape[2]
    z = np.empty((n, n, 2, WIDTH))
    inverse = np.empty((n, 2, WIDTH))
    size = np.empty((n, WIDTH))
    order, behind, count = np.empty(n, np.int64), np.empty((n, n), np.int64), np.empty(n, np.int64)
    linked, seen = np.empty((n, n), np.bool_), np.empty(n, np.bool_)
    for m in range(len(matrices)):
        ordered(matrices[m], order, behind, count, linked, seen)
        for start in range(0, lines, WIDTH):
            width = min(WIDTH, lines - start)
            fr, fi = factors[:, 0, start : start + width], factors[:, 1, start : start + width]
            sure = trust[m, start : start + width]
            fill(matrices[m], order, behind, count, fr, fi, z, size)
            for p in range(width):
                sure[p] = 1.0
            for k in range(n):
                x, y, a, b = z[k, k, 0], z[k, k, 1], inverse[k, 0], inverse[k, 1]
                least = SMALLEST_PIVOT**2 if k == n - 1 else 0.0
                for p in range(width):
                    square = x[p] * x[p] + y[p] * y[p]
                    limit = size[k, p] * size[k, p]
                    a[p], b[p] = x[p] / square, -y[p] / square
                    sure[p] = min(sure[p], GROWTH**2 * limit - square, square - least * limit)
                for first in range(count[k]):
                    j = behind[k, first]
                    u, v, f, g = z[k, j, 0], z[k, j, 1], z[j, k, 0], z[j, k, 1]
                    for p in range(width):
                        f[p] = u[p] * a[p] - v[p] * b[p]
                        g[p] = u[p] * b[p] + v[p] * a[p]
                    for second in range(first, count[k]):
                        i = behind[k, second]
                        s, t, x, y = z[k, i, 0], z[k, i, 1], z[j, i, 0], z[j, i, 1]
                        for p in range(width):
                            x[p] -= f[p] * s[p] - g[p] * t[p]
                            y[p] -= f[p] * t[p] + g[p] * s[p]
            for r in range(rows.shape[1]):
                if wanted[m, r]:
                    own = out[m, r, :, :, start : start + width]
                    back(z, inverse, order, behind, count, rows[m, r], own, seen)


@no_type_check
def back(z, inverse, order, behind, count, row, out, started):
    """Solve for one row on a block of lines.

    Args:
        z: L in its lower half, in the order of elimination, [dof, dof, 2, line].
        inverse: 1/D, [dof, 2, line].
        order: see `ordered`.
        behind: see `ordered`.
        count: see `ordered`.
        row: the right-hand side, [dof].
        out: filled with y, [dof, 2, line].
        started: room for where y is not zero any more, [dof].
    """
    n, width = out.shape[0], out.shape[2]
    for i in range(n):
        started[i] = row[order[i]] != 0.0
        for p in range(width):
            out[i, 0, p], out[i, 1, p] = row[i], 0.0
    for k in range(n):
        if not started[k]:
            continue
        s, t = out[order[k], 0], out[order[k], 1]
        for place in range(count[k]):
            j = behind[k, place]
            started[j] = True
            f, g, x, y = z[j, k, 0], z[j, k, 1], out[order[j], 0], out[order[j], 1]
            for p in range(width):
                x[p] -= f[p] * s[p] - g[p] * t[p]
                y[p] -= f[p] * t[p] + g[p] * s[p]
    for k in range(n - 1, -1, -1):
        x, y, a, b = out[order[k], 0], out[order[k], 1], inverse[k, 0], inverse[k, 1]
        for p in range(width):
            x[p], y[p] = x[p] * a[p] - y[p] * b[p], x[p] * b[p] + y[p] * a[p]
        for place in range(count[k]):
            j = behind[k, place]
            f, g, s, t = z[j, k, 0], z[j, k, 1], out[order[j], 0], out[order[j], 1]
            for p in range(width):
                x[p] -= f[p] * s[p] - g[p] * t[p]
                y[p] -= f[p] * t[p] + g[p] * s[p]
