"""Forward selection: effects added one after the other, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from flexmodal.diagnosis.outcome import Step
from flexmodal.diagnosis.selection import described
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.decision import (
    Answer,
    hardly_possible,
    is_idle,
)
from flexmodal.diagnosis.selection.exchange import (
    exchanged,
    looked_for_again,
    of_the_tied,
    reconsidered,
    takes,
    widened,
    without,
)
from flexmodal.diagnosis.selection.steps import Steps
from flexmodal.diagnosis.time_limit import FOR_EFFECTS, OutOfTime

MOST = 5
"""Effects at once."""
MUCH = 0.33
"""Part of what is left above the noise that one effect more has to take, or an exchange is tried first."""


class ForwardSelection(Steps[M]):
    """One run; keeps what it has found so far. The data, of whatever kind, fit and compare."""

    def run(self) -> None:
        """Add effects until nothing is left; those that nobody misses go, and what a function tells comes."""
        followed = self.follow()
        if not self.place(followed=followed) and not followed:
            with suppress(OutOfTime), self.limit.counting(FOR_EFFECTS):
                self.search()
        if not self.rounds:  # there was no time for any
            self._taken([self.root], 0)
        if not (self.limit.was_hit and self.data.standing(self.current)[1]):  # who is unsure has no name
            self.drop_needless()
            with suppress(OutOfTime), self.limit.counting(at_least=1 - FOR_EFFECTS):
                self.drop_hardly_possible()
        tried = [one for each in self.rounds for one in each.comparison.models]
        with suppress(OutOfTime), self.limit.counting(at_least=1 - FOR_EFFECTS):
            doubted = [step for step in self.steps if hardly_possible(step.confidence) is Answer.YES]
            hardly = [(step.effect, step.where) for step in doubted]
            if (told := self.data.by_function(self.current, tried, hardly)) is not None:
                steps = described.anew(self.data, self.root, told[0], self.describe)
                self.furthest = self.current if self.steps else self.furthest
                self.current, self.steps[:] = told[0], described.as_sure(steps, told[1])

    def place(self, *, followed: bool) -> bool:
        """Put effects at several places at once, where a look without a law finds these together.

        Args:
            followed: whether there are effects already. Those that leave nothing stay.

        Returns:
            Whether there were any such places.
        """
        if followed and self.data.is_enough(self.current):
            return False
        found = None
        with suppress(OutOfTime), self.limit.counting(FOR_EFFECTS):
            found = self.data.together(self.current if followed else None)
        if found is None:
            return False
        self.current, others = found
        self._placed(others)
        with suppress(OutOfTime), self.limit.counting(FOR_EFFECTS):
            self._set_up_anew([self.current])
            self._besides()
        return True

    def follow(self) -> bool:
        """Add effects where a look without a law points, each time beside those that are there.

        Each has to take no more than the first effect must: several may hide one another. They stay if
        together they leave nothing, or so many of the first as are named without the others, or if some of
        them are sure whatever is missing besides.

        Returns:
            Whether any stayed.
        """
        kept = self._state
        ended, named = self._pursued()
        if not ended and named is None:
            with self.limit.counting(at_least=1 - FOR_EFFECTS):
                self.sure = self.data.settles(self.current)
        if not ended and not self.sure:
            self.furthest = None if named else self.current
            self._state = named or kept
        self._describe_anew()
        return bool(ended or named or self.sure)

    def _pursued(self) -> tuple[bool, tuple[Any, ...] | None]:
        """Whether effects leave nothing, and those named; in a part of the time once there are several."""
        named, ended, going = None, False, True
        with suppress(OutOfTime):
            while going and not ended:
                with self.limit.counting(FOR_EFFECTS if len(self.current.hypothesis.keys) > 1 else 1.0):
                    going = self._follow_on()
                ended = going and self.data.is_enough(self.current)
                if going and named is None:
                    sure = self.data.is_named(self.current) or self.data.dominates(self.current)
                    named = self._state if sure else None
            with self.limit.counting(FOR_EFFECTS):
                if ended:
                    self._besides()
        return ended, named

    def search(self) -> None:
        """Add effects wherever they do best, no more than can be judged without knowing where to look."""
        for number in range(self.data.most):
            if self.step(number) is None or self.data.is_over(self.current):
                break
        if self.pair is not None and not self.data.is_over(self.current):
            self.exchange(self.pair)
        self._besides()

    def step(self, number: int) -> Step | None:
        """One effect more, if one is needed."""
        return self._taken(self.data.candidates(self.current, number), number)

    def _follow_on(self) -> bool:
        """One effect more where the data point, or another one in place of one that is there."""
        doubted, short = self.data.doubted(self.current), self.data.falls_short(self.current)
        if doubted is not None and self._bettered(looked_for_again(self.data, self.current, doubted)):
            return True
        if any(self._widened([key]) for key in (doubted, short) if key is not None):
            return True
        if self.data.is_at_rest(self.current):
            return False
        many = len(self.current.hypothesis.keys)
        ready = self._set_up_at_first(many) if many < MOST else []
        before, present = self._state, self.current
        models = ready or (self.data.pointed(self.current, many) if many < MOST else [])
        taken = self._taken_of if ready else self._taken
        if len(models) < 2 or not (taken(models, 0) or self._tried_on()):
            wider = self._widened(self.current.hypothesis.keys)
            return wider or self._bettered(exchanged(self.data, self.current))
        while self._remembered():
            pass
        self.current = reconsidered(self.data, self.current)
        much = takes(self.data, present, self.current, MUCH)
        if many > 1 and not much and not self.data.leads_on(self.current):
            further, self._state, better = self._state, before, False
            try:
                better = self._widened(self.current.hypothesis.keys)
            finally:
                if not better:
                    self._state = further
        return True

    def _set_up_at_first(self, many: int) -> Sequence[M]:
        """See beside what does best how the test was set up; what may be added to the present as it is then.

        Nothing where more is looked for: where it was seen no otherwise, one place may explain everything, or
        none of them takes a good part.
        """
        models = self.data.at_first(self.current, many)
        several = bool(models) and self.data.lacks_several(self.current)
        found = self._set_up_anew(models)
        able = several and found is not models
        return found if able and any(takes(self.data, found[0], one, MUCH) for one in found[1:]) else []

    def _remembered(self) -> bool:
        """One effect more of those that were compared last, where it takes a good part beside the others."""
        if len(self.current.hypothesis.keys) >= MOST:
            return False
        models = self.data.remembered(self.current, self.rounds[-1].comparison.models)
        able = [one for one in models[1:] if takes(self.data, self.current, one, MUCH)]
        return bool(able) and self._taken([self.current, *able], 0) is not None

    def _besides(self) -> None:
        """Effects where what is left counts as noise and one place explains a good part of it."""
        while self.data.is_enough(self.current) and 0 < (number := len(self.current.hypothesis.keys)) < MOST:
            models = self.data.besides(self.current, number)
            if len(models) < 2 or self._taken(models, number) is None:
                return
            self.current = reconsidered(self.data, self.current)

    def _tried_on(self) -> bool:
        """One effect more of the last comparison that is not sure yet, where it takes a good part.

        Of which ones the data are sure is asked at the end.
        """
        best = (comparison := self.rounds[-1].comparison).best_effect
        gains = best and comparison.first_gain(best) > 0
        if not self.steps or not gains or not takes(self.data, self.current, comparison.models[best], MUCH):
            return False
        self.current, self.refused = comparison.models[best], []
        self.steps.append(self.describe(comparison, best))
        return True

    def _widened(self, keys: Collection[tuple[str, str]]) -> bool:
        """A wider law for one of some effects, if that does better."""
        better = self._bettered(widened(self.data, self.current, keys))
        if better:
            self._describe_wider()
        return better

    def _bettered(self, other: M) -> bool:
        """Whether a model is another one than the present, whose place it takes."""
        before, self.current = self.current, other
        if other is not before:
            self._set_up_anew([other])
        return other is not before

    def exchange(self, pair: M) -> None:
        """Look for the first effect again beside the second: alone, one takes up what it can of another."""
        kept, present = self._state, self.current
        self.current, self.refused = self.data.without(pair, pair.hypothesis.keys[0]), []
        self.steps[:] = [self.describe(self.data.compare([self.root, self.current]), 1)]
        nearer = False
        try:
            found = self.step(1) is not None
            same = set(self.current.hypothesis.keys) == set(present.hypothesis.keys)
            taking = same and takes(self.data, present, self.current, 0.0)
            nearer = found and (taking or self.data.is_enough(self.current))
        finally:
            if not nearer:
                self._state = kept

    def drop_needless(self) -> None:
        """Leave out every effect in turn; those that nobody misses go, as far as there is time to ask.

        The last one too: what it took away may have been due to a fit of those before it that had not ended.
        """
        every = list(self.steps)
        with suppress(OutOfTime), self.limit.counting(at_least=1 - FOR_EFFECTS):
            for number, step in enumerate(every):
                if len(self.steps) == 1 or self.sure:
                    break
                self._drop_or_keep(number, step)
        if len(self.steps) < len(every):
            self.steps[:] = described.shared_anew(self.data, self.root, self.current, self.steps)

    def _drop_or_keep(self, number: int, step: Step) -> None:
        """Leave out one of several effects, or say how sure it is beside the others."""
        less = without(self.data, self.current, (step.effect, step.where))
        comparison = self.data.compare([less, self.current])
        if is_idle(self.data.plausible(comparison)) or self._chosen(comparison, number).number is None:
            self.current = less
            self.steps.remove(step)
        else:
            self.steps[self.steps.index(step)] = self._beside_others(step, comparison)

    def _beside_others(self, step: Step, comparison: Comparison[M]) -> Step:
        """One of several effects, as sure as it is beside the others and what it was tied with alone.

        Where one of these is clearly more plausible beside the others it takes the effect's place.
        """
        sure = float(self.data.confidences(comparison, 1)[1])
        told = described.beside_others(step, sure, self.current.hypothesis.keys)
        other = again = None
        with suppress(OutOfTime):
            other = of_the_tied(self.data, comparison, told)
        if other is not None:
            self.current = other.models[1]
            return replace(self.describe(other, 1), gaps=step.gaps, share=step.share)
        with suppress(OutOfTime):
            again = self.data.surely(self.current, (step.effect, step.where)) if told.ties else None
        return (
            described.untied(step, min(sure, again))
            if again is not None and again > step.confidence
            else told
        )

    def drop_hardly_possible(self) -> None:
        """Leave out what is less plausible than nothing in its place, if others are sure or do without it.

        These with wider laws too: what a narrow one leaves may have been taken for one effect more.
        """
        kept = [step for step in self.steps if hardly_possible(step.confidence) < Answer.YES]
        if self.sure or len(kept) == len(self.steps):
            return
        less = self.current
        for step in self.steps:
            less = less if step in kept else self.data.without(less, (step.effect, step.where))
        self.sure = self.data.settles(less)
        if self.sure:
            self.furthest, self.current, self.steps[:] = self.current, less, kept
            self._describe_anew()
            return
        able = [less, *self.data.wider(less, less.hypothesis.keys)] if kept else []
        enough = next((one for one in able if self.data.is_enough(one)), None)
        if enough is not None:
            self.current, self.steps[:] = enough, []
            self._describe_anew()
