"""Looks without a law beside models with effects, each taken once."""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.lawfree.effects_at import PORT_OF, holds
from flexmodal.diagnosis.lawfree.first_look import LooksWithoutLaw
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup

MOST_LOOKS = 8
"""Looks beside effects that are there; each takes as long as the first, and where many do not help, more
do not."""

Law = tuple[object, str]
"""An effect at one of its levels, and its place."""


class LooksBeside:
    """Looks beside a model; those beside the re-tuned robot stand apart."""

    def __init__(
        self, setup: Setup, root: FittedFrfs, *, with_force: bool, known: Findings | None = None
    ) -> None:
        """Nothing is looked at yet.

        Args:
            setup: what the diagnosis works with.
            root: the robot re-tuned.
            with_force: whether FRFs change with the force of the blow, or may.
            known: the look beside the re-tuned robot, if that is known.
        """
        self.setup, self.root, self.with_force = setup, root, with_force
        self.looks = LooksWithoutLaw(setup, root, with_force, setup.advance, known=known)
        """Of the re-tuned robot."""
        self._beside: dict[frozenset[Law], Findings] = {}
        self._forced: dict[frozenset[Law], bool] = {}
        self._order: dict[frozenset[Law], tuple[str, ...]] = {}
        """Of the coordinates that each look was taken with."""

    def look_beside(self, model: FittedFrfs) -> Findings:
        """The law-free look for one place beside what a model has.

        Args:
            model: the root, or one with effects.
        """
        if model is self.root:
            return self.looks.one
        found = self.looked(model)
        if found is None:
            there = {(PORT_OF.get(name, ""), where) for name, where in model.hypothesis.keys}
            hinted = [one for one in self._best_alone if not any(holds(one, known) for known in there)]
            looks = LooksWithoutLaw(self.setup, model, self.with_force, self.setup.advance, hinted)
            found, key = looks.one, laws_of(model)
            self._beside[key], self._order[key] = found, model.hypothesis.space.names
            self._forced[key] = looks.depends_on_force
        return found

    @property
    def _best_alone(self) -> Sequence[tuple[str, str]]:
        """What does best beside the re-tuned robot: what is rare is tried at once beside others then too."""
        return [key for one in self.looks.one.found[:1] for key in one.alike]

    def can_look(self, model: FittedFrfs) -> bool:
        """Whether a look beside a model is known, or few enough were taken that another one may be.

        Args:
            model: the root, or one with effects.
        """
        known = model is self.root or laws_of(model) in self._beside
        return known or len(self._beside) < MOST_LOOKS

    @property
    def one_explained(self) -> bool:
        """Whether by the last look, beside whatever it was, one place more explains everything."""
        return next(reversed(self._beside.values()), self.looks.one).explains

    def one_explains(self, model: FittedFrfs) -> bool:
        """Whether one place more explains everything without a law.

        Args:
            model: with effects.
        """
        return self.can_look(model) and self.look_beside(model).explains

    def looked(self, before: FittedFrfs) -> Findings | None:
        """The look beside effects, with these laws, if there was one; for the order that they come in now.

        Args:
            before: the model that has them.
        """
        key = laws_of(before)
        found, order = self._beside.get(key), self._order.get(key)
        if found is None or order is None:
            return found
        return found.in_order(order, before.hypothesis.space.names)

    def depends_on_force(self, before: FittedFrfs) -> bool:
        """Whether what is missing beside a model changes with the force of the blow, as far as is known.

        Args:
            before: the root, or one with effects.
        """
        return self._forced.get(laws_of(before), self.with_force)


def laws_of(model: FittedFrfs) -> frozenset[Law]:
    """Its effects at their levels, with their places."""
    return frozenset((one.effect, one.where) for one in model.hypothesis.placed)
