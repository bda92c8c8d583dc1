"""The logarithm of a receptance and its derivative along the joints: written for the compiler.

The cost is taken at every trial, the gradient only where a posture is kept, from what the cost left behind.
With G from d ln N = Re Σ_uv G_uv dα_uv (`flexmodal.optimisation.compiled.matrix_norm`) and z_u = Σ_v G_uv y_v
all pairs of directions are done at once:

    Σ_uv G_uv dα_uv/dq_k = Σ_u 2 (∂j_u/∂q_k) z_u + ω² y_uᵀ (∂D/∂q_k) z_u,

the latter by twists and momenta as in `flexmodal.model.batch.gradient_kernel`. A single direction takes one
sweep with √G y in place of two, with y and with G y.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np

from flexmodal.frf.kernels.pivoted import eliminate
from flexmodal.model.batch.gradient_kernel import (
    place_arm,
    row_slopes,
    solve_rows,
    sweep_momenta,
)
from flexmodal.model.batch.kinematics import mass_matrix, place_bodies
from flexmodal.optimisation.compiled.matrix_norm import FLOOR, matrix_size, size_slope

_NEGLIGIBLE = 1e-18
"""Share of a frequency in the mean below which its gradient is left out."""


def receptance_cost(chain, judge, places, room):
    """Logarithm of the mean, or of the power mean, over the frequencies; infinite where Z is singular."""
    place_bodies(chain, places.frames, places.origins, room.centres, room.inertias)
    mass_matrix(chain, places.origins, places.axes, room.centres, room.inertias, room.mass)
    pick, omega, rows, y, alpha, norms = judge.pick, judge.omega, room.rows, room.y, room.alpha, room.norms
    work, lines = (room.matrix, room.size, room.work), judge.lines
    for f in range(len(omega)):
        trusted = solve_rows(pick, judge.matrices, judge.lag[f], omega[f], room.mass, rows, work, y[f])
        if not trusted and not solve_pivoting(judge, judge.lag[f], omega[f], room, y[f]):
            return math.inf
        for u in range(len(rows)):
            for v in range(u, len(rows)):
                re, im = 0.0, 0.0
                for i in range(len(pick)):
                    re += rows[u, pick[i]] * y[f, v, 0, pick[i]]
                    im += rows[u, pick[i]] * y[f, v, 1, pick[i]]
                alpha[f, u, v] = complex(re, im)
                alpha[f, v, u] = complex(re, im)
        norms[f] = lines[f] * matrix_size(judge, alpha[f], room.powers)
        if not math.isfinite(norms[f]):
            return math.inf
    most, total = power_sum(judge.power, norms)
    return math.log(most) + math.log(total / len(omega)) / judge.power


def power_sum(power, norms):
    """The largest norm, and the sum of the powers of all as shares of it."""
    most, total = 0.0, 0.0
    for f in range(len(norms)):
        most = max(most, norms[f])
    most = math.sqrt(most * most + FLOOR)
    for f in range(len(norms)):
        total += (math.sqrt(norms[f] * norms[f] + FLOOR) / most) ** power
    return most, total


def solve_pivoting(judge, lag, w, room, y):
    """Z y = jᵀ for every row with pivoting, Z scaled to a unit diagonal of its terms' magnitudes.

    Returns:
        Whether Z is regular.
    """
    pick, matrices, mass, size = judge.pick, judge.matrices, room.mass, room.size
    rows, wide, n = room.rows, room.wide, len(judge.pick)
    for i in range(n):
        size[i] = 1.0 / math.sqrt(size[i]) if size[i] > 0.0 else 1.0
    for i in range(n):
        for j in range(n):
            re = matrices[0, i, j] - w * w * mass[pick[i], pick[j]]
            wide[i, j] = complex(re, w * matrices[1, i, j]) * (size[i] * size[j])
        wide[i, i] += complex(lag[0, i], lag[1, i]) * (size[i] * size[i])
        for r in range(len(rows)):
            wide[i, n + r] = rows[r, pick[i]] * size[i]
    if not eliminate(wide, n):
        return False
    for r in range(len(rows)):
        for i in range(n):
            value = wide[i, n + r] * size[i]
            y[r, 0, pick[i]], y[r, 1, pick[i]] = value.real, value.imag
    return True


def receptance_slope(chain, judge, columns, places, room):
    """Set `room.slope` to the derivative of the cost along the commanded joints."""
    turns, origins, axes = chain[0], places.origins, places.axes
    arms, centres, omega, norms, slope = room.arms, room.centres, judge.omega, room.norms, room.slope
    twists, momenta, weights, power, lines = room.twists, room.momenta, room.weights, judge.power, judge.lines
    for i in range(len(arms)):
        for a in range(3):
            centres[i, a] -= origins[0, a]
        place_arm(turns[i], origins[i], origins[0], axes[i], arms[i])
    slope[:] = 0.0
    most, total = power_sum(power, norms)
    for f in range(len(omega)):
        share = (math.sqrt(norms[f] * norms[f] + FLOOR) / most) ** power / total
        if share < _NEGLIGIBLE or not lines[f] > 0.0:
            continue
        size_slope(judge, room.alpha[f], norms[f] / lines[f], room.powers, weights)
        factor = -2.0 * share * omega[f] * omega[f]
        for u in range(len(room.rows)):
            sweep_pair(chain, judge, axes, room, f, u, share)
            for c in range(len(columns)):
                k = columns[c]
                change = 0.0
                for part in range(2):
                    along = force_along(turns[k], arms, axes, twists, momenta, part, k)
                    change += along if part == 0 else -along
                slope[k] += factor * change


def sweep_pair(chain, judge, axes, room, f, u, share):
    """Add the rows' part of the slope; twists and momenta whose product is the masses' part of it."""
    y, z, weights, twists, momenta = room.y[f], room.z, room.weights, room.twists, room.momenta
    arms, centres, inertias = room.arms, room.centres, room.inertias
    for i in range(y.shape[2]):
        re, im = 0.0, 0.0
        for v in range(len(y)):
            total = weights[u, v] * complex(y[v, 0, i], y[v, 1, i])
            re += total.real
            im += total.imag
        z[0, i], z[1, i] = re, im
    add_row_slopes(judge, u, 2.0 * share, z[0], room)
    if len(y) == 1:
        root = np.sqrt(weights[0, 0])
        for i in range(y.shape[2]):
            both = root * complex(y[0, 0, i], y[0, 1, i])
            z[0, i], z[1, i] = both.real, both.imag
    for part in range(2):
        sweep_momenta(chain, arms, axes, centres, inertias, z[part], twists[part], momenta[part])
        if len(y) > 1:
            sweep_momenta(chain, arms, axes, centres, inertias, y[u, part], twists[part], momenta[2])


def add_row_slopes(judge, u, factor, rates, room):
    """Add factor · (∂j_u/∂q_k) rates to the slope for all joints k."""
    row, selector, jacobians = judge.row, judge.selector, room.jacobians
    sums, turned, slope = room.sums, room.turned, room.slope
    for p in range(len(row)):
        if row[p] == u:
            row_slopes(jacobians[p], selector[p], rates, sums, turned)
            for k in range(len(slope)):
                slope[k] += factor * turned[k]


def force_along(turns, arms, axes, twists, momenta, part, k):
    """(S × V) · P for a joint's axis S = (arm, axis), a twist V = (v, ω) and a momentum P = (p, h).

    It is S · (ω × p, v × p + ω × h).
    """
    v, p, arm, axis = twists[part, k], momenta[part, k], arms[k], axes[k]
    total = arm[0] * (v[4] * p[2] - v[5] * p[1])
    total += arm[1] * (v[5] * p[0] - v[3] * p[2])
    total += arm[2] * (v[3] * p[1] - v[4] * p[0])
    if turns:
        total += axis[0] * (v[1] * p[2] - v[2] * p[1] + v[4] * p[5] - v[5] * p[4])
        total += axis[1] * (v[2] * p[0] - v[0] * p[2] + v[5] * p[3] - v[3] * p[5])
        total += axis[2] * (v[0] * p[1] - v[1] * p[0] + v[3] * p[4] - v[4] * p[3])
    return total
