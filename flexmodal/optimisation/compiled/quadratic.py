"""The step of one iteration: a quadratic model minimised on the hold's tangent space, between the limits.

The problem and the way to its solution are those of `flexmodal.optimisation.quadratic`; here without
allocation of anything large, and with its own non-negative least squares.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np

_DEPENDENT = 1e-11
"""Share of a column left beside those before it below which it adds nothing."""

_GAIN = 1e-12
"""A column that would lessen the residual by less than this share stays out."""


def quadratic_step(model, identity, gradient, basis, lower, upper, step):
    """Minimise ½ sᵀBs + gᵀs over the span of some orthonormal rows with lower ≤ s ≤ upper.

    Args:
        model: B.
        identity: take the identity for B instead.
        gradient: g.
        basis: rows that span what is free.
        lower: 0 or less.
        upper: 0 or more.
        step: receives s.

    Returns:
        Whether B is positive definite there; `step` is of no use otherwise.
    """
    free, width = basis.shape
    step[:] = 0.0
    if free == 0:
        return True
    reach = np.empty((free, width))  # root⁻¹ · basis
    centre = np.empty(free)
    for i in range(free):
        total = 0.0
        for k in range(width):
            reach[i, k] = basis[i, k]
            total += basis[i, k] * gradient[k]
        centre[i] = total
    if not identity and not _whiten(model, basis, reach, centre):
        return False
    inside = True
    for k in range(width):
        total = 0.0
        for i in range(free):
            total -= reach[i, k] * centre[i]
        step[k] = total
        inside = inside and lower[k] <= total <= upper[k]
    if inside:
        return True
    away = np.empty(free)
    least_distance(reach, step, lower, upper, away)
    for k in range(width):
        total = step[k]
        for i in range(free):
            total += reach[i, k] * away[i]
        step[k] = min(max(total, lower[k]), upper[k])
    return True


def _whiten(model, basis, reach, centre):
    """Multiply `reach` and `centre` by the inverse of the Cholesky factor of the reduced model."""
    free, width = basis.shape
    root = np.empty((free, free))
    image = np.empty(width)
    for i in range(free):
        for k in range(width):
            total = 0.0
            for m in range(width):
                total += model[k, m] * basis[i, m]
            image[k] = total
        for j in range(i, free):
            total = 0.0
            for k in range(width):
                total += image[k] * basis[j, k]
            root[j, i] = total
    for j in range(free):
        pivot = root[j, j]
        for m in range(j):
            pivot -= root[j, m] * root[j, m]
        if not pivot > 0.0:
            return False
        root[j, j] = math.sqrt(pivot)
        for i in range(j + 1, free):
            total = root[i, j]
            for m in range(j):
                total -= root[i, m] * root[j, m]
            root[i, j] = total / root[j, j]
    for i in range(free):
        for m in range(i):
            centre[i] -= root[i, m] * centre[m]
            for k in range(width):
                reach[i, k] -= root[i, m] * reach[m, k]
        centre[i] /= root[i, i]
        for k in range(width):
            reach[i, k] /= root[i, i]
    return True


def least_distance(reach, step, lower, upper, out):
    """The shortest u that brings step + reachᵀ u between the limits.

    Through its dual, a non-negative least-squares problem (Lawson and Hanson, Solving Least Squares Problems,
    1974, chapter 23).
    """
    free, width = reach.shape
    columns = np.empty((2 * width, free + 1))
    count = 0
    for k in range(width):
        size = 0.0
        for i in range(free):
            size += reach[i, k] * reach[i, k]
        size = math.sqrt(size)
        for side in range(2):
            limit = (lower[k] - step[k]) if side == 0 else (step[k] - upper[k])
            if size > 0.0 and math.isfinite(limit):
                sign = 1.0 if side == 0 else -1.0
                for i in range(free):
                    columns[count, i] = sign * reach[i, k] / size
                columns[count, free] = limit / size
                count += 1
    residual = np.empty(free + 1)
    nonnegative(columns[:count], residual)
    for i in range(free):
        out[i] = -residual[i] / residual[free] if residual[free] != 0.0 else 0.0


def nonnegative(columns, residual):
    """Residual E x − (0, …, 0, 1) of the x ≥ 0 that makes it smallest; E is given by its columns.

    The active-set method of the same book, section 23.3.
    """
    count, size = columns.shape
    x, trial = np.zeros(count), np.empty(count)
    chosen = np.empty(size, dtype=np.int64)  # the passive set, in the order of entry
    inside, barred = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    used = 0
    for _ in range(3 * count + 3):
        _residual(columns, x, residual)
        best, most = -1, 0.0
        for j in range(count):
            if inside[j] or barred[j]:
                continue
            gain, norm = 0.0, 0.0
            for i in range(size):
                gain -= columns[j, i] * residual[i]
                norm += columns[j, i] * columns[j, i]
            gain /= math.sqrt(norm)
            if gain > most:
                best, most = j, gain
        if best < 0 or most <= _GAIN or used == size:
            break
        chosen[used] = best
        used += 1
        if not _least_squares(columns, chosen, used, trial) or trial[used - 1] <= 0.0:
            used -= 1
            barred[best] = True
            continue
        inside[best] = True
        barred[:] = False
        while True:
            share = 1.0
            for place in range(used):
                j = chosen[place]
                if trial[place] <= 0.0:
                    share = min(share, x[j] / (x[j] - trial[place]))
            left = 0
            for place in range(used):
                j = chosen[place]
                x[j] += share * (trial[place] - x[j])
                if trial[place] <= 0.0 and x[j] <= 1e-15:
                    x[j] = 0.0
                    inside[j] = False
                else:
                    chosen[left] = j
                    left += 1
            if left == used:
                break
            used = left
            if used == 0 or not _least_squares(columns, chosen, used, trial):
                break
    _residual(columns, x, residual)


def _residual(columns, x, residual):
    residual[:] = 0.0
    residual[len(residual) - 1] = -1.0
    for j in range(len(x)):
        if x[j] != 0.0:
            for i in range(len(residual)):
                residual[i] += x[j] * columns[j, i]


def _least_squares(columns, chosen, used, out):
    """Least squares with some columns only, by Gram–Schmidt; False if they depend on one another."""
    size = columns.shape[1]
    unit, triangle = np.empty((used, size)), np.zeros((used, used))
    for c in range(used):
        before = 0.0
        for i in range(size):
            unit[c, i] = columns[chosen[c], i]
            before += unit[c, i] * unit[c, i]
        for _ in range(2):
            for r in range(c):
                share = 0.0
                for i in range(size):
                    share += unit[c, i] * unit[r, i]
                triangle[r, c] += share
                for i in range(size):
                    unit[c, i] -= share * unit[r, i]
        norm = 0.0
        for i in range(size):
            norm += unit[c, i] * unit[c, i]
        if norm <= _DEPENDENT * _DEPENDENT * before:
            return False
        triangle[c, c] = math.sqrt(norm)
        for i in range(size):
            unit[c, i] /= triangle[c, c]
    for c in range(used - 1, -1, -1):
        total = unit[c, size - 1]
        for r in range(c + 1, used):
            total -= triangle[c, r] * out[r]
        out[c] = total / triangle[c, c]
    return True
