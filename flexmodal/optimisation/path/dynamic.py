"""The best sequence through the nodes: dynamic programming, forwards over the points."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.errors import InCollision, Unreachable
from flexmodal.optimisation.path.nodes import Nodes, cost_of
from flexmodal.optimisation.path.problem import PathProblem


def best_sequence(problem: PathProblem, nodes: Nodes) -> Float[np.ndarray, "point commanded"]:
    """One node for each point, neighbours within the joints' reach, of least summed or worst value.

    Of sequences that are equally good the smoother one: `smoothness` times the mean square of the shares of
    speed is added, in units of the least value that any sequence must have.

    Args:
        problem: the path.
        nodes: postures for each point.

    Raises:
        Unreachable: no sequence keeps within speeds and stride; says by how much.
    """
    costs = [np.array([cost_of(at, q) for q in group]) for at, group in zip(problem.at, nodes, strict=True)]
    scale = max(float(group.min()) for group in costs)
    if not np.isfinite(scale):
        place = next(k for k, group in enumerate(costs) if not np.isfinite(group.min()))
        raise InCollision(f"point {place}: no posture that was tried keeps the clearance")
    values = [np.exp(np.minimum(group - scale, 600.0)) for group in costs]
    weight = problem.smoothness * (len(nodes) if problem.way == "sum" else 1) / len(nodes)
    total = values[0].copy()
    smooth = np.zeros(len(total))
    back: list[np.ndarray] = []
    for step, (here, there) in enumerate(pairwise(nodes)):
        shares = _shares(here, there, problem.reach[step])
        allowed = shares.max(axis=2) <= 1.0
        if not np.any(allowed & np.isfinite(total)[:, None]):
            raise _too_fast(problem, nodes, step)
        pull = smooth[:, None] + weight * np.mean(shares**2, axis=2)
        reached = np.where(allowed, total[:, None] + pull, np.inf)
        choice = np.argmin(reached, axis=0)
        back.append(choice)
        columns = np.arange(len(there))
        closed = ~np.isfinite(reached[choice, columns])
        base = total[choice]
        total = base + values[step + 1] if problem.way == "sum" else np.maximum(base, values[step + 1])
        total = np.where(closed, np.inf, total)
        smooth = np.where(closed, 0.0, pull[choice, columns])
    place = int(np.argmin(total + smooth))
    picked = [place]
    for choice in reversed(back):
        picked.append(int(choice[picked[-1]]))
    return np.array([group[place] for group, place in zip(nodes, reversed(picked), strict=True)])


def _shares(here: np.ndarray, there: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """How much of its reach each joint uses from every node to every next one."""
    moved = np.abs(there[None] - here[:, None])
    return np.asarray(moved / reach)


def _too_fast(problem: PathProblem, nodes: Nodes, step: int) -> Unreachable:
    """The error where the joints would have to be faster, with the factor that the best sequence needs."""
    need = np.zeros(len(nodes[0]))
    for place, (here, there) in enumerate(pairwise(nodes)):
        worst = _shares(here, there, problem.reach[place]).max(axis=2)
        need = np.min(np.maximum(need[:, None], worst), axis=0)
    return Unreachable(
        f"no sequence of postures keeps within the joint speeds and strides: stuck between points {step + 1} "
        f"and {step + 2}; with the postures looked at, steps {float(need.min()):.3g} times as long would do: "
        "go slower, put more points between, or look at more nodes"
    )
