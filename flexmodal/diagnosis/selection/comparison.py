"""Which of several fitted models do the data prefer, and how surely.

A score is the logarithm of a model's evidence. It is looked at under several settings — draws of a bootstrap,
or sets of beliefs — and no choice may hang on one of them: a probability is the mean over settings, a gain is
what a model gains in all of them but a few.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import UNSTRUCTURED

TIE = 0.05
"""Probability from which a model counts as tied with the best. Nothing but what is told hangs on it."""
TIED = 4.0
"""Evidence by which models differ that are not tied, with `MARGIN` on both sides, where settings are sets of
beliefs [nat]: within 5 is a tie."""
MARGIN = 1.0
"""On both sides of what evidence has to reach: inside, nothing is decided, and no rounding decides it [nat].

Laplace's integral itself is some tenths of a nat off (tests/diagnosis/modes/test_fit.py)."""


@runtime_checkable
class FittedModel(Protocol):
    """A hypothesis with its parameters at their best."""

    @property
    def key(self) -> tuple[str, str]:
        """What it adds last, and where."""
        ...

    @property
    def hypothesis(self) -> Hypothesis:
        """What was fitted."""
        ...

    @property
    def x(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates of the hypothesis."""
        ...

    @property
    def parameters(self) -> int:
        """How many it has, those of modes with no structure among them."""
        ...


M = TypeVar("M", bound=FittedModel)


@dataclass(frozen=True, eq=False)
class Comparison(Generic[M]):
    """Scores of several models, the first of them the one without anything new."""

    models: Sequence[M]
    scores: Float[np.ndarray, " model"]
    """ln evidence, as believed and with all data [nat]."""
    table: Float[np.ndarray, "model setting"]
    """The same under each setting."""
    level: float = 0.0
    """Part of the settings that a gain may miss."""
    beliefs: bool = False
    """Whether settings are sets of beliefs, none of them better than another; else draws of a bootstrap."""

    @cached_property
    def over_best(self) -> Float[np.ndarray, "model setting"]:
        """The table, over the best of each setting."""
        return self.table - self.table.max(axis=0)

    @cached_property
    def probability(self) -> Float[np.ndarray, " model"]:
        """Of each model: mean over the settings."""
        weight = np.exp(self.over_best)
        return (weight / weight.sum(axis=0)).mean(axis=1)

    @cached_property
    def order(self) -> list[int]:
        """Numbers of the models, the most probable first."""
        return [int(k) for k in np.lexsort((-self.scores, -self.probability.round(6)))]

    def gain(self, number: int) -> float:
        """What a model gains over the first, in all settings but the part `level` [nat]."""
        return float(np.quantile(self.table[number] - self.table[0], self.level))

    def first_gain(self, number: int) -> float:
        """The same as believed and with all data."""
        return float(self.scores[number] - self.scores[0])

    @property
    def best_effect(self) -> int:
        """Number of the model with an effect whose score is best; a mode with no structure is none. Or 0."""
        able = [k for k, one in enumerate(self.models) if k and one.key[0] != UNSTRUCTURED]
        return max(able, key=lambda k: self.scores[k], default=0)

    @cached_property
    def tied(self) -> list[int]:
        """Models that these data cannot tell from the best, itself among them, the most probable first.

        Under any set of beliefs no more than `TIED` and its margin behind; of draws, by their probability.
        """
        if self.beliefs:
            close = np.any(self.over_best >= -(TIED + MARGIN), axis=1)
        else:
            close = (self.probability >= TIE) | (np.arange(len(self.models)) == self.order[0])
        return [k for k in self.order if close[k]]
