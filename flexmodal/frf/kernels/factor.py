"""The kernel for few coordinates: LDLᵀ without pivoting, its size fixed when compiled, one lane a point.

For the complex symmetric Z = LDLᵀ (L unit lower triangular, D diagonal) and rows u, v

    α_uv = u Z⁻¹ vᵀ = Σ_k (L⁻¹uᵀ)_k (L⁻¹vᵀ)_k / D_k,

so a forward elimination is all that is needed, on Z and on the rows together. With K and B diagonal all
entries of Z beside the diagonal are real, −ω²D_ij, and the first elimination step costs half.

Without pivoting the elimination can grow: where a part of the chain, the rest held, resonates with little
damping, a pivot comes out small and the next one large, and digits are lost in between. Nowhere else: the
pivots of a positive definite matrix only shrink. So a pivot much larger than its own row began betrays it;
the kernel watches for one, `trust` below 0, and such points are solved again with pivoting. A last pivot
next to nothing says that Z may be singular, which is for the caller to judge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Inexact, Int

from flexmodal.frf.kernels.emitter import Emitter, Number

LANES = 32
"""Points worked on together: some vectors' worth, few enough for a tile to stay in the first-level cache."""

LARGEST = 8
"""Most coordinates of a kernel of this kind; beyond, the code outgrows what a compiler does well."""

GROWTH = 10.0
"""A pivot larger than this times |K_kk| + ω²M_kk + ωB_kk is not trusted: a digit of sixteen may be gone."""

SMALLEST_PIVOT = 1e-8
"""A last pivot smaller than this share of the same is not trusted either."""

Pairs = tuple[tuple[int, int], ...]
"""Which rows make a receptance: numbers of the response's and of the reference's row."""


def packed(i: int, j: int, n: int) -> int:
    """Place of entry (i, j), i ≤ j, of a symmetric matrix whose upper half is stored row by row.

    Args:
        i: row.
        j: column, not below i.
        n: size of the matrix.
    """
    return i * n - i * (i - 1) // 2 + j - i


def pack(matrices: Inexact[np.ndarray, "matrix n n"]) -> Inexact[np.ndarray, "matrix entry"]:
    """The upper halves of symmetric matrices, in the order of `packed`."""
    count, n, _ = matrices.shape
    return matrices.reshape(count, n * n).take(_upper(n), axis=1)


@cache
def _upper(n: int) -> Int[np.ndarray, " entry"]:
    """Places of the upper half in a matrix stored row by row; finding them takes longer than a small task."""
    rows, columns = np.triu_indices(n)
    places = rows * n + columns
    places.flags.writeable = False
    return places


def row_count(pairs: Pairs) -> int:
    """How many rows the pairs speak of."""
    return 1 + max(max(pair) for pair in pairs)


@dataclass(frozen=True)
class Shape:
    """What a kernel is made for."""

    n: int
    """Coordinates."""
    pairs: Pairs
    diagonal: bool
    """K, B and the structural damping are diagonal; else any symmetric matrices."""
    extra: bool = False
    """Something is added to Z that depends on the frequency otherwise; not with `diagonal`."""


def write_kernel(shape: Shape) -> tuple[str, int]:
    """Source of `kernel(tile, rows, out, n, pairs, work)`, which works on one tile of points.

    Entry e of a point's input stands at tile[e·LANES + p]: ω, then M (packed), K, B, structural damping
    (packed, or their diagonals), then the real and the imaginary half of the addition. `rows` holds row
    r's entry i at (r·n + i)·LANES; `out` receives for each pair the real and the imaginary part, and last
    the trust. The three last arguments are for the kernel of any size and are not looked at.

    Args:
        shape: what the kernel is for.

    Returns:
        The source, and the floating-point operations of one point.
    """
    code = Emitter()
    n = shape.n
    matrix, sizes = _dynamic_stiffness(code, shape)
    rows = [
        [Number(code.scalar(f"rows[{(r * n + i) * LANES}+p]")) for i in range(n)]
        for r in range(row_count(shape.pairs))
    ]
    results: list[Number | None] = [None] * len(shape.pairs)
    trust = code.scalar("1.0")
    for k in range(n):
        inverse, square = code.inverse(matrix[k, k])
        if k > 0:  # the first is an entry of Z as it was
            room = code.scalar(f"{GROWTH**2!r} * {sizes[k]} * {sizes[k]} - {square}")
            trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
        if k == n - 1:
            room = code.scalar(f"{square} - {SMALLEST_PIVOT**2!r} * {sizes[k]} * {sizes[k]}")
            trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
        scaled = [code.times(row[k], inverse) for row in rows]
        for place, (u, v) in enumerate(shape.pairs):
            results[place] = code.plus_times(results[place], scaled[u], rows[v][k])
        for j in range(k + 1, n):
            factor = code.times(matrix[k, j], inverse)
            for i in range(j, n):
                matrix[j, i] = code.minus_times(matrix[j, i], factor, matrix[k, i])
            for row in rows:
                row[j] = code.minus_times(row[j], factor, row[k])
    for place, result in enumerate(results):
        assert result is not None
        code.lines.append(f"out[{2 * place * LANES}+p] = {result.re}")
        code.lines.append(f"out[{(2 * place + 1) * LANES}+p] = {result.im}")
    code.lines.append(f"out[{2 * len(shape.pairs) * LANES}+p] = {trust}")
    body = "\n".join(f"        {line}" for line in code.lines)
    return f"def kernel(tile, rows, out, n, pairs, work):\n    for p in range({LANES}):\n{body}\n", code.flops


def _dynamic_stiffness(code: Emitter, shape: Shape) -> tuple[dict[tuple[int, int], Number], list[str]]:
    """The upper half of Z, and the size |K_kk| + ω²M_kk + ωB_kk of each of its rows."""
    n = shape.n
    half = n * (n + 1) // 2
    width = n if shape.diagonal else half

    def load(row: int) -> str:
        return code.scalar(f"tile[{row * LANES}+p]")

    omega = load(0)
    minus = code.scalar(f"-{omega} * {omega}")
    matrix, sizes = {}, []
    for i in range(n):
        for j in range(i, n):
            inertia = code.scalar(f"{minus} * {load(1 + packed(i, j, n))}")
            if shape.diagonal and i < j:
                matrix[i, j] = Number(inertia)
                continue
            place = i if shape.diagonal else packed(i, j, n)
            spring, damper, loss = (load(1 + half + part * width + place) for part in range(3))
            re, im = code.scalar(f"{spring} + {inertia}"), code.scalar(f"{loss} + {omega} * {damper}")
            size = code.scalar(f"{spring} - {inertia} + {im}") if i == j else ""
            if shape.extra:
                more = load(1 + half + 3 * width + packed(i, j, n))
                re = code.scalar(f"{re} + {more}")
                im = code.scalar(f"{im} + {load(1 + 2 * half + 3 * width + packed(i, j, n))}")
                size = code.scalar(f"{spring} - {inertia} + abs({more}) + abs({im})") if i == j else ""
            matrix[i, j] = Number(re, im)
            if i == j:
                sizes.append(size)
    return matrix, sizes
