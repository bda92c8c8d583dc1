"""Receptance and its derivative along every joint, for many postures: written for the compiler.

With y = Z⁻¹jᵀ solved once for each row,

    dα_uv/dq_k = (∂j_u/∂q_k) y_v + y_uᵀ(∂j_vᵀ/∂q_k) + ω² y_uᵀ (∂D/∂q_k) y_v.

Let the joints move at the (complex) rates y. Body l then has the twist V_l = Σ_{i≤l} S_i y_i and all
bodies from k outwards have the momentum P_k = Σ_{l≥k} I_l V_l. Turning joint k carries the bodies behind
it and the axes behind it along, S_i → S_k × S_i, and leaves the twist V_k itself behind, so that

    y_uᵀ (∂D/∂q_k) y_v = −(S_k × V_k(y_u)) · P_k(y_v) − (S_k × V_k(y_v)) · P_k(y_u):

two sweeps along the chain instead of a tensor. For the rows the same argument gives sums over the joints
before k and from k on (see `flexmodal.model.gradient.jacobian_derivative`). Twists and momenta are taken
about the first joint's origin. The sweeps are linear, so the real and the imaginary part of y go through
them one by one.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np

from flexmodal.model.batch.factor import factor_symmetric, solve_factored
from flexmodal.model.batch.kinematics import (
    mass_matrix,
    place_bodies,
    place_joints,
    point_jacobian,
)
from flexmodal.model.batch.tile import TILE, factor_tile, fill_lane, solve_tile


def place_arm(turns, origin, first, axis, out):
    """Linear part of a joint's twist at unit rate about the first joint's origin."""
    if turns:
        x, y, z = origin[0] - first[0], origin[1] - first[1], origin[2] - first[2]
        out[0] = y * axis[2] - z * axis[1]
        out[1] = z * axis[0] - x * axis[2]
        out[2] = x * axis[1] - y * axis[0]
    else:
        out[0], out[1], out[2] = axis[0], axis[1], axis[2]


def sweep_momenta(chain, arms, axes, centres, inertias, y, twists, momenta):
    """Twist of every body when the joints move at rates y, and the momentum of it and all behind it.

    Both about the first joint's origin, linear part first; `arms` are the joints' own linear parts there.
    """
    turns, mass = chain[0], chain[4]
    count = len(y)
    for i in range(count):
        for a in range(3):
            twists[i, a] = arms[i, a] * y[i]
            twists[i, 3 + a] = axes[i, a] * y[i] if turns[i] else 0.0
            if i > 0:
                twists[i, a] += twists[i - 1, a]
                twists[i, 3 + a] += twists[i - 1, 3 + a]
    for i in range(count - 1, -1, -1):
        v, c = twists[i], centres[i]
        x = mass[i] * (v[0] + v[4] * c[2] - v[5] * c[1])
        z = mass[i] * (v[1] + v[5] * c[0] - v[3] * c[2])
        w = mass[i] * (v[2] + v[3] * c[1] - v[4] * c[0])
        p = momenta[i]
        p[0], p[1], p[2] = x, z, w
        p[3] = c[1] * w - c[2] * z
        p[4] = c[2] * x - c[0] * w
        p[5] = c[0] * z - c[1] * x
        for a in range(3):
            for b in range(3):
                p[3 + a] += inertias[i, a, b] * v[3 + b]
        if i < count - 1:
            for a in range(6):
                p[a] += momenta[i + 1, a]


def mass_slope(turns, arm, axis, twists, momenta, k):
    """(S × V_k) · P_k for one joint, S = (arm, axis), with V and P complex in two parts."""
    re, im = 0.0, 0.0
    real, imaginary = momenta[0, k], momenta[1, k]
    for part in range(2):
        v = twists[part, k]
        x0 = arm[1] * v[5] - arm[2] * v[4]
        x1 = arm[2] * v[3] - arm[0] * v[5]
        x2 = arm[0] * v[4] - arm[1] * v[3]
        x3 = x4 = x5 = 0.0
        if turns:
            x0 += axis[1] * v[2] - axis[2] * v[1]
            x1 += axis[2] * v[0] - axis[0] * v[2]
            x2 += axis[0] * v[1] - axis[1] * v[0]
            x3 = axis[1] * v[5] - axis[2] * v[4]
            x4 = axis[2] * v[3] - axis[0] * v[5]
            x5 = axis[0] * v[4] - axis[1] * v[3]
        p = real
        with_re = x0 * p[0] + x1 * p[1] + x2 * p[2] + x3 * p[3] + x4 * p[4] + x5 * p[5]
        p = imaginary
        with_im = x0 * p[0] + x1 * p[1] + x2 * p[2] + x3 * p[3] + x4 * p[4] + x5 * p[5]
        re += -with_im if part else with_re
        im += with_re if part else with_im
    return complex(re, im)


def row_slopes(jacobian, selector, y, scratch, slopes):
    """Set (∂j/∂q_k) y for all k, with j = selector · jacobian; y real."""
    count = len(y)
    carried, spun = scratch[:6], scratch[6:]  # Σ over the joints from k on; Σ of the turning parts before k
    scratch[:] = 0.0
    for i in range(count):
        for a in range(3):
            spun[a] += jacobian[3 + a, i] * y[i]
    s = selector
    for k in range(count - 1, -1, -1):
        x, y0, z = jacobian[3, k], jacobian[4, k], jacobian[5, k]
        for a in range(6):
            carried[a] += jacobian[a, k] * y[k]
        for a in range(3):
            spun[a] -= jacobian[3 + a, k] * y[k]
        c, t = carried, spun
        value = s[0] * (y0 * c[2] - z * c[1] + t[1] * jacobian[2, k] - t[2] * jacobian[1, k])
        value += s[1] * (z * c[0] - x * c[2] + t[2] * jacobian[0, k] - t[0] * jacobian[2, k])
        value += s[2] * (x * c[1] - y0 * c[0] + t[0] * jacobian[1, k] - t[1] * jacobian[0, k])
        value += s[3] * (y0 * c[5] - z * c[4]) + s[4] * (z * c[3] - x * c[5]) + s[5] * (x * c[4] - y0 * c[3])
        slopes[k] = value


def gradient_batch(
    chain, joints, offsets, selectors, pick, matrices, lag, postures, omega, pairs, values, slopes
):
    """Receptances and their derivatives along all joints.

    Args:
        chain: arrays of a `Chain`.
        joints: carrier of each row's point.
        offsets: of the points in the carriers' frames.
        selectors: directions of the rows.
        pick: which joints are flexible.
        matrices: K and B.
        lag: what hysteresis adds to the diagonal of Z, real and imaginary part; frequency × 2 × flexible.
        postures: angles and lengths of all joints; posture × joint.
        omega: angular frequencies [rad/s].
        pairs: numbers of the rows that make a receptance; pair × 2.
        values: receives posture × frequency × pair.
        slopes: receives posture × frequency × pair × joint.

    Returns:
        How many points are not trusted; they are NaN.
    """
    count, n, many = postures.shape[1], len(pick), len(joints)
    bodies = (
        np.empty((TILE, count, 3, 3)), np.empty((TILE, count, 3)), np.empty((TILE, count, 3)),
        np.empty((TILE, count, 3)), np.empty((TILE, count, 3, 3)), np.empty((TILE, count, 3)),
        np.empty((TILE, count, count)),
    )  # fmt: skip
    row_room = np.empty((TILE, many, 6, count)), np.empty((TILE, many, count)), np.empty(3)
    matrix_room = (
        np.empty((n, n, 2, TILE)), np.empty((n, TILE)), np.empty(TILE), np.empty((many, n, 2, TILE))
    )  # fmt: skip
    sweep_room = (
        np.zeros((many, 2, count)), np.empty((many, 2, count, 6)), np.empty((many, 2, count, 6)),
        np.empty((2, count)), np.empty(9),
    )  # fmt: skip
    trust, solved, lines = matrix_room[2], matrix_room[3], len(omega)
    points = len(postures) * lines
    posed, doubtful = -1, 0
    for start in range(0, points, TILE):
        for lane in range(TILE):
            point = min(start + lane, points - 1)
            s, f = point // lines, point % lines
            if s > posed:
                pose_rows(chain, joints, offsets, selectors, postures[s], s % TILE, bodies, row_room)
                posed = s
            fill_rows(pick, matrices, lag[f], omega[f], s % TILE, lane, bodies, row_room, matrix_room)
        factor_tile(matrix_room[0], matrix_room[1], trust)
        for r in range(many):
            solve_tile(matrix_room[0], solved[r])
        doubtful += hand_out(
            chain, selectors, pick, pairs, omega, start, bodies, row_room, matrix_room, sweep_room,
            values, slopes,
        )  # fmt: skip
    return doubtful


def hand_out(
    chain, selectors, pick, pairs, omega, start, bodies, row_room, matrix_room, sweep_room, values, slopes
):
    """Receptances and derivatives of a tile's points; returns how many are not trusted."""
    trust, solved, y = matrix_room[2], matrix_room[3], sweep_room[0]
    lines, doubtful = len(omega), 0
    for point in range(start, min(start + TILE, len(values) * lines)):
        s, f, lane = point // lines, point % lines, point - start
        for r in range(len(solved)):
            for i in range(len(pick)):
                y[r, 0, pick[i]], y[r, 1, pick[i]] = solved[r, i, 0, lane], solved[r, i, 1, lane]
        trusted = trust[lane] >= 0.0
        doubtful += not trusted
        sweep_rows(chain, s % TILE, bodies, sweep_room)
        gradients(
            chain, selectors, pairs, omega[f], trusted, s % TILE, bodies, row_room, sweep_room,
            values[s, f], slopes[s, f],
        )  # fmt: skip
    return doubtful


def pose_rows(chain, joints, offsets, selectors, posture, slot, bodies, row_room):
    """Place joints and bodies; mass matrix, Jacobians and rows. Centres are then about the first origin."""
    frames, origins, axes = bodies[0][slot], bodies[1][slot], bodies[2][slot]
    centres, inertias, arms, full = bodies[3][slot], bodies[4][slot], bodies[5][slot], bodies[6][slot]
    jacobians, rows, position = row_room[0][slot], row_room[1][slot], row_room[2]
    place_joints(chain, posture, frames, origins, axes)
    place_bodies(chain, frames, origins, centres, inertias)
    mass_matrix(chain, origins, axes, centres, inertias, full)
    for r in range(len(joints)):
        point_jacobian(chain, frames, origins, axes, joints[r], offsets[r], position, jacobians[r])
        for i in range(len(posture)):
            value = 0.0
            for a in range(6):
                value += selectors[r, a] * jacobians[r, a, i]
            rows[r, i] = value
    turns = chain[0]
    for i in range(len(posture)):
        for a in range(3):
            centres[i, a] -= origins[0, a]
        place_arm(turns[i], origins[i], origins[0], axes[i], arms[i])


def fill_rows(pick, matrices, lag, w, slot, lane, bodies, row_room, matrix_room):
    """Z of one point and all rows into their lane."""
    rows, solved = row_room[1][slot], matrix_room[3]
    fill_lane(pick, matrices, lag, w, bodies[6][slot], lane, matrix_room[0], matrix_room[1])
    for r in range(len(rows)):
        for i in range(len(pick)):
            solved[r, i, 0, lane], solved[r, i, 1, lane] = rows[r, pick[i]], 0.0


def solve_rows(pick, matrices, lag, w, full, rows, matrix_room, y):
    """Z y = jᵀ for every row at an angular frequency; whether the pivots are trusted."""
    matrix, size, work = matrix_room
    for i in range(len(pick)):
        for j in range(i, len(pick)):
            mass = full[pick[i], pick[j]]
            matrix[i, j] = complex(matrices[0, i, j] - w * w * mass, w * matrices[1, i, j])
        matrix[i, i] += complex(lag[0, i], lag[1, i])
        size[i] = matrices[0, i, i] + lag[0, i] + w * w * full[pick[i], pick[i]] + matrix[i, i].imag
    trusted = factor_symmetric(matrix, size)
    for r in range(len(rows)):
        solve_factored(matrix, rows[r], pick, work, y[r])
    return trusted


def sweep_rows(chain, slot, bodies, sweep_room):
    """Twists and momenta of every row's rates, real and imaginary parts one by one."""
    axes, centres, inertias, arms = bodies[2][slot], bodies[3][slot], bodies[4][slot], bodies[5][slot]
    y, twists, momenta = sweep_room[0], sweep_room[1], sweep_room[2]
    for r in range(len(y)):
        for part in range(2):
            sweep_momenta(chain, arms, axes, centres, inertias, y[r, part], twists[r, part], momenta[r, part])


def gradients(chain, selectors, pairs, w, trusted, slot, bodies, row_room, sweep_room, values, slopes):
    """Receptances and their derivatives of all pairs at one posture and frequency."""
    turns, axes, arms = chain[0], bodies[2][slot], bodies[5][slot]
    jacobians, rows = row_room[0][slot], row_room[1][slot]
    y, twists, momenta, turned, scratch = sweep_room
    for place in range(len(pairs)):
        u, v = pairs[place, 0], pairs[place, 1]
        re, im = 0.0, 0.0
        for i in range(len(turns)):
            re += rows[u, i] * y[v, 0, i]
            im += rows[u, i] * y[v, 1, i]
        values[place] = complex(re, im) if trusted else complex(np.nan, np.nan)
        # A drive point is the same from both sides: take one and double it.
        sides = 1 if u == v else 2
        for k in range(len(turns)):
            slopes[place, k] = 0.0
        for side in range(sides):
            left, right = (u, v) if side == 0 else (v, u)
            for part in range(2):
                row_slopes(jacobians[left], selectors[left], y[right, part], scratch, turned[part])
            for k in range(len(turns)):
                change = mass_slope(turns[k], arms[k], axes[k], twists[left], momenta[right], k)
                re = turned[0, k] - w * w * change.real
                im = turned[1, k] - w * w * change.imag
                slopes[place, k] += (3 - sides) * complex(re, im)
