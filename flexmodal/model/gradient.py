"""How the receptance changes with the posture, exactly and for little more than the value.

With `y = Z⁻¹ jᵀ` solved once for each direction,

    dα_uv/dq_k = (∂j_u/∂q_k) y_v + y_uᵀ (∂j_vᵀ/∂q_k) + ω² y_uᵀ (∂D/∂q_k) y_v.

`∂D/∂q` is what the derivative of the inverse dynamics gives without gravity, column by column; `∂J/∂q`
follows from the Jacobian itself, because turning joint k turns every axis and every lever arm behind it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import SingularResponse
from flexmodal.frf import PointDirection
from flexmodal.frf.kernels.task import is_damped, refuse_singular
from flexmodal.frf.receptance import dynamic_stiffness
from flexmodal.model.posed import PosedRobot


def jacobian_derivative(jacobian: Float[np.ndarray, "6 moving"]) -> Float[np.ndarray, "6 moving moving"]:
    """∂J[:, i]/∂q_k of a point's Jacobian in world axes, from the Jacobian alone.

    With columns (v_i, w_i), linear and angular: a joint k before i turns the whole column i, `w_k × v_i` and
    `w_k × w_i`; a joint k behind i moves the point, `w_i × v_k`. Columns of joints that do not carry the
    point are zero and stay so. Joints must be numbered from the base outwards.

    Args:
        jacobian: six rows, linear then angular, over all moving joints.

    Returns:
        Derivative by row, column i and joint k.
    """
    before = np.tri(jacobian.shape[1], dtype=bool)  # [i, k]: k at or before i
    column, turning = jacobian[:, :, None], jacobian[3:, None, :]  # of i, of k
    turned = _cross(turning, column[:3])  # w_k × v_i
    moved = _cross(column[3:], jacobian[:3, None, :])  # w_i × v_k
    rotated = _cross(turning, column[3:])  # w_k × w_i
    return np.concatenate([np.where(before, turned, moved), np.where(before, rotated, 0.0)])


def _cross(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Cross product along the first axis, broadcast over the others."""
    (a, b, c), (x, y, z) = left, right
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def receptance_and_gradient(
    posed: PosedRobot, directions: Sequence[PointDirection], frequency: Float[np.ndarray, " line"]
) -> tuple[Complex[np.ndarray, "line dir dir"], Complex[np.ndarray, "line dir dir moving"]]:
    """Receptance matrix among some directions and its derivative along every moving joint.

    Args:
        posed: the robot in its posture.
        directions: rows and columns of the matrix.
        frequency: checked frequency axis [Hz].

    Returns:
        α [m/N] by line, response and reference, and ∂α/∂q [m/(N·rad)] with the joint last.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    pick = posed.robot.flexible_index
    full = {d.point: posed.full_jacobian(d.point) for d in directions}
    slopes = {point: jacobian_derivative(jacobian) for point, jacobian in full.items()}
    rows = np.array([d.selector @ full[d.point] for d in directions])[:, pick]
    row_slopes = np.array([np.tensordot(d.selector, slopes[d.point], 1)[pick] for d in directions])
    stack = dynamic_stiffness(posed.system, frequency)
    if not is_damped(posed.system.damping):
        omega = 2 * np.pi * frequency
        terms = (np.diag(posed.system.stiffness), np.diag(posed.system.mass), np.diag(posed.system.damping))
        size = sum(term * omega[:, None] ** power for term, power in zip(terms, (0, 2, 1), strict=True))
        refuse_singular(stack, np.asarray(size), omega)
    try:
        solved = np.linalg.solve(stack, rows.T.astype(complex)[None])  # [line, joint, direction]
    except np.linalg.LinAlgError:
        raise SingularResponse(
            "the receptance is infinite here: an undamped mode is driven at its natural frequency; give the "
            "joints damping or choose another frequency"
        ) from None
    value = rows @ solved
    left = np.einsum("uik,liv->luvk", row_slopes, solved)
    square = (2 * np.pi * frequency[:, None, None, None]) ** 2
    pulled = np.tensordot(solved, posed.mass_derivative(), axes=(1, 0))  # [line, u, joint, moving]
    mass = square * np.einsum("luik,liv->luvk", pulled, solved)
    return value, left + np.swapaxes(left, 1, 2) + mass
