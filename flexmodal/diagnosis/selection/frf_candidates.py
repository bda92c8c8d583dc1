"""What might be added to a model of FRFs: where a look without a law points, or everywhere."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from flexmodal.diagnosis.lawfree.first_look import LooksWithoutLaw
from flexmodal.diagnosis.lawfree.result import CLASSES_OF, Findings
from flexmodal.diagnosis.search.explanations import best_of_each, explanations, from_each_start
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED
from flexmodal.diagnosis.setup import Setup


class FrfCandidates:
    """Looks and searches beside a model; those beside the re-tuned robot are done once."""

    def __init__(self, setup: Setup, root: FittedFrfs, *, with_force: bool) -> None:
        """Nothing is looked at yet.

        Args:
            setup: what the diagnosis works with.
            root: the robot re-tuned.
            with_force: whether FRFs change with the force of the blow, or may.
        """
        self.setup, self.root, self.with_force = setup, root, with_force
        self.looks = LooksWithoutLaw(setup, root, with_force, setup.advance)
        """Of the re-tuned robot."""

    def look_beside(self, model: FittedFrfs) -> Findings:
        """The law-free look for one place beside what a model has.

        Args:
            model: the root, or one with effects.
        """
        if model is self.root:
            return self.looks.one
        return LooksWithoutLaw(self.setup, model, self.with_force, self.setup.advance).one

    def at_places(
        self, before: FittedFrfs, number: int, look: Findings, is_over: Callable[[FittedFrfs], bool]
    ) -> list[FittedFrfs]:
        """The finalists of a search where a look points.

        Where one place explains everything, effects of the class that its curve has are followed from each
        of their starts too, unless one of the others is enough.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            look: beside it.
            is_over: whether nothing else has to be looked for beside a model.
        """
        found = self.searched(before, number, look.worth_trying)
        if look.explains and not any(is_over(one) for one in found):
            more = from_each_start(self.setup, before, starts(before), self._pointed_to(before, look))
            found = best_of_each([*found, *more])
        return found

    def everywhere(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """The finalists of a search for every effect in every place.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
        """
        return self._first if before is self.root else self.searched(before, number, _anything)

    @cached_property
    def _first(self) -> list[FittedFrfs]:
        return self.searched(self.root, 0, _anything)

    def searched(
        self, before: FittedFrfs, number: int, allowed: Callable[[str, str], bool]
    ) -> list[FittedFrfs]:
        """The finalists of a search for some effects in some places.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            allowed: names and places that are tried.
        """
        doing = f"looking for {'an effect' if not number else 'another effect'}"
        return explanations(
            self.setup,
            before,
            starts(before),
            with_force=self.with_force,
            enough=FLOOR_REACHED,
            advance=lambda part: self.setup.advance(doing, part),
            allowed=allowed,
        )

    def _pointed_to(self, before: FittedFrfs, look: Findings) -> list[tuple[str, str]]:
        """Further effects whose place and class a look has found; those that it has a class for."""
        return [
            (effect.name, where)
            for effect in self.setup.effects
            if effect.name in CLASSES_OF and not effect.untestable(self.setup.context)
            for where in effect.places(self.setup.context)
            if (effect.name, where) not in before.hypothesis.keys
            and any(one.where == where and one.could_be(effect.name, where) for one in look.found)
        ]


def _anything(effect: str, where: str) -> bool:
    """Every effect in every place."""
    return True


def starts(before: FittedFrfs) -> list[np.ndarray]:
    """Where a search sets out: at the card, with the effects there are, and where the last fit ended.

    A fit without an effect that is there runs away from the truth.

    Args:
        before: the model that something is added to.
    """
    count = len(before.hypothesis.base)
    at_card = np.concatenate([np.zeros(count), before.x[count:]])
    return [at_card, before.x] if before.hypothesis.placed else [at_card]
