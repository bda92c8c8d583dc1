"""Postures for each point of a path, among which the best sequence is chosen.

Three kinds: tracks, which follow the path from random postures and so cover the self-motion; valleys, which
do the same but slide down to a local optimum at each point; and bridges, postures between two valleys.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError
from flexmodal.optimisation.path.problem import PathProblem
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search import descend, unreachable

_APART = 1e-2
"""Postures nearer than this at every joint are one node [rad, m]."""

_VALLEYS, _BRIDGES = 8, 9
"""Most valleys followed, and postures on the way from one to another."""

_SLIDE = 12
"""Iterations of a descent at each point."""

Nodes = list[np.ndarray]
"""For each point an array of postures, node × commanded joint."""


def nodes_of(
    problem: PathProblem, count: int, seed: int, advance: Callable[[], None] = lambda: None
) -> Nodes:
    """Postures on the hold and within the limits at each point.

    Args:
        problem: the path.
        count: random tracks; valleys and bridges come on top.
        seed: of the random postures.
        advance: called once a point.

    Raises:
        Unreachable: no posture was found for some point.
    """
    generator = np.random.default_rng(seed)
    tracks, valleys = _tracks(problem, count, generator, advance)
    backwards = _followed(problem, valleys[-1], range(len(problem.points) - 2, -1, -1))
    result = []
    for place, at in enumerate(problem.at):
        low = _thinned(np.concatenate([valleys[place], backwards.get(place, valleys[place][:0])]))
        low = low[np.argsort([cost_of(at, values) for values in low])][:_VALLEYS]
        result.append(_thinned(np.concatenate([low, _bridges(at, low), tracks[place]])))
    return result


def _tracks(
    problem: PathProblem, count: int, generator: np.random.Generator, advance: Callable[[], None]
) -> tuple[Nodes, Nodes]:
    """Random postures followed along the path, those that are lost replaced; and the valleys beside them."""
    tracks: Nodes = []
    valleys: Nodes = []
    for place, at in enumerate(problem.at):
        kept = [] if place == 0 else [at.retract(values, steps=20) for values in tracks[-1]]
        found = [values for values in kept if values is not None]
        tries = 0
        while len(found) < count and tries < 4 * count:
            values = at.retract(at.random_vector(generator), steps=30)
            found += [] if values is None else [values]
            tries += 1
        if not found:
            raise unreachable(at, tries)
        tracks.append(np.array(found))
        if place == 0:
            order = np.argsort([cost_of(at, values) for values in found])[: 4 * _VALLEYS]
            seeds = np.array(found)[order]
        else:
            seeds = valleys[-1]
        slid = _slid(at, seeds, None if place == 0 else problem.reach[place - 1])
        if len(slid) == 0:
            slid = _slid(at, tracks[-1][:_VALLEYS], None)
        best = slid[np.argsort([cost_of(at, values) for values in slid])] if len(slid) else tracks[-1][:1]
        valleys.append(_thinned(best)[: 2 * _VALLEYS])
        advance()
    return tracks, valleys


def _followed(problem: PathProblem, seeds: np.ndarray, places: range) -> dict[int, np.ndarray]:
    """Valleys followed the other way, so that one that opens late is known early."""
    found = {}
    for place in places:
        seeds = _slid(problem.at[place], seeds, problem.reach[place])
        if len(seeds) == 0:
            break
        found[place] = seeds
    return found


def _slid(at: PostureProblem, seeds: np.ndarray, reach: np.ndarray | None) -> np.ndarray:
    """Local optima beside some postures, no farther away than the joints get in the time."""
    found = []
    for values in seeds:
        limits = (at.lower, at.upper)
        if reach is not None:
            limits = (np.maximum(at.lower, values - reach), np.minimum(at.upper, values + reach))
        try:
            end = descend(replace(at, limits=limits), values, iterations=30 if reach is None else _SLIDE)
        except FlexmodalError:
            end = None
        found += [] if end is None else [end.values]
    return np.array(found).reshape(len(found), len(at.names))


def _bridges(at: PostureProblem, valleys: np.ndarray) -> np.ndarray:
    """Postures between every two valleys, brought onto the hold."""
    found = []
    for place, one in enumerate(valleys):
        for other in valleys[:place]:
            for share in np.linspace(0, 1, _BRIDGES + 2)[1:-1]:
                values = at.retract(one + share * (other - one), steps=20)
                found += [] if values is None else [values]
    return np.array(found).reshape(len(found), len(at.names))


def _thinned(postures: Float[np.ndarray, "node commanded"]) -> Float[np.ndarray, "kept commanded"]:
    """The postures, without those beside an earlier one."""
    kept: list[np.ndarray] = []
    for values in postures:
        if not kept or np.min(np.max(np.abs(np.array(kept) - values), axis=1)) > _APART:
            kept.append(values)
    return np.array(kept).reshape(len(kept), postures.shape[1])


def cost_of(at: PostureProblem, values: np.ndarray) -> float:
    """Logarithm of the objective without its gradient; infinite where there is none.

    Args:
        at: problem of one point.
        values: of the commanded joints [rad, m].
    """
    if not at.is_clear(values):
        return np.inf
    try:
        value = at.objective.value(at.posed(values))
    except FlexmodalError:
        return np.inf
    with np.errstate(divide="ignore"):
        return float(np.log(value)) * (-1 if at.objective.larger_is_better else 1)
