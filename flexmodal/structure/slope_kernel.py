"""Loops over entries and lines, compiled by `solution`: receptances, and what a parameter pulls there.

Plain functions of numbers and arrays, over blocks of lines as in `solve_kernel`.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np

from flexmodal.structure.solve_kernel import WIDTH


@no_type_check
def values(table, rows, y, shift, rounding, out):
    """Fill in u y_v, exactly zero where it is nothing but rounding.

    Args:
        table: system, response row, reference row, [entry, 3].
        rows: responses, [system, row, dof].
        y: solutions, responses before references, [system, row, dof, 2, line].
        shift: number of responses.
        rounding: part of the sum of its terms' sizes up to which a value is nothing.
        out: real and imaginary parts side by side, [entry, line, 2].
    """
    n, lines = y.shape[2], y.shape[4]
    a, b, size = np.empty(lines), np.empty(lines), np.empty(lines)
    for e in range(len(table)):
        m, u, v = table[e, 0], table[e, 1], table[e, 2] + shift
        a[:], b[:], size[:] = 0.0, 0.0, 0.0
        for i in range(n):
            q, part = rows[m, u, i], abs(rows[m, u, i])
            if q == 0.0:
                continue
            s, t = y[m, v, i, 0], y[m, v, i, 1]
            for p in range(lines):
                a[p] += q * s[p]
                b[p] += q * t[p]
                size[p] += part * (abs(s[p]) + abs(t[p]))
        for p in range(lines):
            some = abs(a[p]) + abs(b[p]) > rounding * size[p]
            out[e, p, 0] = a[p] if some else 0.0
            out[e, p, 1] = b[p] if some else 0.0


@no_type_check
def push(matrices, own, kinds, factors, y, m, v, start, width, x, z, force, acts):
    """Fill in ∂Z y_v of one parameter on a block of lines.

    Args:
        matrices: see `pull`.
        own: first part of the parameter, and the end.
        kinds: see `pull`.
        factors: see there.
        y: see there.
        m: the system.
        v: its row.
        start: first line of the block.
        width: lines in it.
        x: room for a line of numbers.
        z: likewise.
        force: filled, [dof, 2, line].
        acts: whether the parameter does anything to a coordinate, filled.
    """
    n = y.shape[2]
    force[:] = 0.0
    acts[:] = False
    for part in range(own[0], own[1]):
        fr = factors[kinds[part], 0, start : start + width]
        fi = factors[kinds[part], 1, start : start + width]
        for i in range(n):
            some = False
            for j in range(n):
                q = matrices[part, m, i, j]
                if q == 0.0:
                    continue
                s, t = y[m, v, j, 0, start : start + width], y[m, v, j, 1, start : start + width]
                if some:
                    for p in range(width):
                        x[p] += q * s[p]
                        z[p] += q * t[p]
                else:
                    for p in range(width):
                        x[p], z[p] = q * s[p], q * t[p]
                    some = True
            if some:
                acts[i] = True
                g, h = force[i, 0], force[i, 1]
                for p in range(width):
                    g[p] += fr[p] * x[p] - fi[p] * z[p]
                    h[p] += fr[p] * z[p] + fi[p] * x[p]


@no_type_check
def pull(matrices, bounds, kinds, factors, y, sides, first, entries, scale, out):
    """Fill in −y_uᵀ ∂Z y_v, times a scale, for every parameter and every entry (system, u, v).

    Args:
        matrices: parts of ∂Z by parameter, [part, system, dof, dof], symmetric.
        bounds: first part of each parameter, and the end, [parameter + 1].
        kinds: number in `factors` of what each part is multiplied by, [part].
        factors: by real and imaginary part, [kind, 2, line].
        y: solutions, [system, row, dof, 2, line].
        sides: system and row v of the entries that share these, [side, 2].
        first: first entry of each side in `entries`, and the end, [side + 1].
        entries: number of an entry, and its row u, [entry, 2].
        scale: by entry, real and imaginary part, [entry, 2, line].
        out: [parameter, entry, 2, line].
    """
    n, lines = y.shape[2], y.shape[4]
    force = np.empty((n, 2, WIDTH))
    acts = np.empty(n, dtype=np.bool_)
    x, z, a, b = np.empty(WIDTH), np.empty(WIDTH), np.empty(WIDTH), np.empty(WIDTH)
    for side in range(len(sides)):
        m, v = sides[side, 0], sides[side, 1]
        for start in range(0, lines, WIDTH):
            width = min(WIDTH, lines - start)
            for parameter in range(len(bounds) - 1):
                own = bounds[parameter], bounds[parameter + 1]
                push(matrices, own, kinds, factors, y, m, v, start, width, x, z, force, acts)
                for place in range(first[side], first[side + 1]):
                    e, u = entries[place, 0], entries[place, 1]
                    for p in range(width):
                        a[p], b[p] = 0.0, 0.0
                    for i in range(n):
                        if not acts[i]:
                            continue
                        s, t = y[m, u, i, 0, start : start + width], y[m, u, i, 1, start : start + width]
                        g, h = force[i, 0], force[i, 1]
                        for p in range(width):
                            a[p] += s[p] * g[p] - t[p] * h[p]
                            b[p] += s[p] * h[p] + t[p] * g[p]
                    s, t = scale[e, 0, start : start + width], scale[e, 1, start : start + width]
                    g, h = (
                        out[parameter, e, 0, start : start + width],
                        out[parameter, e, 1, start : start + width],
                    )
                    for p in range(width):
                        g[p] = -(a[p] * s[p] - b[p] * t[p])
                        h[p] = -(a[p] * t[p] + b[p] * s[p])
