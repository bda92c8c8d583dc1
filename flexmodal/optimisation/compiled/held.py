"""Holding a point, its orientation or its axis while the joints move; the way back onto the hold.

What is held is given by rows that pick from the six components of the error: where the point is off its
target, and the rotation vector that would turn its target orientation (or axis) into the present one. On the
hold their derivative is the Jacobian's.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np

from flexmodal.model.batch_kinematics import cross, place_joints, point_jacobian
from flexmodal.optimisation.compiled.algebra import orthogonal_rows, shortest_solution
from flexmodal.optimisation.compiled.arrays import ORIENTATION, POSITION

TOLERANCE = 1e-10
"""How near the target counts as on it [m, rad]."""

_AT_LIMIT = 1e-12
"""A joint this near its limit is on it [rad, m]: limit minus value plus value is not always the limit."""

_CLIPPED = 0.7
"""Longest Newton step of one joint [rad, m]."""


def rotation_vector(turned, target, out):
    """The rotation vector of turned · targetᵀ [rad]."""
    e = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            e[a, b] = 0.0
            for c in range(3):
                e[a, b] += turned[a, c] * target[b, c]
    out[0], out[1], out[2] = e[2, 1] - e[1, 2], e[0, 2] - e[2, 0], e[1, 0] - e[0, 1]
    sine = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    cosine = e[0, 0] + e[1, 1] + e[2, 2] - 1.0
    if sine > 1e-9:
        scale = math.atan2(sine, cosine) / sine
    elif cosine > 0.0:
        scale = 0.5
    else:  # half a turn: the axis is the longest column of E + 1
        best = 0
        for a in range(1, 3):
            if e[a, a] > e[best, best]:
                best = a
        for a in range(3):
            out[a] = e[a, best] + (1.0 if a == best else 0.0)
        scale = math.pi / math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    for a in range(3):
        out[a] *= scale


def axis_vector(turned, target, out):
    """The shortest rotation vector that turns one unit vector, the target, into another [rad]."""
    cross(target, turned, out)
    sine = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    cosine = target[0] * turned[0] + target[1] * turned[1] + target[2] * turned[2]
    if sine > 1e-12:
        scale = math.atan2(sine, cosine) / sine
        for a in range(3):
            out[a] *= scale
    elif cosine < 0.0:  # opposite: half a turn about anything across
        least = 0
        for a in range(1, 3):
            if abs(target[a]) < abs(target[least]):
                least = a
        unit = np.zeros(3)
        unit[least] = 1.0
        cross(target, unit, out)
        size = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
        for a in range(3):
            out[a] *= math.pi / size


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
    frames, jacobian, turn = places.frames, places.jacobian, places.turn
    place_joints(chain, places.moved, frames, places.origins, places.axes)
    if len(hold.rows) == 0:
        return 0.0
    point_jacobian(
        chain, frames, places.origins, places.axes, hold.joint, hold.offset, places.position, jacobian
    )
    turn[:] = 0.0
    if hold.kind != POSITION:
        for a in range(3):
            for b in range(3):
                places.turned[a, b] = hold.own[a, b]
                if hold.joint >= 0:
                    places.turned[a, b] = 0.0
                    for c in range(3):
                        places.turned[a, b] += frames[hold.joint, a, c] * hold.own[c, b]
        if hold.kind == ORIENTATION:
            rotation_vector(places.turned, hold.orientation, turn)
        else:
            axis_vector(places.turned[:, 0], hold.orientation[:, 0], turn)
    total = 0.0
    for r in range(len(hold.rows)):
        value = 0.0
        for a in range(3):
            value += hold.rows[r, a] * (places.position[a] - hold.target[a]) + hold.rows[r, 3 + a] * turn[a]
        error[r] = value
        total += value * value
        for k in range(len(columns)):
            value = 0.0
            for a in range(6):
                value += hold.rows[r, a] * jacobian[a, columns[k]]
            constraint[r, k] = value
    return math.sqrt(total)


def newton(chain, hold, box, values, allowed, steps, places, tangent, constraint):
    """Newton steps onto the hold with the joints allowed to move, inside the limits; whether it got there.

    A joint that meets its limit sits the next step out.
    """
    held, width = constraint.shape
    work, left, sizes = tangent.rows, tangent.left, tangent.sizes
    error, step = tangent.error, tangent.image
    free = allowed.copy()
    for _ in range(steps):
        for k in range(width):
            places.moved[box.columns[k]] = values[k]
        if held_error(chain, hold, box.columns, places, error, constraint) <= TOLERANCE:
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
            values[k] = min(max(goal, box.lower[k]), box.upper[k])
            if values[k] != goal:
                met = True
                free[k] = False
        if not met:
            free[:] = allowed
    return False


def retract(chain, hold, box, values, steps, places, tangent, constraint):
    """Bring a vector back onto the hold inside the limits; whether it got there.

    Joints at a limit stay there if the others can do it.
    """
    width = len(values)
    free = np.empty(width, dtype=np.bool_)
    inside = True
    for k in range(width):
        if not values[k] > box.lower[k] + _AT_LIMIT:
            values[k] = box.lower[k]
        elif not values[k] < box.upper[k] - _AT_LIMIT:
            values[k] = box.upper[k]
        free[k] = box.lower[k] < values[k] < box.upper[k]
        inside = inside and free[k]
    if len(constraint) == 0 or inside:
        free[:] = True
        return newton(chain, hold, box, values, free, steps, places, tangent, constraint)
    kept = values.copy()
    if newton(chain, hold, box, values, free, steps, places, tangent, constraint):
        return True
    values[:] = kept
    free[:] = True
    return newton(chain, hold, box, values, free, steps, places, tangent, constraint)
