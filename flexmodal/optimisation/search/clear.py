"""Descents that keep a clearance: first out of what is in the way, then down with ever weaker barriers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.optimisation.clearance import Apart
from flexmodal.optimisation.descent import UNREACHED, descend_all, work_for
from flexmodal.optimisation.problem import Evaluation

WEIGHTS = (1e-2, 1e-4, 1e-6)
"""Of the barrier, one after the other; one that is not met is the last."""

_SPARE = 0.3
"""Share of the barrier's reach that a start is moved away by besides."""

_FLAT = 1e-6
"""Slope of the barrier, over its weight, that is none [1/rad]: links that are always near have no other."""

_OUT = 60
"""Most iterations of the way out."""


def solve_clear(
    at: Evaluation,
    iterations: int,
    values: np.ndarray,
    cost: np.ndarray,
    end: np.ndarray,
    steps: np.ndarray,
) -> None:
    """Descend from every start; the arrays are those of `flexmodal.optimisation.descent.descend_all`.

    Args:
        at: of a problem with a clearance; its trouble is set where a start comes to nothing.
        iterations: most of each descent.
        values: starts, overwritten by where they end.
        cost: receives the costs, without the barrier.
        end: receives how they ended.
        steps: receives the iterations.
    """
    for row in range(len(values)):
        _one(at, iterations, *(part[row : row + 1] for part in (values, cost, end, steps)))


def _one(
    at: Evaluation,
    iterations: int,
    values: np.ndarray,
    cost: np.ndarray,
    end: np.ndarray,
    steps: np.ndarray,
) -> None:
    problem, clearance = at.problem, at.problem.clearance
    assert clearance is not None
    out = replace(problem, objective=Apart(clearance, _SPARE), clearance=None)
    count = _descend(Evaluation(out), _OUT, values, cost, end)
    cost[0], steps[0] = np.inf, count
    if end[0] == UNREACHED:
        return
    for weight in WEIGHTS:
        there = Evaluation(replace(problem, clearance=replace(clearance, weight=weight)))
        count += _descend(there, iterations, values, cost, end)
        steps[0] = count
        if end[0] == UNREACHED:
            at.trouble = there.trouble
            return
        if not np.any(np.abs(clearance.barrier(problem.posed(values[0]))[1]) > _FLAT * clearance.weight):
            break
    cost[0] = problem.objective.cost_and_gradient(problem.posed(values[0]))[0]


def _descend(at: Evaluation, iterations: int, values: np.ndarray, cost: np.ndarray, end: np.ndarray) -> int:
    """One descent; its iterations."""
    problem, count = at.problem, np.zeros(1, dtype=np.int64)
    work = work_for(problem.held_components, len(problem.names))
    descend_all(at, problem.box, work, iterations, values, cost, end, count, np.zeros((0, 0)))
    return int(count[0])
