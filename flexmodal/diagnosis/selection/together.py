"""Effects at several places at once, where free functions explain together what is missing.

While places are looked for all functions are free, so that none has to make up for another one. Effects that
are added one after the other do, with their laws: the first takes up what it can of those that are missing,
and the second is looked for beside that. So an effect is put at each of the places, set out from what its
function was, and all are fitted together; then wider laws come, and other effects that may be at a place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.gaps import left, over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.diagnosis.lawfree.result import Findings, Found, told_at
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.beside import both_beside
from flexmodal.diagnosis.search.close_fit import tried_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.explanations import from_each_start
from flexmodal.diagnosis.search.next_level import at_next_level
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_starts import with_last
from flexmodal.diagnosis.setup import Setup

FLOOR = 0.2
"""Model error at which starts are compared."""
SWEEPS = 2
"""Turns in which each place gets the best of its starts beside the others."""
ROUNDS = ((0.2, 8), (0.1, 8), (0.03, 8))
"""Model errors and steps of the coarse fits."""
NEARER = 0.1
"""Part of what is left above the noise that a wider law or another effect has to take."""
FOLLOWED = 2
"""Starts of another effect that are fitted closely."""

Key = tuple[str, str]
"""Name and place of an effect."""
Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Option:
    """An effect that may be at one of the places, and where its fits set out."""

    placed: Placed
    starts: Sequence[Values]


@dataclass(frozen=True, eq=False)
class Together:
    """Effects at all places of one look."""

    setup: Setup
    """What the diagnosis works with."""
    root: FittedFrfs
    """The robot re-tuned."""
    look: Findings
    """For several places."""
    is_enough: Callable[[FittedFrfs], bool]
    """Whether a model leaves nothing."""
    without: Callable[[FittedFrfs, Key], FittedFrfs]
    """A model with one effect less, fitted again."""

    def found(self) -> tuple[FittedFrfs, Mapping[Key, Sequence[FittedFrfs]]] | None:
        """The best model; for each effect this with the effect as its last, and with others in its place.

        None where a place has no effect of the catalogue, or there is no fit.
        """
        options = [self._options(one) for one in self.look.found]
        if len(options) < 2 or not all(options):
            return None
        model = self._fitted(options)
        if model is None:
            return None
        model, others = self._widened(model), dict[Key, list[FittedFrfs]]()
        for place, some in zip(self.look.found, options, strict=True):
            key = next(one.placed.key for one in some if one.placed.key in model.hypothesis.keys)
            others[key] = self._others(model, key, some, place)
            best = min(others[key], key=lambda one: one.cost, default=model)
            if left(self.setup, model, best) < 1 - NEARER:
                others[best.key] = [with_last(model, key)]
                others.pop(key)
                model = self._widened(best)
        ends = {key: with_last(model, key) for key in model.hypothesis.keys}
        return model, {key: [end, *others.get(key, [])] for key, end in ends.items()}

    def _options(self, found: Found) -> list[Option]:
        """Effects that may be at a place: what its function tells first, else those that act just there."""
        context, able = self.setup.context, list[Option]()
        for effect in self.setup.effects:
            for where in () if effect.untestable(context) else effect.places(context):
                if found.could_be(effect.name, where):
                    starts = [*told_at(found, effect, where, context), *effect.starts(context, where)]
                    able.append(Option(Placed(effect, where), starts))
        there = {(name, found.where) for name, port in PORT_OF.items() if port == found.port}
        there |= {(found.tells or "", found.where)}
        just = [one for one in able if one.placed.key in there]
        return sorted(just or able, key=lambda one: one.placed.key != (found.tells, found.where))

    def _set_out(
        self, place: Found, x: Float[np.ndarray, " before"], *before: Float[np.ndarray, " before"]
    ) -> SetOut:
        """From what the function of a place tells, all else as it is; elsewhere by an effect's own starts."""
        context = self.setup.context
        return SetOut(before, lambda effect, at: [(one, x) for one in told_at(place, effect, at, context)])

    def _fitted(self, options: Sequence[Sequence[Option]]) -> FittedFrfs | None:
        """From the starts that together are best."""
        plain, integrated = both_beside(self.setup, self.root)

        def begun(chosen: Sequence[tuple[Option, Values]]) -> Candidate | None:
            if len({one.placed.key for one, _ in chosen}) < len(chosen):
                return None
            hypothesis, x = self._beginning(chosen)
            seen = integrated if hypothesis.by_force else plain
            return next(iter(seen.started(hypothesis, [x], FLOOR, 1)), None)

        every = [[(one, start) for one in some for start in one.starts] for some in options]
        chosen = [some[0] for some in every]
        best = begun(chosen)
        for sweep, number in product(range(SWEEPS), range(len(every))):
            self.setup.advance("placing effects together", (sweep + number / len(every)) / SWEEPS)
            for one in every[number]:
                tried = begun(turned := [*chosen[:number], one, *chosen[number + 1 :]])
                if tried is not None and (best is None or tried.cost < best.cost):
                    best, chosen = tried, turned
        if best is None:
            return None
        return self._closely(best, integrated if best.hypothesis.by_force else plain)

    def _beginning(
        self, chosen: Sequence[tuple[Option, Values]]
    ) -> tuple[Hypothesis, Float[np.ndarray, " parameter"]]:
        hypothesis, x = self.root.hypothesis, self.root.x
        x = x if self.look.fitted is None else self.look.fitted
        for one, start in chosen:
            hypothesis = hypothesis.and_also(one.placed)
            x = hypothesis.start(one.placed, start, x)
        return hypothesis, x

    def _closely(self, one: Candidate, seen: Look) -> FittedFrfs | None:
        for number, (floor, steps) in enumerate(ROUNDS):
            self.setup.advance("fitting effects together", number / len(ROUNDS))
            one = seen.fitted(one, floor, steps)
        return next(iter(tried_closely(self.setup, one.hypothesis, one.x)), None)

    def _widened(self, model: FittedFrfs) -> FittedFrfs:
        """With a wider law for each effect in turn that gains by one, as long as something is left."""
        for key in model.hypothesis.keys:
            if self.is_enough(model):
                break
            wide = self._at_next_level(with_last(model, key))
            if left(self.setup, model, wide) < 1 - NEARER:
                model = wide
        return model

    def _at_next_level(self, model: FittedFrfs) -> FittedFrfs:
        """The model with a wider law for its last effect, if there is one."""
        placed = model.hypothesis.placed[-1]
        own = len(placed.effect.parameters(self.setup.context, placed.where))
        place = next(one for one in self.look.found if one.could_be(*placed.key))
        set_out = self._set_out(place, model.x[: len(model.x) - own])
        found = at_next_level(self.setup, model, set_out, self.is_enough)
        return min(found, key=lambda one: over_noise(self.setup, one), default=model)

    def _others(
        self, model: FittedFrfs, key: Key, options: Sequence[Option], place: Found
    ) -> list[FittedFrfs]:
        """Other effects at one of the places, all else as it is."""
        keys = [one.placed.key for one in options if one.placed.key not in model.hypothesis.keys]
        if not keys:
            return []
        less = self.without(model, key)
        x = with_last(model, key).x[: len(less.x)]
        return from_each_start(self.setup, less, self._set_out(place, x, x), keys, self.is_enough, FOLLOWED)
