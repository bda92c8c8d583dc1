"""The step of one iteration: a quadratic model minimised on the hold's tangent space, between the limits."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float


def quadratic_step(
    model: Float[np.ndarray, "joint joint"],
    gradient: Float[np.ndarray, " joint"],
    constraint: Float[np.ndarray, "held joint"],
    lower: Float[np.ndarray, " joint"],
    upper: Float[np.ndarray, " joint"],
) -> Float[np.ndarray, " joint"]:
    """Minimise ½ sᵀBs + gᵀs with constraint · s = 0 and lower ≤ s ≤ upper.

    Where limits are in the way, the problem is turned into one of least distance and solved through its
    dual by non-negative least squares (Lawson and Hanson 1974, chapter 23): exact, in finitely many steps.

    Args:
        model: B, positive definite.
        gradient: g.
        constraint: what the step must not change, row by row.
        lower: 0 or less: not to move is always allowed.
        upper: 0 or more.

    Raises:
        LinAlgError: the model is not positive definite, or the step so long that the limits drown in it.
    """
    basis = null_space(constraint)
    if basis.shape[1] == 0:
        return np.zeros_like(gradient)
    root = np.linalg.cholesky(basis.T @ model @ basis)
    centre = np.linalg.solve(root, basis.T @ gradient)
    reach = np.linalg.solve(root, basis.T).T  # s = reach (u − centre), and ½|u|² is what is minimised
    free = -reach @ centre
    if np.all((lower <= free) & (free <= upper)):
        return free
    return np.clip(free + reach @ _least_distance(reach, lower - free, upper - free), lower, upper)


def null_space(matrix: Float[np.ndarray, "held joint"]) -> Float[np.ndarray, "joint free"]:
    """Orthonormal basis of what a constraint leaves free."""
    if matrix.shape[0] == 0:
        return np.eye(matrix.shape[1])
    _, values, right = np.linalg.svd(matrix)
    rank = int(np.sum(values > 1e-9 * max(values[0], 1e-30))) if len(values) else 0
    return right[rank:].T


def _least_distance(
    rows: Float[np.ndarray, "joint free"],
    lower: Float[np.ndarray, " joint"],
    upper: Float[np.ndarray, " joint"],
) -> Float[np.ndarray, " free"]:
    """The shortest u with lower ≤ rows · u ≤ upper."""
    from scipy.optimize import nnls

    size = np.linalg.norm(rows, axis=1)[:, None]
    scaled = np.column_stack([rows, lower, upper]) / np.where(size > 0, size, np.inf)
    above, below = scaled[:, [*range(rows.shape[1]), -2]], -scaled[:, [*range(rows.shape[1]), -1]]
    stacked = np.concatenate([above, below])
    stacked = stacked[np.isfinite(stacked[:, -1])]
    target = np.zeros(stacked.shape[1])
    target[-1] = 1.0
    dual, _ = nnls(stacked.T, target)
    residual = stacked.T @ dual - target
    if residual[-1] >= 0:
        raise np.linalg.LinAlgError("the limits are lost in rounding beside so large a step")
    return -residual[:-1] / residual[-1]
