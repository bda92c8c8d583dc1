"""The best member of a one-parameter family of postures, and every local one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmodal.cards import FamilyCard
from flexmodal.errors import InCollision
from flexmodal.optimisation.problem import PostureProblem

_SAMPLES = 400
"""Members looked at before the minima between them are refined."""


def family_values(problem: PostureProblem, family: FamilyCard, parameter: float) -> np.ndarray:
    """Vector of the member at a value of the parameter; joints it does not name are 0.

    Args:
        problem: whose joints.
        family: which member depends on a parameter how.
        parameter: its value [rad, m].
    """
    named = {family.parameter: parameter}
    named |= {joint: factor * parameter for joint, factor in family.follow.items()}
    return np.array([named.get(name, 0.0) for name in problem.names])


def search_family(
    problem: PostureProblem, family: FamilyCard, advance: Callable[[], None] = lambda: None
) -> list[tuple[float, np.ndarray]]:
    """Cost and vector of every local minimum along the family, ends included, best first.

    Args:
        problem: what to minimise.
        family: where to look.
        advance: called once a member of the first look.
    """
    from scipy.optimize import minimize_scalar

    blocked: list[InCollision] = []

    def cost(parameter: float) -> float:
        try:
            return problem.cost(family_values(problem, family, float(parameter)))
        except InCollision as error:
            blocked.append(error)
            return np.inf

    low, high = sorted((family.start, family.stop))
    grid = np.linspace(low, high, _SAMPLES + 1)
    sampled = np.empty(len(grid))
    for place, parameter in enumerate(grid):
        sampled[place] = cost(parameter)
        advance()
    if not np.any(np.isfinite(sampled)):
        raise blocked[0]
    left, right = np.r_[np.inf, sampled[:-1]], np.r_[sampled[1:], np.inf]
    minima = []
    for place in map(int, np.flatnonzero((sampled <= left) & (sampled < right) & np.isfinite(sampled))):
        best, value = grid[place], sampled[place]
        if 0 < place < len(grid) - 1:
            bounds = (grid[place - 1], grid[place + 1])
            refined = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-10})
            if refined.fun < value:
                best, value = refined.x, refined.fun
        minima.append((float(value), family_values(problem, family, float(best))))
    return sorted(minima, key=lambda item: item[0])
