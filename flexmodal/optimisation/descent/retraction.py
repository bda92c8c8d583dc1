"""The way back onto the hold while the joints stay within their limits."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.optimisation.descent.algebra import copy_vector, orthogonal_rows, shortest_solution
from flexmodal.optimisation.descent.evaluation import hold_at
from flexmodal.optimisation.descent.work import Box, Work

TOLERANCE = 1e-10
"""How near the held point is kept to its target [m], and its axes [rad]."""

_AT_LIMIT = 1e-12
"""A joint this near its limit is on it [rad, m]: limit minus value plus value is not always the limit."""

_CLIPPED = 0.7
"""Longest Newton step of one joint [rad, m]."""


def newton(at, box, values, allowed, steps, work, constraint):
    """Newton steps onto the hold with the joints allowed to move, inside the limits; whether it got there.

    A joint that meets its limit sits the next step out.
    """
    held, width = constraint.shape
    rows, left, sizes, error, step, free = work.rows, work.left, work.sizes, work.error, work.image, work.free
    lower, upper = box.lower, box.upper
    copy_vector(allowed, free)
    for _ in range(steps):
        if hold_at(at, values, error, constraint) <= TOLERANCE:
            return True
        for r in range(held):
            error[r] = -error[r]
            for k in range(width):
                rows[r, k] = constraint[r, k] if free[k] else 0.0
        orthogonal_rows(rows, left, sizes)
        shortest_solution(rows, left, sizes, error, step)
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


def retract(at: Any, box: Box, values: np.ndarray, steps: int, work: Work, constraint: np.ndarray) -> bool:
    """Bring a vector back onto the hold inside the limits; whether it got there.

    Joints at a limit stay there if the others can do it.
    """
    width, lower, upper = len(values), box.lower, box.upper
    free, kept = work.allowed, work.kept
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
        return newton(at, box, values, free, steps, work, constraint)
    copy_vector(values, kept)
    if newton(at, box, values, free, steps, work, constraint):
        return True
    copy_vector(kept, values)
    free[:] = True
    return newton(at, box, values, free, steps, work, constraint)
