"""The loops around a kernel: fill a tile, let the kernel work on it, spread the results.

The lanes of a tile run along the frequencies of one system or, where frequencies are few, along systems.
Written for the compiler, though plain Python: `kernel` is the generated function, put into the globals by
`flexmodal.frf.kernels.compiled`. A point whose pivots are not trusted comes out as NaN.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.frf.kernels.any_size import room
from flexmodal.frf.kernels.factor import LANES

kernel: Any = None
"""Stands for the generated function of one tile."""


def sweep(parts, shared, rows, omega, extra, pairs, along, out):
    """Receptances of some systems at some frequencies.

    Args:
        parts: of each system, what its tile holds: packed M, then K, B and structural damping, each packed or
            as a diagonal; system × entry.
        shared: entries that all systems have in common, put behind those of `parts`.
        rows: Jacobian rows; system × row·n.
        omega: angular frequencies [rad/s], their number a multiple of `LANES` unless lanes run along systems.
        extra: real and imaginary halves of what is added to Z; entry × frequency, no entry if nothing is.
        pairs: numbers of the rows that make a receptance; pair × 2.
        along: lanes run along the systems instead of the frequencies.
        out: receives system × frequency × pair.

    Returns:
        How many points are not trusted.
    """
    systems, lines, count = out.shape
    n = rows.shape[1] // (1 + np.max(pairs))
    own = parts.shape[1]
    both = own + len(shared)
    tile = np.empty((1 + both + len(extra)) * LANES)
    row_tile = np.empty(rows.shape[1] * LANES)
    result = np.empty((2 * count + 1) * LANES)
    for e in range(len(shared)):
        for lane in range(LANES):
            tile[(1 + own + e) * LANES + lane] = shared[e]
    work = np.empty(room(n, rows.shape[1] // n))
    doubtful = 0
    for first in range(0, systems, LANES if along else 1):
        for lane in range(LANES):
            s = min(first + lane, systems - 1) if along else first
            for e in range(own):
                tile[(1 + e) * LANES + lane] = parts[s, e]
            for e in range(rows.shape[1]):
                row_tile[e * LANES + lane] = rows[s, e]
        for start in range(0, lines, 1 if along else LANES):
            for lane in range(LANES):
                tile[lane] = omega[start if along else start + lane]
            for e in range(len(extra)):
                for lane in range(LANES):
                    tile[(1 + both + e) * LANES + lane] = extra[e, start if along else start + lane]
            kernel(tile, row_tile, result, n, pairs, work)
            doubtful += spread(result, first, start, along, out)
    return doubtful


def spread(result, first, start, along, out):
    """Put a tile's results where they belong, NaN where they are not trusted; returns how many are not."""
    systems, lines, pairs = out.shape
    count = min(LANES, systems - first if along else lines - start)
    doubtful = 0
    for lane in range(LANES):
        doubtful += not result[2 * pairs * LANES + lane] >= 0.0
    if doubtful == 0 and count == LANES and not along:  # nearly always: one block, nothing to decide
        block = out[first, start : start + LANES]
        for place in range(pairs):
            offset = 2 * place * LANES
            for lane in range(LANES):
                block[lane, place] = complex(result[offset + lane], result[offset + LANES + lane])
        return 0
    doubtful = 0
    for lane in range(count):
        s, f = (first + lane, start) if along else (first, start + lane)
        trusted = result[2 * pairs * LANES + lane] >= 0.0
        doubtful += not trusted
        for place in range(pairs):
            re, im = result[2 * place * LANES + lane], result[(2 * place + 1) * LANES + lane]
            out[s, f, place] = complex(re, im) if trusted else complex(np.nan, np.nan)
    return doubtful
