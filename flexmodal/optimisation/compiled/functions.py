"""The functions of a descent that is compiled, and that of them which is called."""

from __future__ import annotations

from functools import cache

from flexmodal.frf.kernels import pivoted
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.model.batch import factor
from flexmodal.model.batch import gradient_kernel as gradient
from flexmodal.model.batch.compiled import KINEMATICS
from flexmodal.optimisation.compiled import held, judge, matrix_norm, receptance
from flexmodal.optimisation.descent import algebra, descend, quadratic_step, retraction

COMPILATION = 40.0
"""Seconds to compile them [s]; 38 to 54 measured."""

_LOWEST_FIRST = (
    *KINEMATICS,
    factor.factor_symmetric,
    factor.solve_factored,
    gradient.place_arm,
    gradient.sweep_momenta,
    gradient.row_slopes,
    gradient.solve_rows,
    pivoted.eliminate,
    algebra.copy_vector,
    algebra.copy_matrix,
    algebra.orthogonal_rows,
    algebra.largest,
    algebra.null_space,
    algebra.shortest_solution,
    algebra.multipliers,
    quadratic_step.whiten,
    quadratic_step.leave,
    quadratic_step.least_squares,
    quadratic_step.step_back,
    quadratic_step.nonnegative,
    quadratic_step.least_distance,
    quadratic_step.quadratic_step,
    held.row_product,
    held.rotation_vector,
    held.axis_vector,
    held.hold_at,
    retraction.newton,
    retraction.retract,
    matrix_norm.square_sum,
    matrix_norm.multiply,
    matrix_norm.gram_power,
    matrix_norm.motion,
    matrix_norm.motion_along,
    matrix_norm.matrix_size,
    matrix_norm.size_slope,
    receptance.power_sum,
    receptance.solve_pivoting,
    receptance.receptance_cost,
    receptance.force_along,
    receptance.add_row_slopes,
    receptance.sweep_pair,
    receptance.receptance_slope,
    judge.mobility,
    judge.spread_rates,
    judge.stiffness_cost,
    judge.add_task_slopes,
    judge.stiffness_slope,
    judge.cost_at,
    judge.slope_at,
    judge.limit_at,
    descend.first_model,
    descend.lagrangian_change,
    descend.update,
    descend.line_search,
    descend.descend_one,
)


@cache
def descents() -> Kernel:
    """`flexmodal.optimisation.descent.descend.descend_all` on an `Arm`."""
    purpose = "descents of a search"
    return together(
        *_LOWEST_FIRST, last=descend.descend_all, purpose=purpose, seconds=COMPILATION, allocates=False
    )
