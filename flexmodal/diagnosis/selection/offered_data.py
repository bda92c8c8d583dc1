"""What a look without a law offers forward selection: what to add, and what in whose place."""

from __future__ import annotations

from abc import ABC
from collections.abc import Collection, Mapping, Sequence
from typing import Generic

from flexmodal.diagnosis.selection.comparison import M


class OfferedData(ABC, Generic[M]):
    """FRFs, modes, or both, as a search is led by them."""

    def pointed(self, before: M, number: int) -> list[M]:
        """A model, and what might be added to it where a look without a law points, if it does.

        Args:
            before: the model.
            number: how many effects it has.
        """
        return [before]

    def remembered(self, model: M, others: Sequence[M]) -> list[M]:
        """A model with one effect more of those that were compared before, where several are missing.

        They are fitted beside it, which takes a part of the time of a look.

        Args:
            model: with effects.
            others: what was compared last.
        """
        return []

    def together(self, known: M | None = None) -> tuple[M, Mapping[tuple[str, str], Sequence[M]]] | None:
        """Effects at several places at once, where one does not explain everything without a law.

        Args:
            known: with effects that are sure. Only what leaves nothing or is sure and has more is better.

        Returns:
            The best model; for each of its effects the same with it as the last, and what was tried in its
            place. None where there is no such model.
        """
        return None

    def besides(self, before: M, number: int) -> list[M]:
        """A model that leaves what counts as noise, and what may yet be in that; nothing where that is clear.

        Args:
            before: the model.
            number: how many effects it has.
        """
        return []

    def wider(self, model: M, keys: Collection[tuple[str, str]]) -> list[M]:
        """A model with a wider law for some of its effects that have one, in turn; the best first.

        Args:
            model: with effects.
            keys: names and places of the ones.
        """
        return []

    def at_first(self, before: M, number: int) -> list[M]:
        """A model, and what does best beside it before any is followed, to see anew how a test was set up.

        Nothing where everything is exact, or nothing else can be seen.

        Args:
            before: the model.
            number: how many effects it has.
        """
        return []

    def lacks_several(self, model: M) -> bool:
        """Whether by a look beside a model no single place explains what is missing."""
        return False

    def doubted(self, model: M) -> tuple[str, str] | None:
        """Of several effects one whose fit a look without a law speaks against, if there is one."""
        return None

    def falls_short(self, model: M) -> tuple[str, str] | None:
        """The only effect of a model, where a look without a law finds all that is left in its own place."""
        return None

    def instead(self, model: M, key: tuple[str, str], *, anyway: bool = False) -> list[M]:
        """With what was considered in place of one of several effects, beside those that came since.

        Args:
            model: with effects.
            key: name and place of the one.
            anyway: whether also where nothing is left.
        """
        return []

    def plainer(self, less: M, key: tuple[str, str]) -> list[M]:
        """A model without one of its effects, with what is plainer in its stead: what it comes down to, say.

        Args:
            less: the model without it.
            key: its name and place.
        """
        return []

    def is_at_rest(self, model: M) -> bool:
        """Whether several effects explain everything but for their laws."""
        return False

    def leads_on(self, model: M) -> bool:
        """Whether nothing is left beside several effects, or one more might explain it."""
        return False
