"""Is a posture a local optimum? Judged from values alone, with multipliers of the right sign."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from flexmodal.errors import Fault
from flexmodal.frf import PointDirection
from flexmodal.optimisation import PostureProblem

NEAR = 1e-6
"""A joint this near its limit counts as on it [rad]: the cost can gain no more than that times its slope."""


def directions(*texts: str) -> tuple[PointDirection, ...]:
    return tuple(PointDirection.parse(text) for text in texts)


def difference(function, values: np.ndarray, step: float) -> np.ndarray:
    """Fourth-order central differences along every entry, last axis."""
    slopes = []
    for unit in np.eye(len(values)):
        near = function(values + step * unit) - function(values - step * unit)
        far = function(values + 2 * step * unit) - function(values - 2 * step * unit)
        slopes.append((8 * near - far) / (12 * step))
    return np.stack(slopes, axis=-1)


def gain_left(problem: PostureProblem, values: np.ndarray) -> float:
    """Size of the gradient of the Lagrangian with the best multipliers there are (Karush, Kuhn, Tucker).

    Those of the hold may have any sign, those of a limit only the one that pushes back. The gradient and
    the constraint's Jacobian are differences of values; nothing of the search is used.
    """

    def cost(trial: np.ndarray) -> np.ndarray:
        return np.array(problem.cost_and_gradient(trial)[0])

    columns = [np.zeros((len(values), 0))]
    gradient = difference(cost, values, 2e-4)
    if problem.hold is not None:
        hold = problem.hold
        columns.append(difference(lambda trial: hold.error(problem.posed(trial)), values, 1e-3).T)
    held = sum(column.shape[1] for column in columns)
    unit = np.eye(len(values))
    at_lower, at_upper = values <= problem.lower + NEAR, values >= problem.upper - NEAR
    columns += [unit[:, at_lower], -unit[:, at_upper]]
    matrix = np.hstack(columns)
    if matrix.shape[1] == 0:
        return float(np.linalg.norm(gradient))
    lowest = np.r_[np.full(held, -np.inf), np.zeros(matrix.shape[1] - held)]
    multipliers = lsq_linear(matrix, gradient, bounds=(lowest, np.inf), tol=1e-14).x
    return float(np.linalg.norm(matrix @ multipliers - gradient))


def keys(faults: tuple[Fault, ...]) -> list[str]:
    return sorted(fault.key for fault in faults)
