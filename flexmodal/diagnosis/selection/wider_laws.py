"""Wider laws for effects of models of FRFs, where narrow ones leave more than there should be."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial

from flexmodal.diagnosis.disagreement.gaps import left, over_noise
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF, WIDE
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.every_law import every_law, followed, worth_following
from flexmodal.diagnosis.search.explanations import best_of_each
from flexmodal.diagnosis.search.next_level import at_next_level
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_starts import (
    starts,
    swung,
    with_last,
)
from flexmodal.diagnosis.selection.frf_thresholds import (
    ANOTHER,
    CLOSE,
    EXPLAINED,
    FLOOR_REACHED,
    HALF,
    HARDLY,
    LAW_LEAVES,
    NOTHING_HIDDEN,
)
from flexmodal.diagnosis.selection.searches_beside import SearchesBeside


class WiderLaws(SearchesBeside):
    """Which effects get the next level of their law, and when."""

    def with_wider_laws(
        self, before: FittedFrfs, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """With wider laws wherever they do far better than narrow ones, where none takes a good part.

        Beside the re-tuned robot where none explains what is missing; where no single place would, only if
        none takes a good part, as beside effects. There a narrow law may take nothing where a wide one takes
        most, of a foundation on bolts or of a rod.

        Args:
            before: the model that something is added to.
            found: with one effect more.
            look: beside it.
        """
        several = before.hypothesis.placed
        lacks_several = several or not look.explains
        if lacks_several and any(left(self.setup, before, one) < 1 - ANOTHER for one in found):
            return found
        if not several and any(over_noise(self.setup, one) <= EXPLAINED for one in found):
            return found
        set_out = starts(before, look)
        x = before.x if several else set_out.before[0]
        given = SetOut([x], set_out.told)
        tried = every_law(self.setup, before, x, with_force=self.depends_on_force(before))
        anywhere = look.explains or not several
        wide = followed(self.setup, worth_following(tried), given, self.is_enough, anywhere=anywhere)
        return best_of_each([*found, *wide])

    def at_next_levels(self, before: FittedFrfs, found: list[FittedFrfs], look: Findings) -> list[FittedFrfs]:
        """Wider laws too, where every effect in the place that explains everything leaves more by its law.

        More than noise, and more than the functions of that place leave when they are free, or most of what
        is missing: where that is little, it is less than several times the noise to begin with. No narrow law
        is enough where the place is one that only wide ones have, or its curve is of another effect's class.

        Args:
            before: the model that something is added to.
            found: with one effect more.
            look: beside it.
        """
        if not look.explains:
            return found
        enough = [one for one in found if self.is_enough(one) and left(self.setup, before, one) <= HALF]
        if any(look.met([one.key]) or not self._may_be_another(one, look) for one in enough):
            return self._as_good(found, look)
        others = swung(self.setup, before, look)
        places = [one for one in found if look.met([one.key]) or one.key in others]
        does = [one for one in places if left(self.setup, before, one) <= HALF]
        least = LAW_LEAVES * look.left
        if look.found[0].port not in WIDE and any(over_noise(self.setup, one) <= least for one in does):
            return found
        return best_of_each([*found, *self._at_next_level(places, starts(before, look))])

    def _as_good(self, found: list[FittedFrfs], look: Findings) -> list[FittedFrfs]:
        """With wider laws at places that do as well as the best without a law, if they leave nothing."""
        alike = look.found[0].alike
        narrow = [
            one for one in found if (PORT_OF.get(one.key[0]), one.key[1]) in alike and not self.is_enough(one)
        ]
        wider = [one for one in self._at_next_level(narrow, SetOut([])) if self.is_enough(one)]
        return best_of_each([*found, *wider])

    def _may_be_another(self, model: FittedFrfs, look: Findings) -> bool:
        """Whether a law leaves something, where the curve that explains all is of a class that is known."""
        return bool(look.found[0].classes) and over_noise(self.setup, model) > NOTHING_HIDDEN

    def at_last(self, before: FittedFrfs, found: list[FittedFrfs]) -> list[FittedFrfs]:
        """The wider law of an effect that takes all but a little, wherever it is, if that leaves nothing.

        Args:
            before: the model that something is added to.
            found: with one effect more.
        """
        nearly = [one for one in found if left(self.setup, before, one) <= HARDLY]
        if before.hypothesis.placed or not nearly or any(self.is_enough(one) for one in found):
            return found
        best = min(nearly, key=lambda one: over_noise(self.setup, one))
        wider = self._at_next_level([best], SetOut([]))
        return best_of_each([*found, *(one for one in wider if self.is_enough(one))])

    def wider(self, model: FittedFrfs, keys: Collection[tuple[str, str]]) -> list[FittedFrfs]:
        """The model with the next level of some of its effects, in turn, fitted closely; the best first.

        Levels go on until one clearly leaves nothing: another effect may stand for what is left.

        Args:
            model: with effects.
            keys: names and places of the ones.
        """
        able = [one.key for one in model.hypothesis.placed if one.effect.next_level is not None]
        turned = [with_last(model, key) for key in able if key in keys]
        given = partial(at_next_level, set_out=SetOut([]), is_enough=self._is_clear)
        return best_of_each([more for one in turned for more in given(self.setup, one)])

    def _at_next_level(self, models: Sequence[FittedFrfs], set_out: SetOut) -> list[FittedFrfs]:
        """Models with the next level of their last effects."""
        given = partial(at_next_level, set_out=set_out, is_enough=self.is_enough)
        return [more for one in models for more in given(self.setup, one)]

    def _is_clear(self, model: FittedFrfs) -> bool:
        return over_noise(self.setup, model) <= CLOSE

    def is_enough(self, model: FittedFrfs) -> bool:
        """Whether it leaves nothing; what its effects come close to for little has to leave less."""
        close = any(one.effect.comes_close for one in model.hypothesis.placed[-1:])
        return over_noise(self.setup, model) <= (CLOSE if close else FLOOR_REACHED)
