"""Holding a point, its orientation or its axis while the joints move; the way back onto the hold.

What is held is given by rows that pick from the six components of the error: where the point is off its
target, and the rotation vector that would turn its target orientation (or axis) into the present one. On the
hold their derivative is the Jacobian's.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.model.batch.kinematics import cross, place_joints, point_jacobian
from flexmodal.optimisation.compiled.algebra import copy_vector, orthogonal_rows, shortest_solution
from flexmodal.optimisation.compiled.arrays import ORIENTATION, POSITION

TOLERANCE = 1e-10
"""How near the target counts as on it [m, rad]."""

_AT_LIMIT = 1e-12
"""A joint this near its limit is on it [rad, m]: limit minus value plus value is not always the limit."""

_CLIPPED = 0.7
"""Longest Newton step of one joint [rad, m]."""


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


def held_error(chain, hold, columns, places, error, constraint):
    """Place the joints; error of the hold and its derivative along the commanded joints.

    Args:
        chain: arrays of a `Chain`.
        hold: a `Held`.
        columns: where the commanded joints stand among all.
        places: the joints at `places.moved`; receives where they are.
        error: receives what is off target.
        constraint: receives its derivative; held × commanded.

    Returns:
        The size of the error.
    """
    frames, jacobian, position, turn = places.frames, places.jacobian, places.position, places.turn
    rows, target, joint = hold.rows, hold.target, hold.joint
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


def newton(chain, hold, box, values, allowed, steps, places, tangent, constraint):
    """Newton steps onto the hold with the joints allowed to move, inside the limits; whether it got there.

    A joint that meets its limit sits the next step out.
    """
    held, width = constraint.shape
    work, left, sizes = tangent.rows, tangent.left, tangent.sizes
    error, step, moved = tangent.error, tangent.image, places.moved
    columns, lower, upper = box.columns, box.lower, box.upper
    free = tangent.free
    copy_vector(allowed, free)
    for _ in range(steps):
        for k in range(width):
            moved[columns[k]] = values[k]
        if held_error(chain, hold, columns, places, error, constraint) <= TOLERANCE:
            return True
        for r in range(held):
            error[r] = -error[r]
            for k in range(width):
                work[r, k] = constraint[r, k] if free[k] else 0.0
        orthogonal_rows(work, left, sizes)
        shortest_solution(work, left, sizes, error, step)
        longest = 0.0
        for k in range(width):
            longest = max(longest, abs(step[k]))
        if longest < 1e-14:
            return False
        share = min(1.0, _CLIPPED / longest)
        met = False
        for k in range(width):
            goal = values[k] + share * step[k]
            values[k] = min(max(goal, lower[k]), upper[k])
            if values[k] != goal:
                met = True
                free[k] = False
        if not met:
            copy_vector(allowed, free)
    return False


def retract(chain, hold, box, values, steps, places, tangent, constraint):
    """Bring a vector back onto the hold inside the limits; whether it got there.

    Joints at a limit stay there if the others can do it.
    """
    width, lower, upper = len(values), box.lower, box.upper
    free, kept = tangent.allowed, tangent.kept
    inside = True
    for k in range(width):
        if not values[k] > lower[k] + _AT_LIMIT:
            values[k] = lower[k]
        elif not values[k] < upper[k] - _AT_LIMIT:
            values[k] = upper[k]
        free[k] = lower[k] < values[k] < upper[k]
        inside = inside and free[k]
    if len(constraint) == 0 or inside:
        free[:] = True
        return newton(chain, hold, box, values, free, steps, places, tangent, constraint)
    copy_vector(values, kept)
    if newton(chain, hold, box, values, free, steps, places, tangent, constraint):
        return True
    copy_vector(kept, values)
    free[:] = True
    return newton(chain, hold, box, values, free, steps, places, tangent, constraint)
