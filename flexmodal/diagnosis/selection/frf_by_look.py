"""What a look without a law says of the effects of a model: which are sure, which are doubted."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from functools import partial

from flexmodal.diagnosis.disagreement.gaps import left, over_noise
from flexmodal.diagnosis.lawfree.adjacent import on_base, within
from flexmodal.diagnosis.lawfree.effects_at import DOES_MUCH, PORT_OF
from flexmodal.diagnosis.lawfree.result import Findings as LawFree
from flexmodal.diagnosis.selection.by_function import fitted_with, told_of, wanted
from flexmodal.diagnosis.selection.confidence import explains
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_offers import FrfsOffered
from flexmodal.diagnosis.selection.frf_starts import with_last
from flexmodal.diagnosis.selection.frf_thresholds import (
    ALL_BUT_LITTLE,
    CLEARLY,
    EXPLAINED,
    HALF,
    IN_STEAD,
    LARGER_PART,
    MOST_OF_REST,
    NEARLY_ALL,
    NOT_FAR_BEHIND,
    NOTHING_LEFT,
    SURE,
    least_share,
)
from flexmodal.diagnosis.selection.in_its_stead import sure_beside
from flexmodal.diagnosis.selection.together import Together
from flexmodal.diagnosis.time_limit import OutOfTime


class FrfsByLook(FrfsOffered):
    """FRFs, as far as a look decides; what is fitted and compared is said by `FrfData`."""

    _look: LawFree
    _told: tuple[tuple[tuple[str, str], ...], tuple[str, ...]] = (), ()
    """Effects that are told by functions, and where something is left."""
    _settled: tuple[tuple[tuple[str, str], ...], tuple[tuple[str, str], ...], tuple[str, ...]] = (), (), ()

    @property
    def look(self) -> LawFree:
        """See `Data`; of the re-tuned robot, for several places once one turned out not to be enough."""
        return self._look

    def look_for(self, before: FittedFrfs) -> LawFree:
        """See `FrfsOffered`."""
        return self._candidates.looked(before) or self.look

    @property
    def most(self) -> int:
        """Two, or as many as there are places that explain everything without a law."""
        return max(2, len(self.look.found)) if self.look.explains else 2

    def falls_short(self, model: FittedFrfs) -> tuple[str, str] | None:
        """See `Data`; of one that takes the larger part alone, and whose place did not do so before."""
        keys = model.hypothesis.keys
        little = len(keys) == 1 and left(self.setup, self.root, model) <= HALF
        if (
            not little
            or self.is_enough(model)
            or self.is_alone(model)
            or not self._candidates.can_look(model)
        ):
            return None
        look = self._candidates.look_beside(model)
        return keys[0] if look.needed and look.explains and look.found[0].has(*keys[0]) else None

    def is_named(self, model: FittedFrfs) -> bool:
        """Whether its effects sit where the law-free look points, one each, and take the larger part.

        With their functions free those places explain everything, so that what the model leaves is due to the
        laws of the effects and not to another one.
        """
        keys = model.hypothesis.keys
        if not keys or not self.look.explains or self.lacking(model):
            return False
        met = self.look.met(keys)
        every = len(met) == max(len(keys), len(self.look.found))
        return every and self.share(self.root, model) >= least_share(met)

    def dominates(self, model: FittedFrfs) -> bool:
        """See `Data`: its place leaves far less than any other even if that is more than noise.

        So strong an effect shows how its law errs, or what else is there.
        """
        keys, look = model.hypothesis.keys, self._candidates.looks.one
        if len(keys) != 1 or not look.needed or look.explains or self.lacking(model):
            return False
        at = look.met(keys).get(keys[0])
        if at is None or at is not look.found[0] or not at.is_apart:
            return False
        here = look.places[0].judged
        others = [one.judged for one in look.places if (one.port, one.where) != (at.port, at.where)]
        clear = all(judged > CLEARLY * here for judged in others)
        return clear and self.share(self.root, model) >= ALL_BUT_LITTLE

    def is_alone(self, model: FittedFrfs) -> bool:
        """Whether its effect takes nearly all, where one place without a law leaves nothing for another one.

        Args:
            model: any.
        """
        look = self._candidates.looks.one
        named = len(model.hypothesis.keys) == 1 and self.is_named(model)
        return named and look.left <= NOTHING_LEFT and self.share(self.root, model) >= NEARLY_ALL

    def vouches(self, model: FittedFrfs) -> bool:
        """See `Data`: with several places that explain everything without a law, one effect at each."""
        keys, look = model.hypothesis.keys, self.look
        return look.explains and len(look.found) > 1 and len(look.met(keys)) == len(keys)

    def settles(self, model: FittedFrfs) -> Mapping[tuple[str, str], float]:
        """See `Data`: each takes most of what the others leave, and nothing in its stead does as well.

        Two at least, or one if all of them take all but little: what one alone takes any other may take, too.
        """
        keys, sure = model.hypothesis.keys, dict[tuple[str, str], float]()
        share = self.share(self.root, model)
        if len(keys) < 2 or self.lacking(model) or share < LARGER_PART:
            return {}
        with suppress(OutOfTime):  # those that were asked for are sure nevertheless
            self._refits.without_each(model, keys)
            for number, key in enumerate(keys):
                self.setup.advance("asking which effects are sure", number / len(keys))
                sure[key] = self.surely(model, key)
        named = {key: how for key, how in sure.items() if how >= SURE}
        if len(named) < 2 and share < ALL_BUT_LITTLE:
            return {}
        self._settled = keys, tuple(named), (self._left_at(model),)
        return named

    def surely(self, model: FittedFrfs, key: tuple[str, str]) -> float:
        """See `Data`."""
        less = self.without(model, key)
        if self.share(less, model) < MOST_OF_REST:
            return 0.0
        near = self._candidates.considered(model, key, NOT_FAR_BEHIND)[:IN_STEAD]
        likely = near or self._candidates.considered(model, key)[:1]
        others = self._refits.instead(model, key, likely)
        return sure_beside(self.compare([less, with_last(model, key), *others]))

    def standing(self, model: FittedFrfs) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
        """See `Data`: of the places that the law-free look points to, those whose curve tells the effect."""
        keys = model.hypothesis.keys
        if keys and set(keys) == set(self._told[0]):
            return keys, self._told[1]
        if self.is_named(model):
            return keys, ()
        if self.dominates(model):
            return keys, (self._left_at(model),)
        settled, sure, places = self._settled
        if keys and set(keys) <= set(settled):  # those that nobody misses went
            return tuple(key for key in sure if key in keys), places
        if not self.look.explains or self.lacking(model):
            return (), ()
        met = {key: one for key, one in self.look.met(keys).items() if one.surely(key[0])}
        open_ = [one.where for one in self.look.found if one not in met.values()]
        return (tuple(met), tuple(dict.fromkeys(open_))) if open_ else ((), ())

    def together(
        self, known: FittedFrfs | None = None
    ) -> tuple[FittedFrfs, Mapping[tuple[str, str], Sequence[FittedFrfs]]] | None:
        """See `Data`."""
        one, before = self._candidates.looks.one, self._look
        if self.asked is not None or one.explains or not one.needed:
            return None
        self._look = self._candidates.looks.several
        found = Together(self.setup, self.root, self._look, self.is_enough, self.without).found()
        there = set() if known is None else set(known.hypothesis.keys)
        more = found is not None and there < set(found[0].hypothesis.keys)
        if found is None or not (self.is_enough(found[0]) or (more and self.is_named(found[0]))):
            self._look = before
            return None
        for models in found[1].values():
            self._candidates.remember(list(models))
        return found

    def by_function(
        self, model: FittedFrfs, tried: Sequence[FittedFrfs], hardly: Collection[tuple[str, str]] = ()
    ) -> tuple[FittedFrfs, Mapping[tuple[str, str], float]] | None:
        """See `Data`; a law that explains everything goes before a sensor's numbers for each posture."""
        if self.asked is not None:
            return None
        looks = self._candidates.looks
        done = explains(self, model) and not self.is_contradicted(model)
        if done and (looks.one.lone is None or looks.one.lone.changes is not None):
            return None
        look = looks.one if looks.one.explains else looks.several
        told = told_of(look)
        standing = model.hypothesis.keys if done else self.standing(model)[0]
        named = tuple(key for key in standing if key not in hardly)
        keys = wanted(told, named, lone=looks.one.lone is not None, explained=done) if told else ()
        if not keys:
            return None

        def searched(before: FittedFrfs, key: tuple[str, str]) -> list[FittedFrfs]:
            number = len(before.hypothesis.keys)
            return self._candidates.searched(before, number, lambda *one: one == key, by_force=True)

        found = fitted_with(keys, self.root, tried, searched, partial(over_noise, self.setup))
        if found is None:
            return None
        places = {where for _, where in keys}
        left = [one.where for one in look.found if one.where not in places] or [where for _, where in told]
        self._told = keys, tuple(dict.fromkeys(left))
        return found, told

    @property
    def told(self) -> tuple[tuple[str, str], ...]:
        """See `Data`."""
        return self._told[0]

    def _left_at(self, model: FittedFrfs) -> str:
        """Where more than noise is left: where a look beside its effects points, else see `place`."""
        beside = self._candidates.looked(model)
        return self.place(model, None) if beside is None else beside.place

    def is_contradicted(self, model: FittedFrfs) -> bool:
        """See `Data`; by what was held out too. Effects that no port stands for are taken at their word.

        Several that all sit where the function of two coupled joints does what they do are no more than it,
        and those in the joints on a foundation no more than its function, if they leave nothing. What was
        found where the others were enough already does not count among them.
        """
        keys, held = model.hypothesis.keys, self.setup.held
        known = all(name in PORT_OF for name, _ in keys)
        if not keys or not known or not self.look.explains or self.look.met(keys):
            return False
        fails = held.any() and over_noise(self.setup, model, held) > EXPLAINED
        held_by = any(within(self.setup.context, keys, one.port, one.where) for one in self.look.found)
        if self.is_close(model) and any(one.port in DOES_MUCH for one in self.look.found):
            held_by |= {(PORT_OF[name], where) for name, where in keys} <= on_base(self.setup.context)
        if fails or held_by or len(keys) <= len(self.look.found):
            return bool(fails)
        needed = [key for key in keys if not self.is_enough(self.without(model, key))]
        return len(needed) > len(self.look.found)

    def share(self, first: FittedFrfs, last: FittedFrfs) -> float:
        """See `Data`."""
        return 1.0 - left(self.setup, first, last)
