"""The thesis's own search, for comparison: gradient descent in the null space of the end-effector.

    q̇ = −k_o (1 − J⁺J) ∂ξ/∂q − k_p J⁺ e        [Hearne 3.13, 3.14]

with fixed gains and, over the last tenth, a position gain ten times larger. Here ξ is the logarithmic cost.
It has no line search: it converges slowly, and where the gain is too large, not at all.
"""

from __future__ import annotations

import numpy as np

from flexmodal.optimisation.descent import GRADIENT
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search.descents import Watch
from flexmodal.optimisation.search.ends import Descent


def null_space_descent(
    problem: PostureProblem,
    start: np.ndarray,
    *,
    iterations: int = 1000,
    gain: float = 0.02,
    position_gain: float = 0.1,
    watch: Watch = lambda values, cost: None,
) -> Descent:
    """Follow the projected gradient for a fixed number of steps from a start, on the hold or not.

    Args:
        problem: what to minimise and what to hold.
        start: vector of the commanded joints [rad, m].
        iterations: number of steps.
        gain: k_o, step per unit gradient [rad²].
        position_gain: k_p, share of the position error removed in a step.
        watch: told every iterate.
    """
    values = np.clip(start, problem.lower, problem.upper)
    for count in range(iterations):
        cost, gradient = problem.cost_and_gradient(values)
        watch(values, cost)
        error, jacobian = problem.held(values)
        inverse = np.linalg.pinv(jacobian)
        pull = min(1.0, position_gain * (10 if count >= 0.9 * iterations else 1))
        slide = gradient - inverse @ (jacobian @ gradient)
        values = np.clip(values - gain * slide - pull * (inverse @ error), problem.lower, problem.upper)
    cost, gradient = problem.cost_and_gradient(values)
    error, jacobian = problem.held(values)
    slide = gradient - np.linalg.pinv(jacobian) @ (jacobian @ gradient)
    settled = float(np.linalg.norm(slide)) <= 1e3 * GRADIENT and float(np.linalg.norm(error)) <= 1e-6
    return Descent(values, cost, settled, iterations)
