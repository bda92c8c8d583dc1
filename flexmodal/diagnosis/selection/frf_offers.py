"""What looks without a law, and what was found before, offer to a model of FRFs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Sequence
from functools import partial

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.lawfree.adjacent import on_base
from flexmodal.diagnosis.lawfree.effects_at import DOES_MUCH, PORT_OF
from flexmodal.diagnosis.lawfree.look import SOUND
from flexmodal.diagnosis.lawfree.result import Findings as LawFree
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.search.explanations import best_of_each
from flexmodal.diagnosis.selection.confidence import explains
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import LIKELY, NOT_FAR_BEHIND, REMEMBERED
from flexmodal.diagnosis.selection.in_its_stead import Refits, also
from flexmodal.diagnosis.selection.set_up_anew import TRIED, is_set_up, nearest
from flexmodal.diagnosis.setup import Setup


class FrfsOffered(Data[FittedFrfs]):
    """FRFs, as far as something is offered to be added, or to take another one's place."""

    setup: Setup
    _candidates: FrfCandidates
    _refits: Refits
    _far: frozenset[tuple[tuple[str, str], tuple[str, str]]] = frozenset()
    """Effects and others that were far behind in their stead."""
    _in_vain: Sequence[FittedFrfs] = ()
    """Models beside which the test was seen set up no otherwise."""

    @abstractmethod
    def look_for(self, before: FittedFrfs) -> LawFree:
        """The look beside a model, where it was taken; else that of the re-tuned robot."""

    def doubted(self, model: FittedFrfs) -> tuple[str, str] | None:
        """See `Data`."""
        return self._candidates.doubted(model)

    def wider(self, model: FittedFrfs, keys: Collection[tuple[str, str]]) -> list[FittedFrfs]:
        """See `Data`."""
        return [] if self.is_close(model) else self._candidates.wider(model, keys)

    def is_at_rest(self, model: FittedFrfs) -> bool:
        """See `Data`: they count as explaining everything, and by a look beside them nothing is missing."""
        look, several = self._candidates.looked(model), len(model.hypothesis.keys) > 1
        return look is not None and several and look.alone <= SOUND and explains(self, model)

    def remembered(self, model: FittedFrfs, others: Sequence[FittedFrfs]) -> list[FittedFrfs]:
        """See `Data`; while by the first look and the last one no single place explains what is missing."""
        looked = self._candidates
        if self.asked is not None or self.is_over(model) or looked.looks.one.explains or looked.one_explained:
            return []
        new = [one for one in others if one.hypothesis.placed and one.key not in model.hypothesis.keys]
        new = [one for one in new if one.key[0] != UNSTRUCTURED]
        tried = sorted(new, key=lambda one: one.cost)[:REMEMBERED]
        fitted = parallel_map(partial(also, self.setup, model), tried)
        return [model, *(found for each in fitted for found in each)]

    def at_first(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """See `Data`; the few nearest, and some more where several effects are missing."""
        if self.asked is not None or is_set_up(self.setup, before) or not self._candidates.can_look(before):
            return []
        look = self._candidates.look_beside(before)
        found = self._candidates.by_narrow_laws(before, number, look) if look.needed else []
        return [before, *nearest(self.setup, found, TRIED if look.explains else REMEMBERED)] if found else []

    def lacks_several(self, model: FittedFrfs) -> bool:
        """See `Data`."""
        return not self.look_for(model).explains

    def instead(self, model: FittedFrfs, key: tuple[str, str], *, anyway: bool = False) -> list[FittedFrfs]:
        """See `Data`; what was far behind then stays there, and where nothing is left everything stays.

        Unless none of its effects is where it is missing without a law.
        """
        if not anyway and self.is_enough(model) and not self.is_contradicted(model):
            return []
        likely = self._candidates.considered(model, key, NOT_FAR_BEHIND)[:LIKELY]
        found = self._refits.instead(model, key, [one for one in likely if (key, one.key) not in self._far])
        far = NOT_FAR_BEHIND * over_noise(self.setup, model)
        self._far |= {(key, one.key) for one in found if over_noise(self.setup, one) > far}
        return best_of_each(found)

    def plainer(self, less: FittedFrfs, key: tuple[str, str]) -> list[FittedFrfs]:
        """See `Data`: in a foundation's stead what sits in the joints on it, whose turns it can do.

        And what an effect comes down to in a limit, as an absorber does to a mass.
        """
        if self.asked is not None:
            return []
        number = len(less.hypothesis.keys)
        if PORT_OF.get(key[0]) in DOES_MUCH:
            rigid = {one for one in on_base(self.setup.context) if one[0] in ("joint", "bearing")}
            return self._candidates.also_at(less, number, [], rigid)
        simpler = {name for effect in self.effects if effect.name == key[0] for name in effect.simpler}
        tried = {(name, key[1]) for name in simpler} - set(less.hypothesis.keys)
        return self._candidates.searched(less, number, lambda *one: one in tried) if tried else []

    def leads_on(self, model: FittedFrfs) -> bool:
        """See `Data`."""
        return self.is_enough(model) or self._candidates.one_explains(model)
