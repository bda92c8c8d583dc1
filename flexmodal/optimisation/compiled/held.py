"""Holding a point, its orientation or its axis while the joints move: written for the compiler.

What is held is given by rows that pick from the six components of the error: where the point is off its
target, and the rotation vector that would turn its target orientation (or axis) into the present one. On the
hold their derivative is the Jacobian's.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.model.batch.kinematics import cross, place_joints, point_jacobian
from flexmodal.optimisation.compiled.arrays import ORIENTATION, POSITION


def rotation_vector(turned, target, out):
    """The rotation vector of E = turned · targetᵀ [rad]."""
    cosine = -1.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        out[a] = row_product(turned, target, c, b) - row_product(turned, target, b, c)
        cosine += row_product(turned, target, a, a)
    sine = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    if sine > 1e-9:
        scale = math.atan2(sine, cosine) / sine
    elif cosine > 0.0:
        scale = 0.5
    else:  # half a turn: the axis is the longest column of E + 1
        best = 0
        for a in range(1, 3):
            if row_product(turned, target, a, a) > row_product(turned, target, best, best):
                best = a
        for a in range(3):
            out[a] = row_product(turned, target, a, best) + (1.0 if a == best else 0.0)
        scale = math.pi / math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    for a in range(3):
        out[a] *= scale


def row_product(turned, target, a, b):
    """Entry (a, b) of turned · targetᵀ."""
    return turned[a, 0] * target[b, 0] + turned[a, 1] * target[b, 1] + turned[a, 2] * target[b, 2]


def axis_vector(turned, target, out):
    """The shortest rotation vector that turns one unit vector, the target, into another [rad]."""
    cross(target, turned, out)
    sine = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    cosine = target[0] * turned[0] + target[1] * turned[1] + target[2] * turned[2]
    if sine > 1e-12:
        scale = math.atan2(sine, cosine) / sine
    elif cosine > 0.0:
        scale = 1.0
    else:  # opposite: half a turn about anything across
        least = 0
        for a in range(1, 3):
            if abs(target[a]) < abs(target[least]):
                least = a
        b, c = (least + 1) % 3, (least + 2) % 3
        out[least], out[b], out[c] = 0.0, target[c], -target[b]
        scale = math.pi / math.sqrt(out[b] * out[b] + out[c] * out[c])
    for a in range(3):
        out[a] *= scale


def hold_at(arm, values, error, constraint):
    """Place the joints; error of the hold and its derivative along the commanded joints.

    Args:
        arm: an `Arm`, whose `places` receive where the joints are.
        values: of the commanded joints.
        error: receives what is off target.
        constraint: receives its derivative; held × commanded.

    Returns:
        The size of the error.
    """
    chain, hold, columns, places = arm.chain, arm.hold, arm.columns, arm.places
    frames, jacobian, position, turn = places.frames, places.jacobian, places.position, places.turn
    rows, target, joint = hold.rows, hold.target, hold.joint
    for k in range(len(columns)):
        places.moved[columns[k]] = values[k]
    place_joints(chain, places.moved, frames, places.origins, places.axes)
    if len(rows) == 0:
        return 0.0
    point_jacobian(chain, frames, places.origins, places.axes, joint, hold.offset, position, jacobian)
    turn[:] = 0.0
    if hold.kind != POSITION:
        turned, own = places.turned, hold.own
        for a in range(3):
            for b in range(3):
                turned[a, b] = own[a, b]
                if joint >= 0:
                    turned[a, b] = 0.0
                    for c in range(3):
                        turned[a, b] += frames[joint, a, c] * own[c, b]
        if hold.kind == ORIENTATION:
            rotation_vector(turned, hold.orientation, turn)
        else:
            axis_vector(turned[:, 0], hold.orientation[:, 0], turn)
    total = 0.0
    for r in range(len(rows)):
        value = 0.0
        for a in range(3):
            value += rows[r, a] * (position[a] - target[a]) + rows[r, 3 + a] * turn[a]
        error[r] = value
        total += value * value
        for k in range(len(columns)):
            value = 0.0
            for a in range(6):
                value += rows[r, a] * jacobian[a, columns[k]]
            constraint[r, k] = value
    return math.sqrt(total)
