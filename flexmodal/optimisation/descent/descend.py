"""Descents from many starts, one after another, every iterate on the hold and within the limits.

A quasi-Newton method in the tangent space of the hold: the step minimises a quadratic model between the
limits, a Newton retraction puts the trial point back on the target while joints at a limit stay there, and a
backtracking line search on the true cost accepts it. The model matrix is a damped BFGS estimate of the
Hessian of the Lagrangian.

Written for the compiler; as ordinary Python it serves every problem.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math
from typing import Any

import numpy as np

from flexmodal.optimisation.descent.algebra import copy_matrix, multipliers, null_space, orthogonal_rows
from flexmodal.optimisation.descent.evaluation import cost_at, limit_at, slope_at
from flexmodal.optimisation.descent.quadratic_step import quadratic_step
from flexmodal.optimisation.descent.retraction import retract
from flexmodal.optimisation.descent.work import SETTLED, UNREACHED, UNSETTLED, Box, Work

GRADIENT = 1e-7
"""Projected gradient of the logarithmic cost that counts as zero [1/rad]."""

_ROUNDING = 1e-4
"""Projected gradient below which a line search that finds nothing better has met rounding."""

_SWAMPING = 1e6
"""Gradient beside which limits of a few radians are lost in rounding [1/rad]."""

_LONGEST = 0.5
"""Longest step of one joint [rad, m]."""


def descend_all(
    at: Any,
    box: Box,
    work: Work,
    iterations: int,
    values: np.ndarray,
    costs: np.ndarray,
    ends: np.ndarray,
    counts: np.ndarray,
    trace: np.ndarray,
) -> None:
    """Descend from every start.

    Args:
        at: what costs, holds and limits are asked of.
        box: a `Box`.
        work: from `work_for`.
        iterations: give up after this many.
        values: starts, overwritten by where the descents end; start × commanded.
        costs: receives the costs.
        ends: receives how they ended.
        counts: receives the iterations.
        trace: receives vector and cost of the last descent's first iterates; iterate × (commanded + 1).
    """
    for s in range(len(values)):
        here = values[s]
        costs[s], ends[s], counts[s] = math.inf, UNREACHED, 0
        if retract(at, box, here, 60, work, work.constraint):
            costs[s] = cost_at(at)
            if costs[s] < math.inf:
                costs[s], ends[s], counts[s] = descend_one(at, box, work, iterations, here, costs[s], trace)
            else:
                costs[s] = math.inf


def descend_one(at, box, work, iterations, values, cost, trace):
    """Cost, end and iterations of a descent from a posture on the hold, whose cost was taken just now."""
    width, lower, upper = len(values), box.lower, box.upper
    gradient, step, trial, trial_gradient = work.gradient, work.step, work.trial, work.trial_gradient
    below, above, model = work.below, work.above, work.model
    slope_at(at, gradient)
    first_model(gradient, model)
    fresh = True
    for count in range(iterations):
        if count < len(trace):
            for k in range(width):
                trace[count, k] = values[k]
            trace[count, width] = cost
        limit = limit_at(at, cost)
        if limit != UNSETTLED:
            return cost, limit, count
        copy_matrix(work.constraint, work.rows)
        orthogonal_rows(work.rows, work.left, work.sizes)
        free = work.basis[null_space(work.rows, work.sizes, work.basis) :]
        size = 0.0
        for k in range(width):
            below[k], above[k] = lower[k] - values[k], upper[k] - values[k]
            size += gradient[k] * gradient[k]
        quadratic_step(work, max(1.0, math.sqrt(size) / _SWAMPING), free)
        steepness = 0.0
        for k in range(width):
            steepness += step[k] * step[k]
        if steepness <= GRADIENT * GRADIENT:
            return cost, SETTLED, count
        if not quadratic_step(work, 0.0, free):
            first_model(gradient, model)
            quadratic_step(work, 0.0, free)
        found = line_search(at, box, work, values, cost)
        if found == math.inf:
            if fresh:
                return cost, SETTLED if steepness <= _ROUNDING * _ROUNDING else UNSETTLED, count
            first_model(gradient, model)
            fresh = True
            continue
        slope_at(at, trial_gradient)
        lagrangian_change(box, work)
        for k in range(width):
            step[k] = trial[k] - values[k]
            values[k], gradient[k] = trial[k], trial_gradient[k]
        copy_matrix(work.trial_constraint, work.constraint)
        update(model, step, work.change, work.image, fresh)
        cost, fresh = found, False
    return cost, UNSETTLED, iterations


def first_model(gradient, model):
    """A multiple of the identity whose step is no longer than 0.2."""
    size = 0.0
    for k in range(len(gradient)):
        size = max(size, abs(gradient[k]))
    model[:] = 0.0
    for k in range(len(gradient)):
        model[k, k] = max(1.0, size / 0.2)


def line_search(at, box, work, values, cost):
    """Backtrack along the retracted step until the cost falls enough; the cost, or infinity if it never does.

    Leaves the posture in `work.trial`.
    """
    trial, step, gradient = work.trial, work.step, work.gradient
    longest, slope = 0.0, 0.0
    for k in range(len(values)):
        longest = max(longest, abs(step[k]))
        slope += gradient[k] * step[k]
    if not (slope < 0.0 and longest > 0.0):
        return math.inf
    share = min(1.0, _LONGEST / longest)
    length = 1.0
    for _ in range(40):
        reach = length * share
        for k in range(len(values)):
            trial[k] = values[k] + reach * step[k]
        if retract(at, box, trial, 15, work, work.trial_constraint):
            moved = 0.0
            for k in range(len(values)):
                moved = max(moved, abs(trial[k] - values[k]))
            if moved <= 2.0 * reach * longest + 1e-9:
                found = cost_at(at)
                if found < cost and found <= cost + 1e-4 * reach * slope:
                    return found
        length *= 0.5 if length > 0.1 else 0.2
    return math.inf


def lagrangian_change(box, work):
    """Set `work.change` to the change of the Lagrangian's gradient at the newer multipliers.

    These are the ones of the joints off their limits.
    """
    constraint, trial_constraint, rows = work.constraint, work.trial_constraint, work.rows
    trial, trial_gradient, gradient = work.trial, work.trial_gradient, work.gradient
    change, image, factors, lower, upper = (
        work.change,
        work.image,
        work.factors,
        box.lower,
        box.upper,
    )
    for k in range(len(trial)):
        inside = lower[k] < trial[k] < upper[k]
        image[k] = trial_gradient[k] if inside else 0.0
        change[k] = trial_gradient[k] - gradient[k]
        for r in range(len(rows)):
            rows[r, k] = trial_constraint[r, k] if inside else 0.0
    if len(rows) == 0:
        return
    orthogonal_rows(rows, work.left, work.sizes)
    multipliers(rows, work.left, work.sizes, image, factors)
    for r in range(len(rows)):
        for k in range(len(trial)):
            change[k] -= factors[r] * (trial_constraint[r, k] - constraint[r, k])


def update(model, moved, change, expected, first):
    """Powell's damped BFGS, which keeps the model positive definite; the first step sets its size."""
    width = len(moved)
    curvature, square = 0.0, 0.0
    for k in range(width):
        curvature += moved[k] * change[k]
        square += change[k] * change[k]
    if first and curvature > 0.0:
        model[:] = 0.0
        for k in range(width):
            model[k, k] = square / curvature
    bend = 0.0
    for k in range(width):
        expected[k] = 0.0
        for m in range(width):
            expected[k] += model[k, m] * moved[m]
        bend += moved[k] * expected[k]
    if not (bend > 0.0 and math.isfinite(bend)):
        model[:] = 0.0
        for k in range(width):
            model[k, k] = 1.0
        return
    if curvature < 0.2 * bend:
        weight = 0.8 * bend / (bend - curvature)
        for k in range(width):
            change[k] = weight * change[k] + (1.0 - weight) * expected[k]
        curvature = 0.2 * bend
    for k in range(width):
        for m in range(width):
            model[k, m] += change[k] * change[m] / curvature - expected[k] * expected[m] / bend
