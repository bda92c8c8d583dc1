"""A sequence of postures bettered as a whole: a sequence of linear programmes within a trust region.

Each linear programme moves all postures at once along the holds' tangents, within limits and speeds, so as to
lower the linearised cost; for the worst point it is exact in which point is the worst. Then every posture is
brought back onto its hold. What that spoils of the speeds is corrected in a second go.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError
from flexmodal.optimisation.path.problem import PathProblem

_FIRST, _LEAST = 0.1, 1e-6
"""Trust region at first and when the search ends [rad, m]."""

Postures = Float[np.ndarray, "point commanded"]


def improve(
    problem: PathProblem,
    start: Postures,
    *,
    iterations: int = 60,
    advance: Callable[[], None] = lambda: None,
    accepted: Callable[[Postures], None] = lambda postures: None,
) -> Postures:
    """Better a sequence that keeps hold, limits and speeds; each accepted step lowers the cost.

    Args:
        problem: the path.
        start: a posture for each point.
        iterations: linear programmes at most.
        advance: called once for each.
        accepted: told every sequence that is better than the one before.
    """
    current, radius = start, _FIRST
    cost, parts, slopes = _cost(problem, current)
    for _ in range(iterations):
        advance()
        found = _trial(problem, current, parts, slopes, radius)
        if found is None:
            radius /= 4
        else:
            trial, promised = found
            try:
                trial_cost, trial_parts, trial_slopes = _cost(problem, trial)
            except FlexmodalError:
                trial_cost = np.inf
            gained = cost - trial_cost
            if gained > 0.1 * promised > 0:
                current, cost, parts, slopes = trial, trial_cost, trial_parts, trial_slopes
                accepted(current)
                radius = min(0.5, radius * (2 if gained > 0.7 * promised else 1))
            else:
                radius /= 3
        if radius < _LEAST:
            break
    return current


def path_cost(problem: PathProblem, postures: Postures) -> float:
    """Ln Σ v or ln max v, plus the smoothness term.

    Args:
        problem: the path.
        postures: one for each point.
    """
    return _cost(problem, postures)[0]


def _cost(problem: PathProblem, postures: Postures) -> tuple[float, np.ndarray, np.ndarray]:
    """Cost of the whole; costs and gradients of the points."""
    pairs = zip(problem.at, postures, strict=True)
    found = [at.cost_and_gradient(values) for at, values in pairs]
    parts, slopes = np.array([part for part, _ in found]), np.array([slope for _, slope in found])
    top = float(parts.max())
    whole = top + (float(np.log(np.exp(parts - top).sum())) if problem.way == "sum" else 0.0)
    return whole + problem.smoothness * float(np.mean(problem.shares(postures) ** 2)), parts, slopes


def _trial(
    problem: PathProblem, current: Postures, parts: np.ndarray, slopes: np.ndarray, radius: float
) -> tuple[Postures, float] | None:
    """Postures a linear programme away, back on their holds, and the gain it promises."""
    bent = np.zeros_like(current)
    for _ in range(3):
        found = _programme(problem, current, parts, slopes, radius, bent)
        if found is None:
            return None
        step, promised = found
        retracted = [
            at.retract(values, steps=15) for at, values in zip(problem.at, current + step, strict=True)
        ]
        if any(values is None for values in retracted):
            return None
        trial = np.array(retracted)
        if np.all(problem.shares(trial) <= 1.0):
            return trial, promised
        bent = trial - current - step
    return None


def _programme(
    problem: PathProblem,
    current: Postures,
    parts: np.ndarray,
    slopes: np.ndarray,
    radius: float,
    bent: np.ndarray,
) -> tuple[np.ndarray, float] | None:
    """The step that lowers the linearised cost most; `bent` is what retraction is expected to add."""
    from scipy.optimize import linprog
    from scipy.sparse import block_diag, csr_matrix, eye, hstack, kron, vstack

    points, joints = current.shape
    flat = points * joints
    pull = _smoothness_slope(problem, current).ravel()
    held = [at.held(values)[1] for at, values in zip(problem.at, current, strict=True)]
    tangent = hstack([block_diag(held), csr_matrix((sum(map(len, held)), 1))])
    between = kron(csr_matrix(np.diff(np.eye(points), axis=0)), eye(joints))
    between = hstack([between, csr_matrix((between.shape[0], 1))])
    moved = np.diff(current + bent, axis=0).ravel()
    reach = problem.reach.ravel() * (1 - 1e-9)
    rows, bounds = [between, -between], [reach - moved, reach + moved]
    if problem.way == "sum":
        shares = np.exp(parts - parts.max())
        goal = np.r_[((shares / shares.sum())[:, None] * slopes).ravel() + pull, 0.0]
    else:  # the extra variable is the largest linearised cost
        rows.append(
            hstack([block_diag([slope[None] for slope in slopes]), -csr_matrix(np.ones((points, 1)))])
        )
        bounds.append(parts.max() - parts)
        goal = np.r_[pull, 1.0]
    lower = np.maximum(problem.at[0].lower - current, -radius).ravel()
    upper = np.minimum(problem.at[0].upper - current, radius).ravel()
    limits = np.column_stack([np.r_[np.minimum(lower, 0.0), -np.inf], np.r_[np.maximum(upper, 0.0), np.inf]])
    if problem.way == "sum":
        limits[-1] = 0.0
    answer = linprog(
        goal,
        A_ub=vstack(rows),
        b_ub=np.concatenate(bounds),
        A_eq=tangent,
        b_eq=np.zeros(tangent.shape[0]),
        bounds=limits,
        method="highs",
    )
    if answer.x is None or answer.status != 0:
        return None
    return answer.x[:flat].reshape(points, joints), -float(answer.fun)


def _smoothness_slope(problem: PathProblem, postures: Postures) -> np.ndarray:
    """Derivative of the smoothness term along every joint of every posture."""
    reach = problem.reach
    moved = np.diff(postures, axis=0)
    each = 2 * moved / reach**2 * problem.smoothness / moved.size
    slope = np.zeros_like(postures)
    slope[1:] += each
    slope[:-1] -= each
    return slope
