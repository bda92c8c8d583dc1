"""What forward selection has come to: the present model, its steps, and the comparisons that led there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Generic

from flexmodal.diagnosis.outcome import Compared, Step
from flexmodal.diagnosis.selection import described
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import (
    Answer,
    Choice,
    Round,
    among_vouched,
    any_gains,
    choice,
    rivals,
)
from flexmodal.diagnosis.selection.in_turn import linear_first
from flexmodal.diagnosis.time_limit import TimeLimit, cut_short


class Steps(Generic[M]):
    """Effects that were added, and what was compared on the way."""

    def __init__(self, data: Data[M], limit: TimeLimit | None = None) -> None:
        """Begin with the robot re-tuned, nothing added.

        Args:
            data: that fit and compare.
            limit: of the time that effects are looked for; by default there is none.
        """
        self.data, self.limit = data, limit or TimeLimit()
        self.root = self.current = data.root
        self.rounds: list[Round[M]] = []
        self.steps: list[Step] = []
        self.refused: list[Compared] = []
        """What was compared last and not added."""
        self.rivals: tuple[M, M] | None = None
        """What was added last, or is best, and what it is tied with."""
        self.furthest: M | None = None
        """What was come to by following the data, where none of it is sure enough to be named."""
        self.sure: Mapping[tuple[str, str], float] = {}
        """Effects that are sure beside the others whatever else is missing, and how sure."""
        self.pair: M | None = None
        """The best pair of effects, added or not."""

    @property
    def _state(self) -> tuple[Any, ...]:
        told = list(self.steps), self.refused, self.rivals, list(self.rounds)
        return self.data, self.root, self.current, *told

    @_state.setter
    def _state(self, state: tuple[Any, ...]) -> None:
        self.data, self.root, self.current, self.steps, self.refused, self.rivals, self.rounds = state

    def _set_up_anew(self, models: Sequence[M]) -> Sequence[M]:
        """Models as they are once it is seen beside them how the test was set up; the first is the present.

        What was compared before was compared as the test was set up by then. If time is up meanwhile, that is
        how it stays: what was fitted to it is not lost.
        """
        found = None
        with cut_short(len(models) > 1):
            found = self.data.set_up_anew(models) if models else None
        if found is None:
            return models
        self.data, fitted = found
        self.root, self.current = self.data.root, fitted[0]
        if self.steps:
            self.steps[:] = described.anew(self.data, self.root, self.current, self.describe)
        return fitted

    def _taken(self, models: Sequence[M], number: int) -> Step | None:
        return self._taken_of(self._set_up_anew(models), number)

    def _taken_of(self, models: Sequence[M], number: int) -> Step | None:
        """One effect more of models that were fitted to the test as it is thought to be set up now."""
        comparison = self.data.compare(models)
        found = self._chosen(comparison, number)
        self.rounds.append(Round(comparison, found))
        if number and comparison.best_effect:
            self.pair = comparison.models[comparison.best_effect]
        if found.number is not None or (not self.steps and any_gains(comparison) > Answer.NO):
            self.rivals = rivals(comparison, found.number, self.data.alike)
        if found.number is None:
            self.refused = [self._compared(comparison, k) for k in comparison.order]
            return None
        self.current = comparison.models[found.number]
        known = among_vouched(comparison, found.number, self.data.vouches, self.data.compare)
        self.steps.append(self.describe(*known))
        return self.steps[-1]

    def _describe_anew(self) -> None:
        """The steps to a model whose effects were not added one after the other; how sure they are."""
        if {(step.effect, step.where) for step in self.steps} != set(self.current.hypothesis.keys):
            self.steps[:] = described.anew(self.data, self.root, self.current, self.describe)
        self.steps[:] = described.as_sure(self.steps, self.sure)

    def _describe_wider(self) -> None:
        """The only step, whose law is a wider one now, among what it was compared with when it was added.

        How sure the narrow one was says nothing of it. Of several each is judged beside the others anyway.
        """
        for told in reversed(self.rounds if len(self.steps) == 1 else []):
            models, keys = told.comparison.models, self.current.hypothesis.keys
            same = [k for k, one in enumerate(models) if one.hypothesis.keys == keys]
            if same:
                every = [self.current if k == same[0] else one for k, one in enumerate(models)]
                self.steps[0] = self.describe(self.data.compare(every), same[0])
                return

    def _chosen(self, comparison: Comparison[M], number: int) -> Choice:
        before = comparison.models[0]
        worth = [self.data.worth(before, one, number) for one in comparison.models]
        vouched = [k > 0 and self.data.vouches(one) for k, one in enumerate(comparison.models)]
        plausible = self.data.plausible(comparison)
        found = choice(comparison, self.data.asked, worth, vouched, plausible)
        if found.number is None or self.data.asked is not None or any(vouched):
            return found
        first = linear_first(comparison, found.number, worth, plausible, self.data.is_slow)
        return replace(found, number=first)

    def _placed(self, others: Mapping[tuple[str, str], Sequence[M]]) -> None:
        """The steps to a model whose effects came together, each compared with what may be in its place."""
        model, self.sure, self.refused, self.rivals = self.current, {}, [], None
        self.steps.clear()
        self.rounds.append(Round(self.data.compare([self.root, model]), Choice(1)))
        for key, models in others.items():
            comparison = self.data.compare([self.data.without(model, key), *models])
            self.rounds.append(Round(comparison, Choice(1)))
            self.steps.append(self.describe(comparison, 1))
        self.steps[:] = described.shared_anew(self.data, self.root, model, self.steps)

    def describe(self, comparison: Comparison[M], chosen: int) -> Step:
        """What a step added, how large it is and how surely, and what it was compared with.

        Args:
            comparison: of what was there before, first, and of what might be added.
            chosen: number of what was added.
        """
        return described.step_of(self.data, self.root, comparison, chosen)

    def _compared(self, comparison: Comparison[M], number: int) -> Compared:
        return described.in_figures(self.data, comparison, number)
