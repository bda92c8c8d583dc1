"""What a posture is judged by, and its derivative along the commanded joints: written for the compiler.

The costs are those of `flexmodal.optimisation.objectives`, logarithms throughout. The joints are placed
before, by `flexmodal.optimisation.compiled.held.hold_at`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.model.batch.gradient_kernel import row_slopes
from flexmodal.model.batch.kinematics import point_jacobian
from flexmodal.optimisation.compiled.arrays import RECEPTANCE, STIFFNESS
from flexmodal.optimisation.compiled.receptance import add_row_slopes, receptance_cost, receptance_slope
from flexmodal.optimisation.descent.algebra import multipliers, orthogonal_rows, shortest_solution
from flexmodal.optimisation.descent.work import PERFECT, UNBOUNDED, UNSETTLED

_TINY = 2.2250738585072014e-308
"""Keeps the logarithm of a mobility finite."""


def cost_at(arm):
    """Cost at the joints as placed; infinite where there is none."""
    chain, judge, places, room = arm.chain, arm.judge, arm.places, arm.room
    frames, origins, axes, position = places.frames, places.origins, places.axes, places.position
    joint, offset, selector, row = judge.joint, judge.offset, judge.selector, judge.row
    jacobians, rows = room.jacobians, room.rows
    rows[:] = 0.0
    for p in range(len(joint)):
        point_jacobian(chain, frames, origins, axes, joint[p], offset[p], position, jacobians[p])
        for i in range(rows.shape[1]):
            value = 0.0
            for a in range(6):
                value += selector[p, a] * jacobians[p, a, i]
            rows[row[p], i] += value
    if judge.kind == RECEPTANCE:
        return receptance_cost(chain, judge, places, room)
    if judge.kind == STIFFNESS:
        return stiffness_cost(judge, room)
    return math.log(mobility(judge, room))


def limit_at(arm, cost):
    """Whether a cost says that nothing is left to gain, or that the measure grows without bound."""
    if cost < arm.judge.goal:
        return PERFECT if arm.judge.bounded else UNBOUNDED
    return UNSETTLED


def slope_at(arm, gradient):
    """Derivative of the cost along the commanded joints, at the posture whose cost was taken last."""
    judge, columns, room = arm.judge, arm.columns, arm.room
    if judge.kind == RECEPTANCE:
        receptance_slope(arm.chain, judge, columns, arm.places, room)
    elif judge.kind == STIFFNESS:
        stiffness_slope(judge, room)
    else:
        room.slope[:] = 0.0
        pick, rates, rows = judge.pick, room.rates, room.rows
        for i in range(len(pick)):
            rates[i] = rows[0, pick[i]]
        spread_rates(pick, rates, room.spread)
        add_row_slopes(judge, 0, 2.0 / mobility(judge, room), room.spread, room)
    slope = room.slope
    for k in range(len(columns)):
        gradient[k] = slope[columns[k]]


def mobility(judge, room):
    """ξ_M = j jᵀ over the flexible joints."""
    rows, pick, total = room.rows, judge.pick, _TINY
    for i in range(len(pick)):
        total += rows[0, pick[i]] * rows[0, pick[i]]
    return total


def spread_rates(pick, rates, out):
    """Rates of the flexible joints among all joints, the others at rest."""
    out[:] = 0.0
    for i in range(len(pick)):
        out[pick[i]] = rates[i]


def stiffness_cost(judge, room):
    """−ln ξ_K with ξ_K = uᵀ J⁺ᵀ K J⁺ u; leaves the deflection J⁺u, K J⁺u and ξ_K."""
    pick, stiffness, selectors, jacobian = judge.pick, judge.matrices[0], judge.task, room.jacobians[0]
    task, deflection, moment = room.task, room.deflection, room.moment
    for r in range(len(selectors)):
        for i in range(len(pick)):
            task[r, i] = 0.0
            for a in range(6):
                task[r, i] += selectors[r, a] * jacobian[a, pick[i]]
    orthogonal_rows(task, room.left, room.sizes)
    shortest_solution(task, room.left, room.sizes, judge.along, deflection)
    value = 0.0
    for i in range(len(pick)):
        moment[i] = 0.0
        for j in range(len(pick)):
            moment[i] += stiffness[i, j] * deflection[j]
        value += moment[i] * deflection[i]
    room.norms[0] = value
    return -math.log(value) if value > 0.0 else math.inf


def stiffness_slope(judge, room):
    """The gradient −2 mᵀ dd/ξ_K with d = J⁺u and m = K d.

    At constant rank (Golub and Pereyra 1973), with a = J⁺ᵀm,

        mᵀ dd = −aᵀ dJ d + (u − J d)ᵀ dJ (J⁺a) + (J⁺ᵀd)ᵀ dJ (m − Jᵀa),

    each the derivative of one row at given rates.
    """
    task, left, sizes, shares, rates = room.task, room.left, room.sizes, room.shares, room.rates
    pick, along, selectors, jacobian = judge.pick, judge.along, judge.task, room.jacobians[0]
    deflection, moment = room.deflection, room.moment
    room.slope[:] = 0.0
    factor = -2.0 / room.norms[0]
    multipliers(task, left, sizes, moment, shares)
    for i in range(len(rates)):
        rates[i] = -deflection[i]
    add_task_slopes(judge, factor, room)
    shortest_solution(task, left, sizes, shares, rates)
    for r in range(len(shares)):
        shares[r] = along[r]
        for i in range(len(deflection)):
            for a in range(6):
                shares[r] -= selectors[r, a] * jacobian[a, pick[i]] * deflection[i]
    add_task_slopes(judge, factor, room)
    multipliers(task, left, sizes, moment, shares)
    for i in range(len(rates)):
        rates[i] = moment[i]
        for r in range(len(shares)):
            for a in range(6):
                rates[i] -= shares[r] * selectors[r, a] * jacobian[a, pick[i]]
    multipliers(task, left, sizes, deflection, shares)
    add_task_slopes(judge, factor, room)


def add_task_slopes(judge, factor, room):
    """Add factor · sharesᵀ (∂J/∂q_k) rates to the slope for all joints k."""
    selector, selectors, shares, turned, slope = (
        room.selector,
        judge.task,
        room.shares,
        room.turned,
        room.slope,
    )
    for a in range(6):
        selector[a] = 0.0
        for r in range(len(shares)):
            selector[a] += shares[r] * selectors[r, a]
    spread_rates(judge.pick, room.rates, room.spread)
    row_slopes(room.jacobians[0], selector, room.spread, room.sums, turned)
    for k in range(len(slope)):
        slope[k] += factor * turned[k]
