"""Receptance with its first and second derivatives along the joints: written for the compiler.

Let y_u = Z⁻¹j_uᵀ, and b_u,k = ∂j_uᵀ/∂q_k + ω² (∂D/∂q_k) y_u, so that ∂y_u/∂q_k = Z⁻¹ b_u,k. Then

    ∂²α_uv/∂q_k∂q_l = (∂²j_u) y_v + (∂²j_v) y_u + ω² y_uᵀ (∂²D) y_v + b_u,kᵀ Z⁻¹ b_v,l + b_v,kᵀ Z⁻¹ b_u,l.

With axes S, twists V_k(y) and momenta P_k(y) as in `flexmodal.model.batch_gradient`, I_k the inertia of all
bodies from k outwards, W_k = S_k × V_k the change of the twist that turning joint k leaves behind, and
R_k = I_k W_k − S_k ×* P_k that of the momentum, the masses' part needs no tensor: for l ≤ k

    y_uᵀ (∂²D/∂q_k∂q_l) y_v = W_l(y_u) · R_k(y_v) + W_l(y_v) · R_k(y_u),
    ((∂D/∂q_k) y)_i         = −(I_i S_i) · W_k  for i ≥ k,  −S_i · R_k  for i < k,
    y_uᵀ (∂D/∂q_k) y_v      = −W_k(y_u) · P_k(y_v) − W_k(y_v) · P_k(y_u).

The rows: with columns (v_i, w_i) of the point's Jacobian, C_k and Ω_k the sums of v_i y_i and w_i y_i from k
outwards and Ω' that of w_i y_i before k, the derivative along k is F_k = w_k × C_k + Ω'_k × v_k (turning
part: w_k × Ω_k), and that along l ≤ k of it w_l × F_k − (w_l × Ω'_l) × v_k (w_l × (w_k × Ω_k)).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np

from flexmodal.frf.kernels.pivoted import eliminate
from flexmodal.model.batch_gradient import place_arm
from flexmodal.model.batch_kinematics import cross, mass_matrix, place_bodies, place_joints, point_jacobian
from flexmodal.model.batch_twists import apply_inertia, cross_momentum, cross_twist, dot, gather_inertias


def invert(matrices, lag, w, mass, pick, wide, inverse):
    """Z⁻¹ with pivoting, Z scaled to a unit diagonal of its terms' magnitudes; whether Z is regular."""
    n = len(pick)
    for i in range(n):
        inertia = w * w * mass[pick[i], pick[i]]
        size = abs(matrices[0, i, i] + lag[0, i]) + inertia + abs(w * matrices[1, i, i] + lag[1, i])
        inverse[i, i] = 1.0 / math.sqrt(size) if size > 0.0 else 1.0
    for i in range(n):
        for j in range(n):
            re = matrices[0, i, j] - w * w * mass[pick[i], pick[j]]
            scale = inverse[i, i].real * inverse[j, j].real
            wide[i, j] = complex(re, w * matrices[1, i, j]) * scale
            wide[i, n + j] = 0.0
        own = inverse[i, i].real
        wide[i, i] += complex(lag[0, i], lag[1, i]) * (own * own)
        wide[i, n + i] = own
    if not eliminate(wide, n):
        return False
    for i in range(n):
        scale = inverse[i, i].real
        for j in range(n):
            inverse[i, j] = wide[i, n + j] * scale
    return True


def sweep_second(twists, inertias, y, momenta, left, gone, work):
    """P_k, W_k and R_k of all joints when they move at rates y.

    Args:
        twists: S of all joints.
        inertias: of all bodies from each joint outwards.
        y: rates.
        momenta: receives P.
        left: receives W.
        gone: receives R.
        work: V and two more twists.
    """
    speed, some, other = work[0], work[1], work[2]
    speed[:] = 0.0
    momenta[:] = 0.0
    for k in range(len(y)):
        for a in range(6):
            some[a] = twists[k, a] * y[k]
            speed[a] += some[a]
        cross_twist(twists[k], speed, left[k])
        for b in range(len(y)):  # of joint k's own part: from b outwards what lies beyond both
            apply_inertia(inertias[max(b, k)], some, other)
            for a in range(6):
                momenta[b, a] += other[a]
    for k in range(len(y)):
        apply_inertia(inertias[k], left[k], gone[k])
        cross_momentum(twists[k], momenta[k], some)
        for a in range(6):
            gone[k, a] -= some[a]


def row_second(jacobian, selector, y, slope, second, work):
    """Set (∂j/∂q_k) y and (∂²j/∂q_k∂q_l) y, with j = selector · jacobian."""
    count = len(y)
    sums, before, moved, some, other = work[0], work[1, :3], work[2], work[3, :3], work[4, :3]
    sums[:] = 0.0
    for i in range(count):
        for a in range(6):
            sums[a] += jacobian[a, i] * y[i]
    before[:] = 0.0
    for k in range(count):
        v, w = jacobian[:3, k], jacobian[3:, k]
        cross(w, sums[:3], moved[:3])
        cross(before, v, some)
        for a in range(3):
            moved[a] += some[a]
        cross(w, sums[3:], moved[3:])
        slope[k] = dot(selector, moved)
        other[:] = 0.0  # Ω' at the joint l
        for i in range(k + 1):
            axis = jacobian[3:, i]
            cross(axis, other, some)
            turned = some[0] * (v[1] * selector[2] - v[2] * selector[1])
            turned += some[1] * (v[2] * selector[0] - v[0] * selector[2])
            turned += some[2] * (v[0] * selector[1] - v[1] * selector[0])
            cross(axis, moved[:3], some)
            total = dot(selector[:3], some) - turned
            cross(axis, moved[3:], some)
            total += dot(selector[3:], some)
            second[k, i] = total
            second[i, k] = total
            for a in range(3):
                other[a] += axis[a] * y[i]
        for a in range(6):
            sums[a] -= jacobian[a, k] * y[k]
        for a in range(3):
            before[a] += w[a] * y[k]


def row_change(jacobian, selector, pick, out, some):
    """Set ∂j_i/∂q_k of the flexible joints i along all joints k."""
    for place in range(len(pick)):
        i = pick[place]
        for k in range(jacobian.shape[1]):
            if k <= i:
                cross(jacobian[3:, k], jacobian[:3, i], some)
                total = dot(selector[:3], some)
                cross(jacobian[3:, k], jacobian[3:, i], some)
                total += dot(selector[3:], some)
            else:
                cross(jacobian[3:, i], jacobian[:3, k], some)
                total = dot(selector[:3], some)
            out[place, k] = total.real


def pose_second(chain, joints, offsets, selectors, pick, posture, bodies, axes_room, row_room):
    """Place joints and bodies; mass matrix, I_k and I_k S_k of all joints, Jacobians and how rows change."""
    frames, origins, axes, centres, inertias, mass, position, some = bodies
    twists, gathered, drives = axes_room
    jacobians, changes = row_room
    place_joints(chain, posture, frames, origins, axes)
    place_bodies(chain, frames, origins, centres, inertias)
    mass_matrix(chain, origins, axes, centres, inertias, mass)
    for i in range(len(posture)):
        for a in range(3):
            centres[i, a] -= origins[0, a]
            twists[i, 3 + a] = axes[i, a] if chain[0][i] else 0.0
        place_arm(chain[0][i], origins[i], origins[0], axes[i], twists[i])
    gather_inertias(chain[4], centres, inertias, gathered)
    for i in range(len(posture)):
        apply_inertia(gathered[i], twists[i], drives[i])
    for r in range(len(joints)):
        point_jacobian(chain, frames, origins, axes, joints[r], offsets[r], position, jacobians[r])
        row_change(jacobians[r], selectors[r], pick, changes[r], some)


def solve_second(selector, pick, w, inverse, r, axes_room, row_room, sweeps, work):
    """A row's y, what it moves, b_k and Z⁻¹ b_k of all joints k."""
    twists, gathered, drives = axes_room
    jacobian, changes = row_room[0][r], row_room[1][r]
    y, momenta, left, gone = sweeps[0][r], sweeps[1][r], sweeps[2][r], sweeps[3][r]
    drive, moved = sweeps[4][r], sweeps[5][r]
    n, count = len(pick), len(y)
    for i in range(n):
        total = 0.0j
        for j in range(n):
            for a in range(6):
                total += inverse[i, j] * (selector[a] * jacobian[a, pick[j]])
        y[pick[i]] = total
    sweep_second(twists, gathered, y, momenta, left, gone, work)
    for i in range(n):
        for k in range(count):
            pulled = dot(drives[pick[i]], left[k]) if k <= pick[i] else dot(twists[pick[i]], gone[k])
            drive[i, k] = changes[i, k] - w * w * pulled
    for i in range(n):
        for k in range(count):
            total = 0.0j
            for j in range(n):
                total += inverse[i, j] * drive[j, k]
            moved[i, k] = total


def pair_second(selectors, w, u, v, jacobians, sweeps, change, work, first, curved):
    """α_uv; its first and second derivatives go to `first` and `curved`."""
    y, momenta, left, gone, drive, moved = sweeps
    slope, second = change
    count = len(first)
    value = 0.0j
    for i in range(count):
        for a in range(6):
            value += selectors[u, a] * jacobians[u, a, i] * y[v, i]
    first[:] = 0.0
    curved[:] = 0.0
    for side in range(2):
        here, there = (u, v) if side == 0 else (v, u)
        row_second(jacobians[here], selectors[here], y[there], slope, second, work)
        for k in range(count):
            first[k] += slope[k] - w * w * dot(left[here, k], momenta[there, k])
            for i in range(k + 1):
                total = second[k, i] + w * w * dot(left[here, i], gone[there, k])
                for j in range(drive.shape[1]):
                    total += drive[here, j, k] * moved[there, j, i]
                curved[k, i] += total
    for k in range(count):
        for i in range(k):
            curved[i, k] = curved[k, i]
    return value


def second_batch(
    chain, joints, offsets, selectors, pick, matrices, lag, postures, omega, pairs, values, slopes, seconds
):
    """Receptances, their derivatives and second derivatives along all joints.

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
        seconds: receives posture × frequency × pair × joint × joint.

    Returns:
        How many points are singular; they are NaN.
    """
    count, n, many = postures.shape[1], len(pick), len(joints)
    bodies = (
        np.empty((count, 3, 3)), np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3)),
        np.empty((count, 3, 3)), np.empty((count, count)), np.empty(3), np.empty(3),
    )  # fmt: skip
    axes_room = np.zeros((count, 6)), np.empty((count, 10)), np.empty((count, 6))
    row_room = np.empty((many, 6, count)), np.empty((many, n, count))
    wide, inverse = np.empty((n, 2 * n), dtype=np.complex128), np.empty((n, n), dtype=np.complex128)
    sweeps = (
        np.zeros((many, count), dtype=np.complex128), np.empty((many, count, 6), dtype=np.complex128),
        np.empty((many, count, 6), dtype=np.complex128), np.empty((many, count, 6), dtype=np.complex128),
        np.empty((many, n, count), dtype=np.complex128), np.empty((many, n, count), dtype=np.complex128),
    )  # fmt: skip
    change = np.empty(count, dtype=np.complex128), np.empty((count, count), dtype=np.complex128)
    work = np.empty((5, 6), dtype=np.complex128)
    singular = 0
    for s in range(len(postures)):
        pose_second(chain, joints, offsets, selectors, pick, postures[s], bodies, axes_room, row_room)
        for f in range(len(omega)):
            w = omega[f]
            if not invert(matrices, lag[f], w, bodies[5], pick, wide, inverse):
                singular += 1
                values[s, f], slopes[s, f], seconds[s, f] = np.nan, np.nan, np.nan
                continue
            for r in range(many):
                solve_second(selectors[r], pick, w, inverse, r, axes_room, row_room, sweeps, work)
            for place in range(len(pairs)):
                values[s, f, place] = pair_second(
                    selectors, w, pairs[place, 0], pairs[place, 1], row_room[0], sweeps, change, work,
                    slopes[s, f, place], seconds[s, f, place],
                )  # fmt: skip
    return singular
