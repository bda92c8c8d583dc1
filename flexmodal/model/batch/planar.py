"""What the recursion of `flexmodal.frf.kernels.planar` needs of a planar chain in some postures."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np

from flexmodal.frf.kernels.planar import ENTRIES
from flexmodal.model.batch.kinematics import place_bodies, place_joints


def plane_batch(chain, places, plane, springs, postures, joints, wrenches):
    """Joints and wrenches in the plane.

    Args:
        chain: arrays of a `Chain`.
        places: of the rows: carriers, offsets and selectors.
        plane: its two axes and their cross product, as rows.
        springs: k, b, structural damping and whether it is flexible, of each joint.
        postures: posture × joint.
        joints: receives posture × joint × entry and kind.
        wrenches: receives posture × joint × 3·row.
    """
    turns, mass, rotor = chain[0], chain[4], chain[7]
    carriers, offsets, selectors = places
    count = postures.shape[1]
    frames, origins, axes = np.empty((count, 3, 3)), np.empty((count, 3)), np.empty((count, 3))
    centres, inertias = np.empty((count, 3)), np.empty((count, 3, 3))
    lever = np.empty(2)
    wrenches[:] = 0.0
    for s in range(len(postures)):
        place_joints(chain, postures[s], frames, origins, axes)
        place_bodies(chain, frames, origins, centres, inertias)
        total, about = 0.0, 0.0  # of all behind a joint: mass, inertia about their centre
        middle = np.zeros(2)
        for i in range(count - 1, -1, -1):
            entry = joints[s, i]
            for a in range(2):
                lever[a] = entry[a] = entry[11 + a] = 0.0
                for c in range(3):
                    lever[a] += plane[a, c] * (centres[i, c] - origins[i, c])
                    entry[11 + a] += plane[a, c] * axes[i, c]
                    if i + 1 < count:
                        entry[a] += plane[a, c] * (origins[i + 1, c] - origins[i, c])
            own = 0.0
            for a in range(3):
                for c in range(3):
                    own += plane[2, a] * inertias[i, a, c] * plane[2, c]
            both = total + mass[i]
            share = mass[i] / both if both > 0.0 else 1.0
            x, y = middle[0] + entry[0] - lever[0], middle[1] + entry[1] - lever[1]
            about += own + share * total * (x * x + y * y)
            middle[0], middle[1] = lever[0] + (1.0 - share) * x, lever[1] + (1.0 - share) * y
            total = both
            entry[2] = mass[i]
            entry[3], entry[4] = mass[i] * lever[0], mass[i] * lever[1]
            entry[5] = own + mass[i] * (lever[0] * lever[0] + lever[1] * lever[1])
            entry[6], entry[7], entry[8], entry[9] = springs[i, 0], springs[i, 1], springs[i, 2], rotor[i]
            behind = about + total * (middle[0] * middle[0] + middle[1] * middle[1]) if turns[i] else total
            entry[10] = behind + rotor[i]
            entry[13] = 0.0 if springs[i, 3] == 0.0 else (1.0 if turns[i] else 2.0)
        for r in range(len(carriers)):
            i = carriers[r]
            if i >= 0:
                plane_wrench(plane, frames[i], offsets[r], selectors[r], lever, wrenches[s, i, 3 * r :])


def plane_wrench(plane, frame, offset, selector, lever, out):
    """A unit force along a row's direction, about the joint that carries its point; `lever` is for work."""
    for a in range(2):
        lever[a] = out[a] = 0.0
        for c in range(3):
            out[a] += plane[a, c] * selector[c]
            for d in range(3):
                lever[a] += plane[a, c] * frame[c, d] * offset[d]
    out[2] = lever[0] * out[1] - lever[1] * out[0]
    for c in range(3):
        out[2] += plane[2, c] * selector[3 + c]


def empty_plane(postures: int, joints: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Arrays for `plane_batch` to fill."""
    return np.empty((postures, joints, len(ENTRIES) + 1)), np.empty((postures, joints, 3 * rows))
