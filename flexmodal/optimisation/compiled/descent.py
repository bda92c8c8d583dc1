"""Descents from many starts, one after another: written for the compiler.

The method is that of `flexmodal.optimisation.descent`: every iterate on the hold and within the limits, a
damped BFGS model of the Lagrangian, the step from a quadratic program in the tangent space, a Newton
retraction, and a line search on the true cost.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.optimisation.compiled.algebra import copy_matrix, multipliers, null_space, orthogonal_rows
from flexmodal.optimisation.compiled.held import retract
from flexmodal.optimisation.compiled.judge import cost_of, gradient_of
from flexmodal.optimisation.compiled.quadratic import quadratic_step

UNREACHED, UNSETTLED, SETTLED, PERFECT, UNBOUNDED = -1, 0, 1, 2, 3
"""How a descent ended: it could not reach the hold; ran out of iterations; met the tolerance; has nothing
left to gain; ran into a posture where the measure grows without bound."""

GRADIENT = 1e-7
"""Projected gradient of the logarithmic cost that counts as zero [1/rad]."""

_ROUNDING = 1e-4
"""Projected gradient below which a line search that finds nothing better has met rounding."""

_SWAMPING = 1e6
"""Gradient beside which limits of a few radians are lost in rounding [1/rad]."""

_LONGEST = 0.5
"""Longest step of one joint [rad, m]."""


def descend_all(chain, hold, box, judge, places, tangent, room, iterations, values, costs, ends, counts):
    """Descend from every start.

    Args:
        chain: arrays of a `Chain`.
        hold: a `Held`.
        box: a `Box`.
        judge: a `Judge`.
        places: from `room_for`.
        tangent: likewise.
        room: from `scratch_for`.
        iterations: give up after this many.
        values: starts, overwritten by where the descents end; start × commanded.
        costs: receives the costs.
        ends: receives how they ended.
        counts: receives the iterations.
    """
    for s in range(len(values)):
        here = values[s]
        costs[s], ends[s], counts[s] = math.inf, UNREACHED, 0
        if retract(chain, hold, box, here, 60, places, tangent, tangent.constraint):
            costs[s] = cost_of(chain, judge, places, room)
            if math.isfinite(costs[s]):
                costs[s], ends[s], counts[s] = descend_one(
                    chain, hold, box, judge, places, tangent, room, iterations, here, costs[s]
                )


def descend_one(chain, hold, box, judge, places, tangent, room, iterations, values, cost):
    """Cost, end and iterations of a descent from a posture on the hold, whose cost was taken just now."""
    t, width, columns, lower, upper = tangent, len(values), box.columns, box.lower, box.upper
    gradient, step, trial, trial_gradient = t.gradient, t.step, t.trial, t.trial_gradient
    below, above, model = t.below, t.above, t.model
    gradient_of(chain, judge, columns, places, room, gradient)
    first_model(gradient, model)
    fresh = True
    for count in range(iterations):
        copy_matrix(t.constraint, t.rows)
        orthogonal_rows(t.rows, t.left, t.sizes)
        free = t.basis[null_space(t.rows, t.sizes, t.basis) :]
        for k in range(width):
            below[k], above[k] = lower[k] - values[k], upper[k] - values[k]
        size = 0.0
        for k in range(width):
            size += gradient[k] * gradient[k]
        quadratic_step(tangent, max(1.0, math.sqrt(size) / _SWAMPING), free)
        steepness = 0.0
        for k in range(width):
            steepness += step[k] * step[k]
        if cost < judge.goal:
            return cost, PERFECT if judge.bounded else UNBOUNDED, count
        if steepness <= GRADIENT * GRADIENT:
            return cost, SETTLED, count
        if not quadratic_step(tangent, 0.0, free):
            first_model(gradient, model)
            quadratic_step(tangent, 0.0, free)
        found = line_search(chain, hold, box, judge, places, tangent, room, values, cost)
        if found == math.inf:
            if fresh:
                return cost, SETTLED if steepness <= _ROUNDING * _ROUNDING else UNSETTLED, count
            first_model(gradient, model)
            fresh = True
            continue
        gradient_of(chain, judge, columns, places, room, trial_gradient)
        lagrangian_change(box, tangent)
        for k in range(width):
            step[k] = trial[k] - values[k]
            values[k], gradient[k] = trial[k], trial_gradient[k]
        copy_matrix(t.trial_constraint, t.constraint)
        update(model, step, t.change, t.image, fresh)
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


def line_search(chain, hold, box, judge, places, tangent, room, values, cost):
    """Backtrack along the retracted step until the cost falls enough; the cost, or infinity if it never does.

    Leaves the posture in `tangent.trial`.
    """
    trial, step, gradient = tangent.trial, tangent.step, tangent.gradient
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
        if retract(chain, hold, box, trial, 15, places, tangent, tangent.trial_constraint):
            moved = 0.0
            for k in range(len(values)):
                moved = max(moved, abs(trial[k] - values[k]))
            if moved <= 2.0 * reach * longest + 1e-9:
                found = cost_of(chain, judge, places, room)
                if found < cost and found <= cost + 1e-4 * reach * slope:
                    return found
        length *= 0.5 if length > 0.1 else 0.2
    return math.inf


def lagrangian_change(box, tangent):
    """Set `tangent.change` to the change of the Lagrangian's gradient at the newer multipliers.

    These are the ones of the joints off their limits.
    """
    constraint, trial_constraint, rows = tangent.constraint, tangent.trial_constraint, tangent.rows
    trial, trial_gradient, gradient = tangent.trial, tangent.trial_gradient, tangent.gradient
    change, image, factors, lower, upper = (
        tangent.change,
        tangent.image,
        tangent.factors,
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
    orthogonal_rows(rows, tangent.left, tangent.sizes)
    multipliers(rows, tangent.left, tangent.sizes, image, factors)
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
