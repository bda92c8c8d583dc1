"""What the recursion of `flexmodal.frf.kernels.spatial` needs of a chain in some postures.

Twists hold the velocity at a common origin before the angular velocity, momenta the linear one before the
angular one about it.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np

from flexmodal.frf.kernels.spatial import ENTRIES
from flexmodal.model.batch.gradient_kernel import place_arm
from flexmodal.model.batch.kinematics import place_bodies, place_joints


def space_batch(chain, places, springs, postures, joints, wrenches):
    """Joints and wrenches in world axes.

    Args:
        chain: arrays of a `Chain`.
        places: of the rows: carriers, offsets and selectors.
        springs: k, b, structural damping and whether it is flexible, of each joint.
        postures: posture × joint.
        joints: receives posture × joint × entry and kind.
        wrenches: receives posture × joint × 6·row.
    """
    turns, mass, rotor = chain[0], chain[4], chain[7]
    carriers, offsets, selectors = places
    count = postures.shape[1]
    frames, origins, axes = np.empty((count, 3, 3)), np.empty((count, 3)), np.empty((count, 3))
    centres, inertias = np.empty((count, 3)), np.empty((count, 3, 3))
    gathered, twist, momentum = np.empty((count, 10)), np.empty(6), np.empty(6)
    wrenches[:] = 0.0
    for s in range(len(postures)):
        place_joints(chain, postures[s], frames, origins, axes)
        place_bodies(chain, frames, origins, centres, inertias)
        for i in range(count):
            for a in range(3):
                centres[i, a] -= origins[0, a]
        gather_inertias(mass, centres, inertias, gathered)
        for i in range(count):
            fill_joint(i, mass, origins, centres, inertias, joints[s, i])
            entry = joints[s, i]
            for a in range(3):
                entry[13 + a] = springs[i, a]
                entry[18 + a] = axes[i, a]
                twist[3 + a] = axes[i, a] if turns[i] else 0.0
            place_arm(turns[i], origins[i], origins[0], axes[i], twist)
            apply_inertia(gathered[i], twist, momentum)
            entry[16], entry[17] = rotor[i], rotor[i]
            for a in range(6):
                entry[17] += twist[a] * momentum[a]
            entry[21] = 0.0 if springs[i, 3] == 0.0 else (1.0 if turns[i] else 2.0)
        for r in range(len(carriers)):
            if carriers[r] >= 0:
                fill_wrench(frames[carriers[r]], offsets[r], selectors[r], wrenches[s, carriers[r], 6 * r :])


def apply_inertia(inertia, twist, out):
    """Momentum of a twist; `inertia` holds the mass, mass times centre, and xx, xy, xz, yy, yz, zz."""
    m, x, y, z = inertia[0], inertia[1], inertia[2], inertia[3]
    a, b, c, d, e, f = twist[0], twist[1], twist[2], twist[3], twist[4], twist[5]
    out[0], out[1], out[2] = m * a + e * z - f * y, m * b + f * x - d * z, m * c + d * y - e * x
    out[3] = inertia[4] * d + inertia[5] * e + inertia[6] * f + y * c - z * b
    out[4] = inertia[5] * d + inertia[7] * e + inertia[8] * f + z * a - x * c
    out[5] = inertia[6] * d + inertia[8] * e + inertia[9] * f + x * b - y * a


def gather_inertias(mass, centres, inertias, out):
    """Inertia of all bodies from each joint outwards, about the first joint's origin."""
    out[:] = 0.0
    for k in range(len(mass) - 1, -1, -1):
        x, y, z = centres[k, 0], centres[k, 1], centres[k, 2]
        m = mass[k]
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = m, m * x, m * y, m * z
        out[k, 4] = inertias[k, 0, 0] + m * (y * y + z * z)
        out[k, 5] = inertias[k, 0, 1] - m * x * y
        out[k, 6] = inertias[k, 0, 2] - m * x * z
        out[k, 7] = inertias[k, 1, 1] + m * (x * x + z * z)
        out[k, 8] = inertias[k, 1, 2] - m * y * z
        out[k, 9] = inertias[k, 2, 2] + m * (x * x + y * y)
        if k + 1 < len(mass):
            for e in range(10):
                out[k, e] += out[k + 1, e]


def fill_joint(i, mass, origins, centres, inertias, out):
    """The step to the next joint, and the body about this one."""
    m = mass[i]
    for a in range(3):
        out[a] = origins[i + 1, a] - origins[i, a] if i + 1 < len(mass) else 0.0
    x, y, z = (
        centres[i, 0] + origins[0, 0] - origins[i, 0],
        centres[i, 1] + origins[0, 1] - origins[i, 1],
        centres[i, 2] + origins[0, 2] - origins[i, 2],
    )
    out[3], out[4], out[5], out[6] = m, m * x, m * y, m * z
    out[7] = inertias[i, 0, 0] + m * (y * y + z * z)
    out[8] = inertias[i, 0, 1] - m * x * y
    out[9] = inertias[i, 1, 1] + m * (x * x + z * z)
    out[10] = inertias[i, 0, 2] - m * x * z
    out[11] = inertias[i, 1, 2] - m * y * z
    out[12] = inertias[i, 2, 2] + m * (x * x + y * y)


def fill_wrench(frame, offset, selector, out):
    """A unit force along a row's direction, about the joint that carries its point."""
    x = frame[0, 0] * offset[0] + frame[0, 1] * offset[1] + frame[0, 2] * offset[2]
    y = frame[1, 0] * offset[0] + frame[1, 1] * offset[1] + frame[1, 2] * offset[2]
    z = frame[2, 0] * offset[0] + frame[2, 1] * offset[1] + frame[2, 2] * offset[2]
    f = selector
    out[0], out[1], out[2] = f[0], f[1], f[2]
    out[3], out[4], out[5] = (
        y * f[2] - z * f[1] + f[3],
        z * f[0] - x * f[2] + f[4],
        x * f[1] - y * f[0] + f[5],
    )


def empty_space(postures: int, joints: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Arrays for `space_batch` to fill."""
    return np.empty((postures, joints, len(ENTRIES) + 1)), np.empty((postures, joints, 6 * rows))
