"""The compiled functions of the search, made when first asked for; plain Python without numba."""

from __future__ import annotations

from functools import cache
from inspect import unwrap
from typing import Any

from flexmodal.frf.kernels import pivoted
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.model.batch import factor, kinematics
from flexmodal.model.batch import gradient_kernel as gradient
from flexmodal.optimisation.compiled import (
    algebra,
    descent,
    held,
    judge,
    matrix_norm,
    merge,
    quadratic,
    receptance,
)

_LOWEST_FIRST = (
    kinematics.cross,
    kinematics.turn,
    kinematics.place_joints,
    kinematics.place_bodies,
    kinematics.mass_matrix,
    kinematics.point_jacobian,
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
    quadratic.whiten,
    quadratic.leave,
    quadratic.least_squares,
    quadratic.step_back,
    quadratic.nonnegative,
    quadratic.least_distance,
    quadratic.quadratic_step,
    held.row_product,
    held.rotation_vector,
    held.axis_vector,
    held.held_error,
    held.newton,
    held.retract,
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
    judge.cost_of,
    judge.gradient_of,
    descent.first_model,
    descent.lagrangian_change,
    descent.update,
    descent.line_search,
    descent.descend_one,
)


@cache
def descents(compiled: bool) -> Any:
    """`flexmodal.optimisation.compiled.descent.descend_all`."""
    if not compiled:
        return unwrap(descent.descend_all)
    return together(*_LOWEST_FIRST, last=descent.descend_all, allocates=False).compiled


@cache
def merging(compiled: bool) -> Any:
    """`flexmodal.optimisation.compiled.merge.merge`."""
    return Kernel(merge.merge).compiled if compiled else unwrap(merge.merge)
