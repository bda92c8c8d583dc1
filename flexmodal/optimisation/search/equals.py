"""Optima that are equally good, joint values within a turn, and the posture nearest to a start that holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search.ends import Basins
from flexmodal.optimisation.search.starts import EQUAL, beside

_STEPS, _SETTLED = 60, 1e-6


@dataclass(frozen=True, eq=False)
class Equals:
    """Optima of one and the same value: an idle joint, or a wrist turned over."""

    values: Float[np.ndarray, "optimum commanded"]
    """The one to name first, then the others."""
    hits: int
    """Starts that ended in any of them."""


def merged(
    problem: PostureProblem, found: Basins, near: Float[np.ndarray, " commanded"] | None
) -> tuple[Equals, ...]:
    """Optima gathered by their value, best first; of equals the one nearest to a posture is named.

    Args:
        problem: whose joints.
        found: distinct optima, best first.
        near: the posture; all joints at 0 if none.
    """
    groups: list[list[int]] = []
    for place, cost in enumerate(found.cost.tolist()):
        if groups and cost - float(found.cost[groups[-1][0]]) <= EQUAL:
            groups[-1].append(place)
        else:
            groups.append([place])
    centre = np.zeros(len(problem.names)) if near is None else near
    answer = []
    for group in groups:
        values = np.array([within_a_turn(problem, found.values[place], near) for place in group])
        order = np.argsort(np.round(np.linalg.norm(values - centre, axis=1), 6), kind="stable")
        answer.append(Equals(values[order], int(np.sum(found.hits[group]))))
    return tuple(answer)


def within_a_turn(
    problem: PostureProblem,
    values: Float[np.ndarray, " commanded"],
    near: Float[np.ndarray, " commanded"] | None = None,
) -> Float[np.ndarray, " commanded"]:
    """The same posture with every turning joint within half a turn of 0, where its limits allow that.

    Args:
        problem: whose joints.
        values: of the commanded joints [rad, m].
        near: within half a turn of these instead.
    """
    centre = np.zeros(len(values)) if near is None else near
    turns = np.where(problem.turning, np.round((values - centre) / (2 * np.pi)), 0.0)
    turned = values - 2 * np.pi * turns
    return np.where((problem.lower <= turned) & (turned <= problem.upper), turned, values)


def nearest_held(
    problem: PostureProblem, start: Float[np.ndarray, " commanded"]
) -> Float[np.ndarray, " commanded"] | None:
    """The posture on the hold whose joints are nearest to a start, as far as descent finds it; None if none.

    Projected steps: towards the start along the self-motion, then back onto the hold.

    Args:
        problem: with a hold.
        start: of the commanded joints [rad, m].
    """
    here = problem.retract(beside(problem, start))
    if here is None:
        return None
    for _ in range(_STEPS):
        jacobian = problem.held(here)[1]
        wish = start - here
        along = wish - np.linalg.pinv(jacobian, rcond=1e-9) @ (jacobian @ wish)
        if np.linalg.norm(along) < _SETTLED:
            break
        length = 1.0
        while length > 1e-3:
            trial = problem.retract(np.clip(here + length * along, problem.lower, problem.upper))
            if trial is not None and np.linalg.norm(trial - start) < np.linalg.norm(here - start) - 1e-9:
                here = trial
                break
            length /= 2
        else:
            break
    return here
