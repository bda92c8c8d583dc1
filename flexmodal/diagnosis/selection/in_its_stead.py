"""How sure one of several effects is beside the others, whatever else is missing.

What an effect gained when it was added says little once others are there: while these were missing it may
have been tied with anything. So it is left out of the final model, and what was considered when it was looked
for is put in its place, all else fitted again. It is sure if it takes most of what the others leave above the
noise and nothing in its stead fits as well:

    p = p(model) / (Σ p(each in its stead) + p(others alone) + `ALONE` p(model)),

by the formula of `confidence`. How much the final model leaves does not matter: that something is missing
besides is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from flexmodal.diagnosis.effects import Effect
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.search.close_fit import fitted_closely, tried_closely
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.confidence import ALONE, PIECES, figures_of, probabilities
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup

Key = tuple[str, str]
"""Name and place of an effect."""

A_FEW = 8
"""Steps of a fit at each model error: what is in the effect's place is near its end."""


class Refits:
    """Fits of one model with an effect less, or with another one in its stead, each made once.

    They are asked for when effects are reconsidered, when it is asked which are sure, and when needless ones
    go.
    """

    def __init__(self, setup: Setup) -> None:
        """Nothing is fitted yet.

        Args:
            setup: what the diagnosis works with.
        """
        self.setup = setup
        self._model: FittedFrfs | None = None
        self._less: dict[Key, FittedFrfs] = {}
        self._instead: dict[tuple[Key, Effect, str], list[FittedFrfs]] = {}

    def without(self, model: FittedFrfs, key: Key) -> FittedFrfs:
        """The model without one of its effects, fitted again; from what was believed where that cannot be.

        Args:
            model: with the effect.
            key: its name and place.
        """
        return self.without_each(model, [key])[0]

    def without_each(self, model: FittedFrfs, keys: Sequence[Key]) -> list[FittedFrfs]:
        """The same without one and the other of some of its effects.

        Args:
            model: with the effects.
            keys: their names and places.
        """
        self._of(model)
        new = [key for key in keys if key not in self._less]
        self._less |= zip(new, parallel_map(partial(without, self.setup, model), new), strict=True)
        return [self._less[key] for key in keys]

    def instead(self, model: FittedFrfs, key: Key, others: Sequence[FittedFrfs]) -> list[FittedFrfs]:
        """The model with other effects in place of one, fitted again.

        Args:
            model: with the effect.
            key: its name and place.
            others: models whose last effects are put in its place.
        """
        self._of(model)
        laws = [other.hypothesis.placed[-1] for other in others]
        told = [(key, law.effect, law.where) for law in laws]
        new = {one: other for one, other in zip(told, others, strict=True) if one not in self._instead}
        fitted = parallel_map(partial(in_its_stead, self.setup, model, key), new.values())
        self._instead |= zip(new, fitted, strict=True)
        return [found for one in told for found in self._instead[one]]

    def _of(self, model: FittedFrfs) -> None:
        """What is known of another model goes."""
        if model is not self._model:
            self._model, self._less, self._instead = model, {}, {}


def without(setup: Setup, model: FittedFrfs, key: Key) -> FittedFrfs:
    """A model without one of its effects, fitted again; from what was believed where that cannot be.

    Args:
        setup: what the diagnosis works with.
        model: with the effect.
        key: its name and place.
    """
    prefix = "{}@{}.".format(*key)
    kept = [not name.startswith(prefix) for name in model.hypothesis.space.names]
    less, start = model.hypothesis.without(key), model.x[np.array(kept)]
    found = tried_closely(setup, less, start)
    return found[0] if found else fitted_closely(setup, less, np.zeros(len(start)))


def in_its_stead(setup: Setup, model: FittedFrfs, key: Key, other: FittedFrfs) -> list[FittedFrfs]:
    """A model with another effect in place of one, fitted again; none where there is no such model.

    Args:
        setup: what the diagnosis works with.
        model: with the effect.
        key: its name and place.
        other: model whose last effect is put in its place.
    """
    now = dict(zip(model.hypothesis.space.names, model.x.tolist(), strict=True))
    own = dict(zip(other.hypothesis.space.names, other.x.tolist(), strict=True))
    hypothesis = model.hypothesis.without(key).and_also(other.hypothesis.placed[-1])
    start = np.array([now.get(name, own.get(name, 0.0)) for name in hypothesis.space.names])
    return tried_closely(setup, hypothesis, start, near=True, steps=A_FEW)


def also(setup: Setup, model: FittedFrfs, other: FittedFrfs) -> list[FittedFrfs]:
    """A model with one effect more, fitted again; none where there is no such model.

    Args:
        setup: what the diagnosis works with.
        model: with effects.
        other: model whose last effect is added.
    """
    own = dict(zip(other.hypothesis.space.names, other.x.tolist(), strict=True))
    hypothesis = model.hypothesis.and_also(other.hypothesis.placed[-1])
    more = [own[name] for name in hypothesis.space.names[len(model.x) :]]
    return tried_closely(setup, hypothesis, np.array([*model.x, *more]), near=True, steps=A_FEW)


def sure_beside(comparison: Comparison[FittedFrfs]) -> float:
    """The probability above.

    Args:
        comparison: of the others alone, the model, and what is in its stead.
    """
    models = comparison.models
    costs, sizes, priors = figures_of(models)
    found = probabilities(costs, sizes, priors, 1, PIECES * len(models[0].costs), math.inf, ALONE)
    return float(min(found[1], comparison.probability[1]))
