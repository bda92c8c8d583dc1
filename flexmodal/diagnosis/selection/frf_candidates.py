"""What might be added to a model of FRFs: where a look without a law points, or everywhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import Effect
from flexmodal.diagnosis.lawfree.adjacent import adjacent
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.explanations import FOLLOWED, best_of_each, from_each_start
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_starts import (
    does_more,
    nearer,
    pointed_to,
    starts,
    swung,
)
from flexmodal.diagnosis.selection.frf_thresholds import (
    EXPLAINED,
    LAW_LEAVES,
    NEARER,
    NOTHING_HIDDEN,
    ONCE_MORE,
    PERFECT,
    takes_enough,
)
from flexmodal.diagnosis.selection.looks_beside import laws_of
from flexmodal.diagnosis.selection.wider_laws import WiderLaws
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_limit import cut_short

Judge = Callable[[FittedFrfs], bool]
"""Whether nothing else has to be looked for beside a model."""


class FrfCandidates(WiderLaws):
    """Where looks point, by wider laws too; what was found beside the same effects before holds."""

    def __init__(
        self, setup: Setup, root: FittedFrfs, *, with_force: bool, known: Findings | None = None
    ) -> None:
        """Nothing is fitted yet.

        Args:
            setup: what the diagnosis works with.
            root: the robot re-tuned.
            with_force: whether FRFs change with the force of the blow, or may.
            known: the look beside the re-tuned robot, if that is known.
        """
        super().__init__(setup, root, with_force=with_force, known=known)
        self._placed: dict[tuple[object, ...], tuple[float, list[FittedFrfs]]] = {}
        self._narrow: dict[FittedFrfs, list[FittedFrfs]] = {}

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
            found = self.at_next_levels(before, found, look)
        return self._stuck(before, number, found, look)

    def by_narrow_laws(self, before: FittedFrfs, number: int, look: Findings) -> list[FittedFrfs]:
        """What does best where a look points, before any of it is followed further.

        Args:
            before: the model that something is added to.
            number: how many effects it has.
            look: beside it.
        """
        if before not in self._narrow:
            alone = look.explains and len(look.found) == 1
            self._narrow[before] = self.pointed_at(before, number, look, one_is_enough=alone)
        return self._narrow[before]

    def _at_places(self, before: FittedFrfs, number: int, look: Findings, is_over: Judge) -> list[FittedFrfs]:
        found = self.by_narrow_laws(before, number, look)
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
            if not any(self.is_enough(one) and look.is_at([one.key]) for one in found):
                more = [*nearer(self.setup, before, look), *swung(self.setup, before, look)]
                keys += [key for key in more if key not in keys]
            fitted = from_each_start(self.setup, before, starts(before, look), keys, is_over, followed)
            yield (found := best_of_each([*found, *fitted]))
        if len(look.found) == 1:
            yield (found := self.at_next_levels(before, found, look))
            if look.explains:
                yield (found := self._elsewhere(before, number, found, look))
        yield (found := self._stuck(before, number, found, look))
        yield (found := self.at_last(before, found))
        yield self.with_wider_laws(before, found, look)

    def _is_plainer(self, one: tuple[str, str], other: tuple[str, str]) -> bool:
        """Whether an effect can do no more than another one, or has fewer parameters."""
        effects = {effect.name: effect for effect in self.setup.effects}
        own, others = (len(effects[name].parameters(self.setup.context, at)) for name, at in (one, other))
        return does_more(other, one) or own < others

    def _elsewhere(
        self, before: FittedFrfs, number: int, found: list[FittedFrfs], look: Findings
    ) -> list[FittedFrfs]:
        """Effects in places that leave less with free functions than any law does where the look points.

        And in those that touch it, if the law is not as good as the truth would be. A port may be narrower
        than the law: a bearing's gives alike across the axis.
        """
        least = min((over_noise(self.setup, one) for one in found), default=0.0)
        if least <= PERFECT:
            return found
        others = set(adjacent(self.setup.context, look.found[0].port, look.found[0].where))
        if least > max(EXPLAINED, LAW_LEAVES * look.left):
            others |= {(one.port, one.where) for one in look.places if one.judged < least}
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

    def hidden_in_card(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """A model with what the card's masses or its damping may have taken over, if they are far enough off.

        If they are all right the sum of their squares is χ² of as many degrees of freedom. Not where there is
        something of the same kind already: of what is attached to a link a mass is a part.

        Args:
            before: the model.
            number: how many effects it has.
        """
        space = before.hypothesis.space
        there = {(PORT_OF.get(name), where) for name, where in before.hypothesis.keys}

        def hidden(effect: Effect) -> bool:
            some = [k for name, k in space.index.items() if name.startswith(effect.hides_in)]
            far = float(np.sum(space.precision[some] * before.x[some] ** 2 - 1)) / 2
            return takes_enough(0.0, before.prior / 2, before.prior / 2 - far, number) > Answer.NO

        wanted = {effect.name for effect in self.setup.effects if effect.hides_in and hidden(effect)}
        if not wanted:
            return []

        def allowed(name: str, where: str) -> bool:
            return name in wanted and (PORT_OF.get(name), where) not in there

        return [before, *self.searched(before, number, allowed)]

    def remember(self, models: list[FittedFrfs]) -> None:
        """What was fitted in one place beside the same effects, for `considered`.

        Args:
            models: the first has what is named there.
        """
        self._placed["together", models[0].key] = 0.0, models

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
