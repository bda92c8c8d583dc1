"""A wider law for an effect in its place, from where a fit of the narrower one ended."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.beside import seen_beside
from flexmodal.diagnosis.search.close_fit import tried_closely
from flexmodal.diagnosis.search.coarse import Look
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law

Rounds = tuple[tuple[float, int, int], ...]
ROUNDS: Rounds = ((0.2, 0, 40), (0.2, 8, 8), (0.1, 8, 5), (0.03, 8, 3))
"""Model error, steps, and how many starts go on; the last are fitted closely."""
BESIDE_INTEGRATED: Rounds = ((0.2, 0, 8), (0.2, 8, 3), (0.1, 8, 2), (0.03, 8, 1))
"""The same for torques beside others that are integrated in time too: each of their steps takes long. Beside
such torques one start alone is fitted closely."""
SAME = 1e-3
"""Relative difference of the costs of two fits below which they have ended in the same place."""


def at_next_level(
    setup: Setup,
    model: FittedFrfs,
    set_out: SetOut,
    is_enough: Callable[[FittedFrfs], bool],
) -> list[FittedFrfs]:
    """The model with the next level of its last effect, if there is one, fitted closely.

    Args:
        setup: what the diagnosis works with.
        model: fitted, with an effect that is added last.
        set_out: where else the fit may set out, for what was there before that effect.
        is_enough: whether a fit leaves nothing, so that no other start is followed.
    """
    narrow = model.hypothesis.placed[-1]
    level = level_above(narrow.effect, setup.context, narrow.where)
    if level is None:
        return []
    hypothesis = model.hypothesis.without(narrow.key).and_also(Placed(level.effect, narrow.where))
    own = of_last(model.hypothesis, model.x)
    before = [model.x[: -len(own)], *set_out.before]
    placed = hypothesis.placed[-1]
    told = [hypothesis.start(placed, *one) for one in set_out.told(level.effect, narrow.where)]
    seen = seen_beside(setup, model, by_force=narrow.effect.by_force)
    rounds = ROUNDS
    if seen.integrates(model.hypothesis.without(narrow.key)):
        rounds = BESIDE_INTEGRATED
    found = _followed(setup, seen, hypothesis, told, is_enough, rounds)
    if any(is_enough(one) for one in found):
        return found
    given = level.starts(setup.context, narrow.where, own)
    tried = [hypothesis.start(placed, one, x) for x in before for one in given]
    found += _followed(setup, seen, hypothesis, tried, is_enough, rounds)
    if not found or any(is_enough(one) for one in found):
        return found
    nearest = min(found, key=lambda one: one.cost)
    return [*found, *at_next_level(setup, nearest, set_out, is_enough)]


def level_above(effect: Effect, context: Context, where: str) -> Level | None:
    """The next level of an effect's law that may be in its place; None if there is none.

    Args:
        effect: at its present level.
        context: of the diagnosis.
        where: its place.
    """
    level = effect.next_level
    while level is not None and where not in level.effect.places(context):
        level = level.effect.next_level
    return level


def of_last(hypothesis: Hypothesis, x: Float[np.ndarray, " parameter"]) -> dict[str, float]:
    """Values of the last effect's own parameters, without prefix.

    Args:
        hypothesis: with effects.
        x: its coordinates.
    """
    placed = hypothesis.placed[-1]
    values = hypothesis.values_of(placed, hypothesis.space.values(x))
    names = (parameter.name for parameter in placed.effect.parameters(hypothesis.context, placed.where))
    return {name: values[name] for name in names}


def _followed(
    setup: Setup,
    seen: Look,
    hypothesis: Hypothesis,
    tried: Sequence[Float[np.ndarray, " parameter"]],
    is_enough: Callable[[FittedFrfs], bool],
    rounds: Rounds,
) -> list[FittedFrfs]:
    """The best of some starts, fitted closely; none after one that is enough or ends where another did."""
    todo = seen.started(hypothesis, tried, *rounds[0][::2])
    for number, (floor, steps, keep) in enumerate(rounds[1:]):
        setup.advance("fitting a wider law", number / len(rounds))
        nearer = parallel_map(partial(seen.fitted, floor=floor, steps=steps), todo)
        todo = sorted(nearer, key=lambda one: one.cost)[:keep]
    found: list[FittedFrfs] = []
    todo = todo[:1] if has_law(hypothesis.without(hypothesis.keys[-1])) else todo
    closely = parallel_map(lambda one: tried_closely(setup, hypothesis, one.x), todo)
    for _ in todo:
        setup.advance("fitting a wider law", 1 - 1 / len(rounds))
        fitted = next(closely)
        again = any(abs(one.cost - each.cost) < SAME * each.cost for one in fitted for each in found)
        found += fitted
        if again or any(is_enough(each) for each in fitted):
            break
    return found
