"""The step of one iteration: a quadratic model minimised on the hold's tangent space, between the limits.

Where limits are in the way, the problem is turned into one of least distance and solved through its dual by
non-negative least squares (Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23): exact, in
finitely many steps. Nothing is allocated.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

_DEPENDENT = 1e-11
"""Share of a column left beside those before it below which it adds nothing."""

_GAIN = 1e-12
"""A column that would lessen the residual by less than this share stays out."""


def quadratic_step(t, steepest, free):
    """Minimise ½ sᵀBs + gᵀs over the span of some orthonormal rows with below ≤ s ≤ above.

    Args:
        t: a `Work`, of which `model`, `gradient`, `below` and `above` are read and `step` receives s.
        steepest: 0, or what g is divided by, the identity standing in for B.
        free: rows that span what is free.

    Returns:
        Whether B is positive definite there and the limits do not drown in rounding; the step is of
        no use otherwise.
    """
    gradient, below, above, step = t.gradient, t.below, t.above, t.step
    count, width = free.shape
    step[:] = 0.0
    if count == 0:
        return True
    reach, centre = t.reach, t.centre  # root⁻¹ · free
    for i in range(count):
        total = 0.0
        for k in range(width):
            reach[i, k] = free[i, k]
            total += free[i, k] * gradient[k]
        centre[i] = total / steepest if steepest > 0.0 else total
    if steepest == 0.0 and not whiten(t.model, free, t.root, t.image, reach, centre):
        return False
    inside = True
    for k in range(width):
        total = 0.0
        for i in range(count):
            total -= reach[i, k] * centre[i]
        step[k] = total
        inside = inside and below[k] <= total <= above[k]
    if inside:
        return True
    away = t.away
    if not least_distance(t, count):
        return False
    for k in range(width):
        total = step[k]
        for i in range(count):
            total += reach[i, k] * away[i]
        step[k] = min(max(total, below[k]), above[k])
    return True


def whiten(model, free, root, image, reach, centre):
    """Multiply `reach` and `centre` by the inverse of the Cholesky factor of the reduced model."""
    count, width = free.shape
    for i in range(count):
        for k in range(width):
            total = 0.0
            for m in range(width):
                total += model[k, m] * free[i, m]
            image[k] = total
        for j in range(i, count):
            total = 0.0
            for k in range(width):
                total += image[k] * free[j, k]
            root[j, i] = total
    for j in range(count):
        pivot = root[j, j]
        for m in range(j):
            pivot -= root[j, m] * root[j, m]
        if not pivot > 0.0:
            return False
        root[j, j] = math.sqrt(pivot)
        for i in range(j + 1, count):
            total = root[i, j]
            for m in range(j):
                total -= root[i, m] * root[j, m]
            root[i, j] = total / root[j, j]
    for i in range(count):
        for m in range(i):
            centre[i] -= root[i, m] * centre[m]
            for k in range(width):
                reach[i, k] -= root[i, m] * reach[m, k]
        centre[i] /= root[i, i]
        for k in range(width):
            reach[i, k] /= root[i, i]
    return True


def least_distance(t, free):
    """Set `t.away` to the shortest u that brings step + reachᵀ u between the limits.

    Through its dual, a non-negative least-squares problem (Lawson and Hanson, Solving Least Squares Problems,
    1974, chapter 23). False where rounding has taken the limits away.
    """
    reach, step, below, above, columns = t.reach, t.step, t.below, t.above, t.columns
    residual, away = t.residual[: free + 1], t.away
    count = 0
    for k in range(len(step)):
        size = 0.0
        for i in range(free):
            size += reach[i, k] * reach[i, k]
        size = math.sqrt(size)
        for side in range(2):
            limit = (below[k] - step[k]) if side == 0 else (step[k] - above[k])
            if size > 0.0 and math.isfinite(limit):
                sign = 1.0 if side == 0 else -1.0
                for i in range(free):
                    columns[count, i] = sign * reach[i, k] / size
                columns[count, free] = limit / size
                count += 1
    nonnegative(t, columns[:count, : free + 1], residual)
    if residual[free] >= 0.0:
        return False
    for i in range(free):
        away[i] = -residual[i] / residual[free]
    return True


def nonnegative(t, columns, residual):
    """Residual E x − (0, …, 0, 1) of the x ≥ 0 that makes it smallest; E is given by its columns.

    The active-set method of the same book, section 23.3.
    """
    count, size = columns.shape
    x, trial, chosen, inside, barred = t.x, t.solved, t.chosen, t.inside, t.barred
    x[:], inside[:], barred[:] = 0.0, False, False
    used = 0  # the passive set, in the order of entry
    for _ in range(3 * count + 3):
        leave(columns, x, residual)
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
        if not least_squares(t, columns, used) or trial[used - 1] <= 0.0:
            used -= 1
            barred[best] = True
            continue
        inside[best] = True
        barred[:] = False
        used = step_back(t, columns, used)
    leave(columns, x, residual)


def step_back(t, columns, used):
    """Go towards the least-squares solution as far as x stays positive; drop what met zero, and again."""
    x, trial, chosen, inside = t.x, t.solved, t.chosen, t.inside
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
        if left == used or left == 0 or not least_squares(t, columns, left):
            return left
        used = left


def leave(columns, x, residual):
    """Set the residual E x − (0, …, 0, 1)."""
    residual[:] = 0.0
    residual[len(residual) - 1] = -1.0
    for j in range(len(columns)):
        if x[j] != 0.0:
            for i in range(len(residual)):
                residual[i] += x[j] * columns[j, i]


def least_squares(t, columns, used):
    """Least squares with the chosen columns only, by Gram–Schmidt; False if they depend on one another."""
    unit, triangle, chosen, out = t.unit, t.triangle, t.chosen, t.solved
    size = columns.shape[1]
    triangle[:] = 0.0
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
