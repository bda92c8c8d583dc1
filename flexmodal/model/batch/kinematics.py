"""Mass matrices and Jacobian rows of many postures: written for the compiler, plain Python otherwise.

All vectors are in world axes. The composite body behind a joint is kept by its mass, its centre and its
inertia about that centre, so that nothing large is subtracted however far the chain reaches. With joint j
turning about z_j through p_j, the composite behind it has the momentum l_j = m z_j × (c − p_j) and, about
its centre, k_j = I_c z_j (m z_j and 0 for a sliding joint); then D_ij = z_i × (c − p_i)·l_j + z_i·k_j for
i ≤ j (composite rigid body method; Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.2).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np


def cross(a, b, out):
    """Set out = a × b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


def place_joints(chain, q, frames, origins, axes):
    """Rotation, origin and axis of every joint in the world, its own motion included."""
    turns, axis, rotation, offset = chain[0], chain[1], chain[2], chain[3]
    for i in range(len(q)):
        for a in range(3):
            if i == 0:
                x, y, z = rotation[0, a, 0], rotation[0, a, 1], rotation[0, a, 2]
                origins[0, a] = offset[0, a]
            else:
                u, v, w = frames[i - 1, a, 0], frames[i - 1, a, 1], frames[i - 1, a, 2]
                x = u * rotation[i, 0, 0] + v * rotation[i, 1, 0] + w * rotation[i, 2, 0]
                y = u * rotation[i, 0, 1] + v * rotation[i, 1, 1] + w * rotation[i, 2, 1]
                z = u * rotation[i, 0, 2] + v * rotation[i, 1, 2] + w * rotation[i, 2, 2]
                origins[i, a] = origins[i - 1, a] + u * offset[i, 0] + v * offset[i, 1] + w * offset[i, 2]
            frames[i, a, 0], frames[i, a, 1], frames[i, a, 2] = x, y, z
            axes[i, a] = x * axis[i, 0] + y * axis[i, 1] + z * axis[i, 2]
        if turns[i]:
            turn(frames[i], axis[i], q[i])
        else:
            for a in range(3):
                origins[i, a] += axes[i, a] * q[i]


def turn(frame, axis, angle):
    """Multiply a rotation from the right by one about an axis of its own (Rodrigues)."""
    s, c = math.sin(angle), math.cos(angle)
    x, y, z = axis[0], axis[1], axis[2]
    for a in range(3):
        u, v, w = frame[a, 0], frame[a, 1], frame[a, 2]
        along = (u * x + v * y + w * z) * (1.0 - c)
        frame[a, 0] = u * c + along * x + s * (v * z - w * y)
        frame[a, 1] = v * c + along * y + s * (w * x - u * z)
        frame[a, 2] = w * c + along * z + s * (u * y - v * x)


def place_bodies(chain, frames, origins, centres, inertias):
    """Centre of mass of every body, and its inertia about it, in world axes."""
    centre, inertia = chain[5], chain[6]
    for i in range(len(centre)):
        for a in range(3):
            x, y, z = frames[i, a, 0], frames[i, a, 1], frames[i, a, 2]
            centres[i, a] = origins[i, a] + x * centre[i, 0] + y * centre[i, 1] + z * centre[i, 2]
            u = x * inertia[i, 0, 0] + y * inertia[i, 1, 0] + z * inertia[i, 2, 0]
            v = x * inertia[i, 0, 1] + y * inertia[i, 1, 1] + z * inertia[i, 2, 1]
            w = x * inertia[i, 0, 2] + y * inertia[i, 1, 2] + z * inertia[i, 2, 2]
            for b in range(3):
                inertias[i, a, b] = u * frames[i, b, 0] + v * frames[i, b, 1] + w * frames[i, b, 2]


def mass_matrix(chain, origins, axes, centres, inertias, out):
    """D over all joints; `centres` and `inertias` are those of the bodies and are left alone."""
    turns, mass, rotor = chain[0], chain[4], chain[7]
    total = mx = my = mz = 0.0  # of all behind: mass, centre, inertia about it
    xx = xy = xz = yy = yz = zz = 0.0
    for j in range(len(mass) - 1, -1, -1):
        both = total + mass[j]
        share = mass[j] / both if both > 0.0 else 1.0
        reduced = share * total
        x, y, z = centres[j, 0] - mx, centres[j, 1] - my, centres[j, 2] - mz
        xx += inertias[j, 0, 0] + reduced * (y * y + z * z)
        yy += inertias[j, 1, 1] + reduced * (x * x + z * z)
        zz += inertias[j, 2, 2] + reduced * (x * x + y * y)
        xy += inertias[j, 0, 1] - reduced * x * y
        xz += inertias[j, 0, 2] - reduced * x * z
        yz += inertias[j, 1, 2] - reduced * y * z
        mx, my, mz = mx + share * x, my + share * y, mz + share * z
        total = both
        u, v, w = axes[j, 0], axes[j, 1], axes[j, 2]
        px, py, pz = total * u, total * v, total * w  # momentum, and the angular one about the centre
        hx = hy = hz = 0.0
        if turns[j]:
            x, y, z = mx - origins[j, 0], my - origins[j, 1], mz - origins[j, 2]
            px, py, pz = total * (v * z - w * y), total * (w * x - u * z), total * (u * y - v * x)
            hx, hy, hz = xx * u + xy * v + xz * w, xy * u + yy * v + yz * w, xz * u + yz * v + zz * w
        for i in range(j, -1, -1):
            u, v, w = axes[i, 0], axes[i, 1], axes[i, 2]
            if turns[i]:
                x, y, z = mx - origins[i, 0], my - origins[i, 1], mz - origins[i, 2]
                value = (v * z - w * y) * px + (w * x - u * z) * py + (u * y - v * x) * pz
                value += u * hx + v * hy + w * hz
            else:
                value = u * px + v * py + w * pz
            out[i, j] = value
            out[j, i] = value
        out[j, j] += rotor[j]


def point_jacobian(chain, frames, origins, axes, joint, offset, position, out):
    """Position of a point, and its Jacobian over all joints, six rows, linear then angular."""
    turns = chain[0]
    for a in range(3):
        position[a] = offset[a]
        if joint >= 0:
            position[a] = origins[joint, a]
            for b in range(3):
                position[a] += frames[joint, a, b] * offset[b]
    out[:] = 0.0
    for i in range(joint + 1):
        u, v, w = axes[i, 0], axes[i, 1], axes[i, 2]
        if turns[i]:
            x, y, z = position[0] - origins[i, 0], position[1] - origins[i, 1], position[2] - origins[i, 2]
            out[0, i], out[1, i], out[2, i] = v * z - w * y, w * x - u * z, u * y - v * x
            out[3, i], out[4, i], out[5, i] = u, v, w
        else:
            out[0, i], out[1, i], out[2, i] = u, v, w


def pose_batch(chain, joints, offsets, selectors, pick, postures, masses, rows):
    """Mass matrices and rows over the flexible joints.

    Args:
        chain: arrays of a `Chain`.
        joints: carrier of each row's point.
        offsets: of the points in the carriers' frames.
        selectors: directions of the rows.
        pick: which joints are flexible.
        postures: angles and lengths of all joints; posture × joint.
        masses: receives posture × flexible × flexible.
        rows: receives posture × row × flexible.
    """
    count = postures.shape[1]
    frames, origins, axes = np.empty((count, 3, 3)), np.empty((count, 3)), np.empty((count, 3))
    centres, inertias = np.empty((count, 3)), np.empty((count, 3, 3))
    full, jacobian, position = np.empty((count, count)), np.empty((6, count)), np.empty(3)
    for s in range(len(postures)):
        place_joints(chain, postures[s], frames, origins, axes)
        place_bodies(chain, frames, origins, centres, inertias)
        mass_matrix(chain, origins, axes, centres, inertias, full)
        for i in range(len(pick)):
            for j in range(len(pick)):
                masses[s, i, j] = full[pick[i], pick[j]]
        for r in range(len(joints)):
            point_jacobian(chain, frames, origins, axes, joints[r], offsets[r], position, jacobian)
            for i in range(len(pick)):
                value = 0.0
                for a in range(6):
                    value += selectors[r, a] * jacobian[a, pick[i]]
                rows[s, r, i] = value
