"""Searches for effects beside a model of FRFs: where a look without a law points, or everywhere."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import cached_property

from flexmodal.diagnosis.lawfree.adjacent import adjacent
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.explanations import best_of_each, explanations
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_starts import starts
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED
from flexmodal.diagnosis.selection.looks_beside import LooksBeside


class SearchesBeside(LooksBeside):
    """One search after the other; that for every effect beside the re-tuned robot is done once."""

    def pointed_at(
        self, before: FittedFrfs, number: int, look: Findings, *, one_is_enough: bool
    ) -> list[FittedFrfs]:
        """Effects that are worth it, among them those at the one place that was found.

        There others may leave one behind by its narrow law that takes most by a wide one, as a rod does.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            look: beside it.
            one_is_enough: whether one effect explains everything, as far as the look can say.
        """
        found = self.searched(before, number, self._worth_trying(look), one_is_enough=one_is_enough)

        def here(effect: str, where: str) -> bool:
            return where == look.found[0].where and look.found[0].has(effect, where)

        if len(look.found) != 1 or any(here(*one.key) for one in found):
            return found
        return best_of_each([*found, *self.searched(before, number, here)])

    def _worth_trying(self, look: Findings) -> Callable[[str, str], bool]:
        """Whether an effect is to be fitted at a place; what touches the ground, if anything beside it is.

        While several are missing: a foundation with all its functions free may do worse than nothing on the
        postures held out where a bearing of fewer does better, and its law no worse than that one's.
        """
        if look.explains:
            return look.worth_trying

        def allowed(effect: str, where: str) -> bool:
            port = PORT_OF.get(effect)
            beside = adjacent(self.setup.context, port, where) if port == "base" else ()
            return look.worth_trying(effect, where) or any(look.is_near(*one) for one in beside)

        return allowed

    def also_at(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], ports: Collection[tuple[str, str]]
    ) -> list[FittedFrfs]:
        """With those effects at some ports that were not found yet.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            found: with one effect more.
            ports: kinds and places; none adds nothing.
        """
        known = {one.key for one in found}

        def allowed(effect: str, where: str) -> bool:
            return (effect, where) not in known and (PORT_OF.get(effect), where) in ports

        return best_of_each([*found, *self.searched(before, number, allowed)]) if ports else found

    def everywhere(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """The finalists of a search for every effect in every place.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
        """
        return self._first if before is self.root else self.searched(before, number)

    @cached_property
    def _first(self) -> list[FittedFrfs]:
        return self.searched(self.root, 0)

    def searched(
        self,
        before: FittedFrfs,
        number: int,
        allowed: Callable[[str, str], bool] = lambda effect, where: True,
        *,
        one_is_enough: bool = False,
        by_force: bool = False,
    ) -> list[FittedFrfs]:
        """The finalists of a search for some effects in some places.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            allowed: names and places that are tried; all by default.
            one_is_enough: whether one effect explains everything, as far as a look without a law can say.
            by_force: whether those that depend on the force of the blow are tried where FRFs do not, too.
        """
        doing = f"looking for {'an effect' if not number else 'another effect'}"
        return explanations(
            self.setup,
            before,
            starts(before, self.looks.one if before is self.root else self.looked(before)),
            with_force=by_force or self.depends_on_force(before),
            enough=FLOOR_REACHED,
            advance=lambda part: self.setup.advance(doing, part),
            allowed=allowed,
            one_is_enough=one_is_enough,
        )
