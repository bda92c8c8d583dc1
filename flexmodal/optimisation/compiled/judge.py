"""What a posture is judged by, and its derivative along the commanded joints: written for the compiler.

The costs are those of `flexmodal.optimisation.objective`, logarithms throughout. The joints are placed before,
by `flexmodal.optimisation.compiled.held.held_error`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from flexmodal.model.batch_gradient import row_slopes
from flexmodal.model.batch_kinematics import point_jacobian
from flexmodal.optimisation.compiled.algebra import multipliers, orthogonal_rows, shortest_solution
from flexmodal.optimisation.compiled.arrays import RECEPTANCE, STIFFNESS
from flexmodal.optimisation.compiled.receptance import add_row_slopes, receptance_cost, receptance_slope

_TINY = 2.2250738585072014e-308
"""Keeps the logarithm of a mobility finite."""


def cost_of(chain, judge, places, room):
    """Cost at the joints as placed; infinite where there is none."""
    room.rows[:] = 0.0
    for p in range(len(judge.joint)):
        point_jacobian(
            chain, places.frames, places.origins, places.axes, judge.joint[p], judge.offset[p],
            places.position, room.jacobians[p],
        )  # fmt: skip
        for i in range(room.rows.shape[1]):
            for a in range(6):
                room.rows[judge.row[p], i] += judge.selector[p, a] * room.jacobians[p, a, i]
    if judge.kind == RECEPTANCE:
        return receptance_cost(chain, judge, places, room)
    if judge.kind == STIFFNESS:
        return stiffness_cost(judge, room)
    return math.log(mobility(judge, room))


def gradient_of(chain, judge, columns, places, room, gradient):
    """Derivative of the cost along the commanded joints, at the posture whose cost was taken last."""
    if judge.kind == RECEPTANCE:
        receptance_slope(chain, judge, columns, places, room)
    elif judge.kind == STIFFNESS:
        stiffness_slope(judge, room)
    else:
        room.slope[:] = 0.0
        spread_rates(judge.pick, room.rows[0][judge.pick], room.spread)
        add_row_slopes(judge, 0, 2.0 / mobility(judge, room), room.spread, room)
    for k in range(len(columns)):
        gradient[k] = room.slope[columns[k]]


def mobility(judge, room):
    """ξ_M = j jᵀ over the flexible joints."""
    total = _TINY
    for i in range(len(judge.pick)):
        total += room.rows[0, judge.pick[i]] * room.rows[0, judge.pick[i]]
    return total


def spread_rates(pick, rates, out):
    """Rates of the flexible joints among all joints, the others at rest."""
    out[:] = 0.0
    for i in range(len(pick)):
        out[pick[i]] = rates[i]


def stiffness_cost(judge, room):
    """−ln ξ_K with ξ_K = uᵀ J⁺ᵀ K J⁺ u; leaves the deflection J⁺u, K J⁺u and ξ_K."""
    pick, stiffness = judge.pick, judge.matrices[0]
    for r in range(len(judge.task)):
        for i in range(len(pick)):
            room.task[r, i] = 0.0
            for a in range(6):
                room.task[r, i] += judge.task[r, a] * room.jacobians[0, a, pick[i]]
    orthogonal_rows(room.task, room.left, room.sizes)
    shortest_solution(room.task, room.left, room.sizes, judge.along, room.deflection)
    value = 0.0
    for i in range(len(pick)):
        room.moment[i] = 0.0
        for j in range(len(pick)):
            room.moment[i] += stiffness[i, j] * room.deflection[j]
        value += room.moment[i] * room.deflection[i]
    room.norms[0] = value
    return -math.log(value) if value > 0.0 else math.inf


def stiffness_slope(judge, room):
    """The gradient −2 mᵀ dd/ξ_K with d = J⁺u and m = K d.

    At constant rank (Golub and Pereyra 1973), with a = J⁺ᵀm,

        mᵀ dd = −aᵀ dJ d + (u − J d)ᵀ dJ (J⁺a) + (J⁺ᵀd)ᵀ dJ (m − Jᵀa),

    each the derivative of one row at given rates.
    """
    task, left, sizes, shares, rates = room.task, room.left, room.sizes, room.shares, room.rates
    room.slope[:] = 0.0
    factor = -2.0 / room.norms[0]
    multipliers(task, left, sizes, room.moment, shares)
    for i in range(len(rates)):
        rates[i] = -room.deflection[i]
    add_task_slopes(judge, factor, room)
    shortest_solution(task, left, sizes, shares, rates)
    for r in range(len(shares)):
        shares[r] = judge.along[r] - task_image(judge, room, r, room.deflection)
    add_task_slopes(judge, factor, room)
    multipliers(task, left, sizes, room.moment, shares)
    for i in range(len(rates)):
        rates[i] = room.moment[i]
        for r in range(len(shares)):
            for a in range(6):
                rates[i] -= shares[r] * judge.task[r, a] * room.jacobians[0, a, judge.pick[i]]
    multipliers(task, left, sizes, room.deflection, shares)
    add_task_slopes(judge, factor, room)


def task_image(judge, room, r, rates):
    """Row r of the task Jacobian times rates."""
    total = 0.0
    for i in range(len(rates)):
        for a in range(6):
            total += judge.task[r, a] * room.jacobians[0, a, judge.pick[i]] * rates[i]
    return total


def add_task_slopes(judge, factor, room):
    """Add factor · sharesᵀ (∂J/∂q_k) rates to the slope for all joints k."""
    for a in range(6):
        room.selector[a] = 0.0
        for r in range(len(room.shares)):
            room.selector[a] += room.shares[r] * judge.task[r, a]
    spread_rates(judge.pick, room.rates, room.spread)
    row_slopes(room.jacobians[0], room.selector, room.spread, room.sums, room.turned)
    for k in range(len(room.slope)):
        room.slope[k] += factor * room.turned[k]
