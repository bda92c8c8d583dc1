"""Points whose elimination grew, solved again with pivoting: some in a hundred at light damping."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np

from flexmodal.frf.kernels.factor import SMALLEST_PIVOT


def repair(parts, shared, rows, omega, extra, pairs, out):
    """Solve every point that stands as NaN; arguments as for `flexmodal.frf.kernels.sweep.sweep`.

    Z is scaled to a unit diagonal of its terms' magnitudes first. A point that is near singular then is left
    as it stands, for whoever is to judge it.

    Returns:
        How many are left.
    """
    systems, lines, count = out.shape
    many = 1 + np.max(pairs)
    n = rows.shape[1] // many
    half = n * (n + 1) // 2
    width = n if parts.shape[1] + len(shared) == half + 3 * n else half
    both = np.empty(parts.shape[1] + len(shared))
    both[parts.shape[1] :] = shared
    work = np.empty((n, n + many), dtype=np.complex128)
    scale = np.empty(n)
    left = 0
    for s in range(systems):
        both[: parts.shape[1]] = parts[s]
        for f in range(lines):
            if not np.isnan(out[s, f, 0].real):
                continue
            w = omega[f]
            e = 0
            for i in range(n):
                for j in range(i, n):
                    re, im = -w * w * both[e], 0.0
                    size = -re
                    if width == half or i == j:
                        place = half + (e if width == half else i)
                        re += both[place]
                        im = w * both[place + width] + both[place + 2 * width]
                        size += abs(both[place])
                    if len(extra) > 0:
                        re += extra[e, f]
                        im += extra[half + e, f]
                        size += abs(extra[e, f])
                    work[i, j] = complex(re, im)
                    if i == j:
                        total = size + abs(im)
                        scale[i] = 1.0 / math.sqrt(total) if total > 0.0 else 1.0
                    e += 1
            for i in range(n):
                for j in range(i, n):
                    work[i, j] *= scale[i] * scale[j]
                    work[j, i] = work[i, j]
                for r in range(many):
                    work[i, n + r] = rows[s, r * n + i] * scale[i]
            if not eliminate(work, n):
                left += 1
                continue
            for place in range(count):
                u, v = pairs[place, 0], pairs[place, 1]
                total = 0.0j
                for i in range(n):
                    total += rows[s, u * n + i] * scale[i] * work[i, n + v]
                out[s, f, place] = total
    return left


def eliminate(work, n):
    """Solve in place for the columns from n on, with partial pivoting; False if near singular."""
    columns = work.shape[1]
    for k in range(n):
        best, size = k, -1.0
        for i in range(k, n):
            here = abs(work[i, k].real) + abs(work[i, k].imag)
            if here > size:
                best, size = i, here
        if not size >= SMALLEST_PIVOT:
            return False
        for c in range(k, columns):
            work[k, c], work[best, c] = work[best, c], work[k, c]
        for i in range(k + 1, n):
            factor = work[i, k] / work[k, k]
            for c in range(k + 1, columns):
                work[i, c] -= factor * work[k, c]
    for k in range(n - 1, -1, -1):
        for c in range(n, columns):
            for i in range(k + 1, n):
                work[k, c] -= work[k, i] * work[i, c]
            work[k, c] /= work[k, k]
    return True
