"""What forward selection asks of measured data of any kind: fits, their evidence, and what they leave."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Generic

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.effects import Context, Effect
from flexmodal.diagnosis.lawfree.result import Findings as LawFree
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.decision import Answer, Asked
from flexmodal.diagnosis.selection.offered_data import OfferedData
from flexmodal.diagnosis.selection.told_data import ToldData


class Data(OfferedData[M], ToldData[M], ABC, Generic[M]):
    """FRFs, modes, or both, as forward selection sees them."""

    campaign: Campaign
    context: Context
    effects: tuple[Effect, ...]
    asked: Asked | None
    """Effects that the caller named; None for the whole catalogue."""
    advance: Callable[[str, float], None]

    @property
    @abstractmethod
    def root(self) -> M:
        """The robot re-tuned, nothing added."""

    @property
    @abstractmethod
    def untestable(self) -> Mapping[str, str]:
        """Effects that these data cannot tell of, and why."""

    @property
    @abstractmethod
    def held_out(self) -> tuple[int, ...]:
        """Ids of the postures that no fit sees."""

    @abstractmethod
    def candidates(self, before: M, number: int) -> list[M]:
        """A model, and what might be added to it.

        Args:
            before: the model.
            number: how many effects were looked for before.
        """

    def set_up_anew(self, models: Sequence[M]) -> tuple[Data[M], list[M]] | None:
        """The data as they were most likely set up by the best of some models, and these fitted to them.

        Args:
            models: the first without anything new.

        Returns:
            None where everything is exact, or nothing does better so.
        """
        return None

    @abstractmethod
    def compare(self, models: Sequence[M]) -> Comparison[M]:
        """Their evidence, the first being the one without anything new."""

    def confidences(self, comparison: Comparison[M], chosen: int) -> Float[np.ndarray, " model"]:
        """Probability of each model of a comparison, beside something that was not compared.

        Args:
            comparison: of several models.
            chosen: number of the one that is named.
        """
        return comparison.probability

    @abstractmethod
    def without(self, model: M, key: tuple[str, str]) -> M:
        """A model fitted again with one effect less.

        Args:
            model: with the effect.
            key: name and place of the effect.
        """

    @abstractmethod
    def worth(self, before: M, after: M, number: int) -> Answer:
        """Whether an effect takes enough of the misfit away, apart from its evidence.

        Args:
            before: the model without.
            after: the model with it.
            number: how many were added before.
        """

    @abstractmethod
    def is_enough(self, model: M) -> bool:
        """Whether nothing is left to be explained."""

    def is_close(self, model: M) -> bool:
        """Whether clearly nothing is left to be explained."""
        return self.is_enough(model)

    def is_slow(self, model: M) -> bool:
        """Whether what is looked for beside a model takes much longer than beside others."""
        return False

    def is_over(self, model: M) -> bool:
        """Whether no further effect is looked for."""
        return self.is_enough(model) or self.is_named(model)

    def is_named(self, model: M) -> bool:
        """Whether a model's effect is sure although its law leaves more than noise."""
        return False

    def dominates(self, model: M) -> bool:
        """Whether its one effect is sure though far more than noise is left."""
        return False

    def is_contradicted(self, model: M) -> bool:
        """Whether several effects stand for what one place explains at which none of them sits."""
        return False

    def share(self, first: M, last: M) -> float | None:
        """Part of the disagreement above the noise that a model takes; None where that has no figure.

        Args:
            first: the robot re-tuned.
            last: the model.
        """
        return None

    @property
    def look(self) -> LawFree | None:
        """What is found without a law; None where there are no FRFs."""
        return None

    @property
    def most(self) -> int:
        """Effects added at most: more of them explain anything."""
        return 2

    def vouches(self, model: M) -> bool:
        """Whether all effects of a model are known to be needed whatever each of them gains alone."""
        return False

    def plausible(self, comparison: Comparison[M]) -> Mapping[int, float]:
        """Of models whose effects explain everything, by number, how plausible, up to a constant [nat]."""
        return {}

    def settles(self, model: M) -> Mapping[tuple[str, str], float]:
        """Which of several effects are sure though they leave more than noise, and how sure."""
        return {}

    def by_function(
        self, model: M, tried: Sequence[M], hardly: Collection[tuple[str, str]] = ()
    ) -> tuple[M, Mapping[tuple[str, str], float]] | None:
        """A model with the effects that free functions tell, and how sure each is; None where none is told.

        Args:
            model: with what was found by laws.
            tried: every model that was compared.
            hardly: names and places of its effects that are hardly possible, and have no name by their laws.
        """
        return None

    @property
    def told(self) -> tuple[tuple[str, str], ...]:
        """Names and places of its effects, once it was asked for."""
        return ()

    def surely(self, model: M, key: tuple[str, str]) -> float | None:
        """How sure one of several effects is, beside what was considered in its place; None where unknown.

        Args:
            model: with effects.
            key: name and place of the one.
        """
        return None

    def standing(self, model: M) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
        """Effects of the final model that are sure though it leaves more than noise; where it lacks any."""
        return (), ()

    @abstractmethod
    def lacking(self, model: M) -> Mapping[int, float]:
        """Measured modes that a model has none for in half the postures and more: number, frequency [Hz]."""

    @abstractmethod
    def gaps(self, before: M, after: M) -> Gaps:
        """Of a pair of models.

        Args:
            before: without the effect.
            after: with it.
        """

    @abstractmethod
    def compared_gaps(self, model: M) -> tuple[float, float | None]:
        """A model's gap on what it was fitted to, and on what was held out."""

    @abstractmethod
    def covariance(self, model: M) -> Float[np.ndarray, "parameter parameter"]:
        """Of the coordinates of its hypothesis."""

    def alike(self, one: M, other: M) -> bool:
        """Whether they explain as much of what can be counted.

        Args:
            one: a fitted model.
            other: another.
        """
        return True
