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
            origins[i, a] = offset[i, a]
            for b in range(3):
                frames[i, a, b] = rotation[i, a, b]
        if i > 0:
            for a in range(3):
                origins[i, a] = origins[i - 1, a]
                for b in range(3):
                    origins[i, a] += frames[i - 1, a, b] * offset[i, b]
                    frames[i, a, b] = 0.0
                    for c in range(3):
                        frames[i, a, b] += frames[i - 1, a, c] * rotation[i, c, b]
        for a in range(3):
            axes[i, a] = 0.0
            for b in range(3):
                axes[i, a] += frames[i, a, b] * axis[i, b]
        if turns[i]:
            turn(frames[i], axis[i], q[i])
        else:
            for a in range(3):
                origins[i, a] += axes[i, a] * q[i]


def turn(frame, axis, angle):
    """Multiply a rotation from the right by one about an axis of its own (Rodrigues)."""
    s, c = math.sin(angle), math.cos(angle)
    x, y, z = axis[0], axis[1], axis[2]
    d = 2.0 * math.sin(0.5 * angle) ** 2
    for a in range(3):
        u, v, w = frame[a, 0], frame[a, 1], frame[a, 2]
        along = (u * x + v * y + w * z) * d
        frame[a, 0] = u * c + along * x + s * (v * z - w * y)
        frame[a, 1] = v * c + along * y + s * (w * x - u * z)
        frame[a, 2] = w * c + along * z + s * (u * y - v * x)


def place_bodies(chain, frames, origins, centres, inertias):
    """Centre of mass of every body, and its inertia about it, in world axes."""
    centre, inertia = chain[5], chain[6]
    half = np.empty((3, 3))
    for i in range(len(centre)):
        for a in range(3):
            centres[i, a] = origins[i, a]
            for b in range(3):
                centres[i, a] += frames[i, a, b] * centre[i, b]
                half[a, b] = 0.0
                for c in range(3):
                    half[a, b] += frames[i, a, c] * inertia[i, c, b]
        for a in range(3):
            for b in range(3):
                inertias[i, a, b] = 0.0
                for c in range(3):
                    inertias[i, a, b] += half[a, c] * frames[i, b, c]


def mass_matrix(chain, origins, axes, centres, inertias, out):
    """D over all joints; `centres` and `inertias` are those of the bodies and are left alone."""
    turns, mass, rotor = chain[0], chain[4], chain[7]
    total = 0.0
    middle, about = np.zeros(3), np.zeros((3, 3))
    lever, speed, spin, other = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for j in range(len(mass) - 1, -1, -1):
        both = total + mass[j]
        share = mass[j] / both if both > 0.0 else 1.0
        reduced = share * total
        for a in range(3):
            lever[a] = centres[j, a] - middle[a]
        square = lever[0] * lever[0] + lever[1] * lever[1] + lever[2] * lever[2]
        for a in range(3):
            for b in range(3):
                about[a, b] += inertias[j, a, b] - reduced * lever[a] * lever[b]
            about[a, a] += reduced * square
        for a in range(3):
            middle[a] += share * lever[a]
        total = both
        for a in range(3):
            lever[a] = middle[a] - origins[j, a]
            spin[a] = 0.0
            if turns[j]:
                for b in range(3):
                    spin[a] += about[a, b] * axes[j, b]
        cross(axes[j], lever, speed)
        for i in range(j, -1, -1):
            value = 0.0
            if turns[i]:
                for a in range(3):
                    lever[a] = middle[a] - origins[i, a]
                cross(axes[i], lever, other)
                for a in range(3):
                    value += other[a] * total * (speed[a] if turns[j] else axes[j, a])
                    value += axes[i, a] * spin[a]
            else:
                for a in range(3):
                    value += axes[i, a] * total * (speed[a] if turns[j] else axes[j, a])
            out[i, j] = value
            out[j, i] = value
        out[j, j] += rotor[j]


def point_jacobian(chain, frames, origins, axes, joint, offset, position, out):
    """Position of a point, and its Jacobian over all joints, six rows, linear then angular."""
    turns = chain[0]
    lever, speed = np.empty(3), np.empty(3)
    for a in range(3):
        position[a] = offset[a]
        if joint >= 0:
            position[a] = origins[joint, a]
            for b in range(3):
                position[a] += frames[joint, a, b] * offset[b]
    out[:] = 0.0
    for i in range(joint + 1):
        if turns[i]:
            for a in range(3):
                lever[a] = position[a] - origins[i, a]
            cross(axes[i], lever, speed)
            for a in range(3):
                out[a, i] = speed[a]
                out[3 + a, i] = axes[i, a]
        else:
            for a in range(3):
                out[a, i] = axes[i, a]


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
