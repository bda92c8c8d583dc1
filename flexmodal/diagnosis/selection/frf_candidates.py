"""What might be added to a model of FRFs: where a look without a law points, or everywhere."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np

from flexmodal.diagnosis.disagreement.gaps import left, over_noise
from flexmodal.diagnosis.lawfree.adjacent import adjacent
from flexmodal.diagnosis.lawfree.effects_at import HIDE, PORT_OF, WIDE
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.explanations import FOLLOWED, best_of_each, from_each_start
from flexmodal.diagnosis.search.next_level import at_next_level
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_starts import (
    does_more,
    likely_wider,
    nearer,
    pointed_to,
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
    LIKELY,
    NEARER,
    NOTHING_HIDDEN,
    ONCE_MORE,
)
from flexmodal.diagnosis.selection.looks_beside import laws_of
from flexmodal.diagnosis.selection.searches_beside import SearchesBeside
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_limit import cut_short

Judge = Callable[[FittedFrfs], bool]
"""Whether nothing else has to be looked for beside a model."""


class FrfCandidates(SearchesBeside):
    """Where looks point, by wider laws too; what was found beside the same effects before holds."""

    def __init__(self, setup: Setup, root: FittedFrfs, *, with_force: bool) -> None:
        """Nothing is looked at yet.

        Args:
            setup: what the diagnosis works with.
            root: the robot re-tuned.
            with_force: whether FRFs change with the force of the blow, or may.
        """
        super().__init__(setup, root, with_force=with_force)
        self._placed: dict[tuple[object, ...], tuple[float, list[FittedFrfs]]] = {}

    def doubted(self, model: FittedFrfs) -> tuple[str, str] | None:
        """One of several effects at whose place more is missing than anywhere else.

        Args:
            model: with effects.
        """
        keys = model.hypothesis.keys
        if len(keys) < 2 or not self.can_look(model):
            return None
        look = self.look_beside(model)
        return next((key for key in keys if look.needed and look.found[0].has(*key)), None)

    def at_places(
        self,
        before: FittedFrfs,
        number: int,
        look: Findings,
        is_over: Judge,
        *,
        only_met: bool = False,
    ) -> list[FittedFrfs]:
        """The finalists of a search where a look points.

        Where one place explains everything, effects of the class that its curve has are followed from each
        of their starts too, unless another one is enough that can do no more than they. What was found beside
        the same effects before holds unless the model is nearer now, so that fits set out from elsewhere.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            look: beside it.
            is_over: whether nothing else has to be looked for beside a model.
            only_met: whether only what has the place and the class that was found counts.
        """
        key = laws_of(before), is_over, only_met
        cost, known = self._placed.get(key, (np.inf, []))
        if before.cost < NEARER * cost:
            if only_met:
                known = self._met(before, number, look, is_over)
            else:
                known = self._at_places(before, number, look, lambda one: self.does(one, look, is_over))
            self._placed[key] = before.cost, known
        return known

    def does(self, model: FittedFrfs, look: Findings, is_over: Judge) -> bool:
        """Whether nothing else has to be looked for, or what one of several effects leaves is not due to it.

        Args:
            model: with effects.
            look: beside all but the last.
            is_over: says the first.
        """
        several = look.explains and len(model.hypothesis.keys) > 1
        return is_over(model) or (several and over_noise(self.setup, model) <= LAW_LEAVES * look.left)

    def _met(self, before: FittedFrfs, number: int, look: Findings, is_over: Judge) -> list[FittedFrfs]:
        """Effects at the places that were found alone, of the classes of their curves.

        Where none stands for what was found there, those of other kinds that do nearly as well without a law,
        if they leave nothing with theirs.
        """

        def allowed(effect: str, where: str) -> bool:
            return any(one.could_be(effect, where) for one in look.found)

        found = self.searched(before, number, allowed, one_is_enough=len(look.found) == 1)
        if not found:
            found = [one for one in self.searched(before, number, look.worth_trying) if is_over(one)]
        elif len(look.found) == 1:
            found = self._at_next_levels(before, found, look)
        return self._stuck(before, number, found, look)

    def _at_places(self, before: FittedFrfs, number: int, look: Findings, is_over: Judge) -> list[FittedFrfs]:
        alone = look.explains and len(look.found) == 1
        found = self.pointed_at(before, number, look, one_is_enough=alone)
        with cut_short(found and before.hypothesis.placed):  # one of several more is better than none
            for further in self._further(before, number, found, look, is_over):
                found = further
        return found

    def _further(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], look: Findings, is_over: Judge
    ) -> Iterator[list[FittedFrfs]]:
        """With more from other starts, by wider laws and in other places, one after the other."""
        if look.explains:
            enough = [one for one in found if is_over(one)]
            keys, followed = pointed_to(self.setup, before, look), FOLLOWED
            if enough:  # a wider one than there may be need of
                keys = [key for key in keys if any(self._is_plainer(key, one.key) for one in enough)]
                followed = ONCE_MORE
            if not any(self._is_enough(one) and look.is_at([one.key]) for one in found):
                more = [*nearer(self.setup, before, look), *swung(self.setup, before, look)]
                keys += [key for key in more if key not in keys]
            fitted = from_each_start(self.setup, before, starts(before, look), keys, is_over, followed)
            yield (found := best_of_each([*found, *fitted]))
        if len(look.found) == 1:
            yield (found := self._at_next_levels(before, found, look))
            if look.explains:
                yield (found := self._elsewhere(before, number, found, look))
        yield (found := self._stuck(before, number, found, look))
        yield (found := self._at_last(before, found))
        yield self._with_wider_laws(before, number, found, look)

    def _is_plainer(self, one: tuple[str, str], other: tuple[str, str]) -> bool:
        """Whether an effect can do no more than another one, or has fewer parameters."""
        effects = {effect.name: effect for effect in self.setup.effects}
        own, others = (len(effects[name].parameters(self.setup.context, at)) for name, at in (one, other))
        return does_more(other, one) or own < others

    def _with_wider_laws(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """With effects at places that do best without a law, and wider laws, where none takes a good part.

        Beside effects while several are missing: a narrow law may take nothing where a wide one takes most,
        of a foundation on bolts or of a rod. Of a rod whose ratio changes with the posture no function tells
        the joints either: the best coupling gets its wider law.
        """
        if not before.hypothesis.placed or any(left(self.setup, before, one) < 1 - ANOTHER for one in found):
            return found
        kinds = set(PORT_OF.values())
        best = [(one.port, one.where) for one in look.places if one.port in kinds][:LIKELY]
        found = self.also_at(before, number, found, [*best, *self._that_hide])
        told = SetOut([], starts(before, look).told)
        near = likely_wider(self.setup, found, look)
        hidden = [one for one in found if PORT_OF.get(one.key[0]) in HIDE]
        near += [one for one in hidden[:1] if one not in near]
        return best_of_each([*found, *self._at_next_level(near, told)])

    @property
    def _that_hide(self) -> list[tuple[str, str]]:
        """Kinds and places of ports whose effects have a wider law that no port of one function shows."""
        effects = [effect for effect in self.setup.effects if PORT_OF.get(effect.name) in HIDE]
        return [(PORT_OF[one.name], where) for one in effects for where in one.places(self.setup.context)]

    def _elsewhere(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """Effects in places that leave less with free functions than any law does where the look points.

        And in those that touch it. A port may be narrower than the law: a bearing's gives alike across the
        axis.
        """
        least = min((over_noise(self.setup, one) for one in found), default=0.0)
        if least <= max(EXPLAINED, LAW_LEAVES * look.left):
            return found
        others = {(one.port, one.where) for one in look.places if one.judged < least}
        others |= adjacent(self.setup.context, look.found[0].port, look.found[0].where)
        return self.also_at(before, number, found, others)

    def _stuck(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """With friction that hardly slides, at a joint whose function explains everything and no law does.

        FRFs do not change with the force of the blow then, so that nothing asked for friction.
        """
        if not look.explains or len(look.found) != 1 or self.depends_on_force(before):
            return found
        joint = look.found[0].where
        if look.found[0].port != "joint":
            return found
        here = [one for one in found if one.key[1] == joint]
        if any(over_noise(self.setup, one) <= NOTHING_HIDDEN for one in here):
            return found
        able = {effect.name for effect in self.setup.effects if effect.sticks}
        rubs = self.searched(
            before, number, lambda name, where: name in able and where == joint, by_force=True
        )
        return best_of_each([*found, *rubs])

    def _at_next_levels(
        self, before: FittedFrfs, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """Wider laws too, where every effect in the place that the look points to leaves more by its law.

        More than noise, and more than the functions of that place leave when they are free, or most of what
        is missing: where that is little, it is less than several times the noise to begin with. No narrow law
        is enough where the place is one that only wide ones have, or its curve is of another effect's class.
        Where free functions explain nothing either the law may tie what no function does.
        """
        enough = [one for one in found if self._is_enough(one) and left(self.setup, before, one) <= HALF]
        if any(look.met([one.key]) or not self._may_be_another(one, look) for one in enough):
            return found
        least = LAW_LEAVES * look.left if look.explains else EXPLAINED
        others = swung(self.setup, before, look)
        places = [one for one in found if look.met([one.key]) or one.key in others]
        does = [one for one in places if not look.explains or left(self.setup, before, one) <= HALF]
        if look.found[0].port not in WIDE and any(over_noise(self.setup, one) <= least for one in does):
            return found
        return best_of_each([*found, *self._at_next_level(places, starts(before, look))])

    def _may_be_another(self, model: FittedFrfs, look: Findings) -> bool:
        """Whether a law leaves something, where the curve that explains all is of a class that is known."""
        return (
            look.explains and bool(look.found[0].classes) and over_noise(self.setup, model) > NOTHING_HIDDEN
        )

    def _at_last(self, before: FittedFrfs, found: list[FittedFrfs]) -> list[FittedFrfs]:
        """The wider law of an effect that takes all but a little, wherever it is, if that leaves nothing."""
        nearly = [one for one in found if left(self.setup, before, one) <= HARDLY]
        if before.hypothesis.placed or not nearly or any(self._is_enough(one) for one in found):
            return found
        best = min(nearly, key=lambda one: over_noise(self.setup, one))
        wider = self._at_next_level([best], SetOut([]))
        return best_of_each([*found, *(one for one in wider if self._is_enough(one))])

    def wider(self, model: FittedFrfs, keys: Collection[tuple[str, str]]) -> list[FittedFrfs]:
        """The model with the next level of some of its effects, in turn, fitted closely; the best first.

        Args:
            model: with effects.
            keys: names and places of the ones.
        """
        able = [one.key for one in model.hypothesis.placed if one.effect.next_level is not None]
        turned = [with_last(model, key) for key in able if key in keys]
        return best_of_each(self._at_next_level(turned, SetOut([])))

    def _at_next_level(self, models: Sequence[FittedFrfs], set_out: SetOut) -> list[FittedFrfs]:
        """Models with the next level of their last effects."""
        return [more for one in models for more in at_next_level(self.setup, one, set_out, self._is_enough)]

    def considered(self, model: FittedFrfs, key: tuple[str, str], within: float = np.inf) -> list[FittedFrfs]:
        """What was found where an effect of a model was looked for last, but what the model has anyway.

        Args:
            model: with several effects.
            key: name and place of the one.
            within: times what the effect left then, up to which others count.
        """
        searches = [known for _, known in self._placed.values() if key in [one.key for one in known]]
        found = searches[-1] if searches else []
        limit = within * min((over_noise(self.setup, one) for one in found if one.key == key), default=0.0)
        others = [one for one in found if one.key not in model.hypothesis.keys]
        return [one for one in others if over_noise(self.setup, one) <= limit]

    def _is_enough(self, model: FittedFrfs) -> bool:
        close = any(one.effect.comes_close for one in model.hypothesis.placed[-1:])
        return over_noise(self.setup, model) <= (CLOSE if close else FLOOR_REACHED)
