"""FRFs as forward selection sees them, with modes beside them or without."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.compare import disagreement, force_dependence, worst_point
from flexmodal.diagnosis.disagreement.gaps import as_believed, gap_of, gaps_of, left, over_noise
from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.afresh import NEARLY
from flexmodal.diagnosis.lawfree.look import SOUND
from flexmodal.diagnosis.lawfree.result import Findings as LawFree
from flexmodal.diagnosis.next_measurement.choose import next_among_fits
from flexmodal.diagnosis.outcome import Gaps, NextMeasurement
from flexmodal.diagnosis.search.close_fit import fitted_closely, fitted_to_everything
from flexmodal.diagnosis.search.explanations import best_of_each
from flexmodal.diagnosis.search.modal_search import unmatched
from flexmodal.diagnosis.search.unstructured import unstructured_mode
from flexmodal.diagnosis.selection.beside_frfs import ModesBeside
from flexmodal.diagnosis.selection.beside_nothing import beside_nothing
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.confidence import confidences, explains, plausible
from flexmodal.diagnosis.selection.decision import Answer, reaches
from flexmodal.diagnosis.selection.described import effect_parameters
from flexmodal.diagnosis.selection.frf_by_look import FrfsByLook
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs, compare_models
from flexmodal.diagnosis.selection.frf_starts import narrowest, starts
from flexmodal.diagnosis.selection.frf_thresholds import (
    EXPLAINED,
    FLOOR_REACHED,
    FORCE,
    FORCE_MARGIN,
    HALF,
    NOTHING_HIDDEN,
    THERE,
    THERE_MARGIN,
    reached,
    takes_enough,
)
from flexmodal.diagnosis.selection.in_its_stead import Refits
from flexmodal.diagnosis.selection.set_up_anew import clearly_nearer, seen_anew, with_everything
from flexmodal.diagnosis.selection.stand_in import stand_in, stands_in
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.diagnosis.time_limit import cut_short
from flexmodal.identification import gap, uncertainty
from flexmodal.identification.baselines import Baselines


class FrfData(FrfsByLook):
    """Effects are needed as long as the model is far from the averages over repeats."""

    confidences = confidences
    plausible = plausible

    def __init__(self, setup: Setup, modes: ModesBeside | None = None, known: LawFree | None = None) -> None:
        """Re-tune the robot.

        Args:
            setup: what the diagnosis works with.
            modes: that were measured too; they count in every comparison.
            known: the look beside the re-tuned robot as the test was thought to be set up before, if that
                says enough.
        """
        self.setup, self.modes = setup, modes
        self.campaign, self.context, self.advance = setup.observations.campaign, setup.context, setup.advance
        self.effects, self.asked = setup.effects, setup.asked
        setup.advance("re-tuning the robot", 0.0)
        bare, zero = Hypothesis(setup.context, setup.base), np.zeros(len(setup.base))
        self._root = fitted_closely(setup, bare, zero)
        self.force = reaches(force_dependence(setup.observations), FORCE, FORCE_MARGIN)
        """Whether FRFs change with the force of the blow."""
        self._candidates = FrfCandidates(setup, self._root, with_force=self.force > Answer.NO, known=known)
        self._look = self._candidates.looks.one
        self._refits = Refits(setup)

    @property
    def root(self) -> FittedFrfs:
        """See `Data`."""
        return self._root

    @property
    def untestable(self) -> Mapping[str, str]:
        """See `Data`."""
        return self.setup.untestable

    @property
    def held_out(self) -> tuple[int, ...]:
        """See `Data`."""
        seen = self.setup.observations
        return tuple(seen.postures[int(k)].id for k in np.unique(seen.posture[self.setup.held]))

    def pointed(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """See `Data`; everywhere where one place explains what is left and no effect does that there.

        Not everywhere beside a model that counts as explained anyway, nor beside several effects where one
        more takes half of what these leave. If time is up meanwhile, what was found before goes on.
        Beside a model that is named, or so strong that it would be, only what such a place stands for: its
        law may be to blame. Nothing where that of its effect took everything.
        """
        if self.is_alone(before) or not self._candidates.can_look(before):
            return [before]
        named = self.is_named(before) or self.dominates(before)
        look = self._candidates.look_beside(before)
        law = named and (not look.explains or look.is_at(before.hypothesis.keys))
        if self.asked is not None or law or not (look.needed or look.alone > SOUND):
            return [before]
        found = self._candidates.at_places(before, number, look, self.is_over, only_met=named)
        if named:
            return [before, *found]
        done = any(
            self._candidates.does(one, look, self.is_over)
            or (number > 1 and left(self.setup, before, one) <= HALF)
            for one in found
        )
        if look.explains and not explains(self, before) and not done:
            with cut_short(found):
                found = best_of_each([*found, *self._candidates.everywhere(before, number)])
        found = narrowest(self._that_are(found), self.is_enough)
        return [before, *found, *([] if number else [unstructured_mode(self.setup, before)])]

    def besides(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """See `Data`: at one other place that leaves nothing without a law, so that no law is to blame.

        Or what may hide in the card, where its masses or its damping are beyond belief.
        """
        if self.asked is not None:
            return []
        if self.is_close(before) or not self._candidates.can_look(before):
            return self._candidates.hidden_in_card(before, number)
        look = self._candidates.look_beside(before)
        if not look.explains or look.left > NEARLY or look.is_at(before.hypothesis.keys):
            return self._candidates.hidden_in_card(before, number)
        found = self._candidates.at_places(before, number, look, self.is_close, only_met=True)
        return [before, *found]

    def set_up_anew(self, models: Sequence[FittedFrfs]) -> tuple[FrfData, list[FittedFrfs]] | None:
        """See `Data`; not where that was in vain beside models as near."""
        if self._in_vain and not clearly_nearer(self.setup, models, self._in_vain):
            return None
        if (found := seen_anew(self.setup, models)) is None:
            self._in_vain = models
            return None
        setup, (first, *others) = found
        look = self._candidates.looks.one
        near = min((over_noise(setup, one) for one in others), default=0.0)
        data = FrfData(setup, self.modes, None if look.explains or near <= EXPLAINED else look)
        if others:  # what may be in the first one's place
            data._candidates.remember(sorted(others, key=lambda one: one.cost))
        return data, [first if first.hypothesis.placed else data.root, *others]

    def candidates(self, before: FittedFrfs, number: int) -> list[FittedFrfs]:
        """The finalists of a search, and a mode with no structure last.

        A look for several places says where it goes; everywhere where that does not explain it either.
        """
        self._look = self._candidates.looks.several
        if self.look.explains and len(self.look.found) > max(1, number):
            found = self._candidates.searched(before, number, self.look.worth_trying)
        else:
            found = self._candidates.everywhere(before, number)
        found = narrowest(self._that_are(found), self.is_enough)
        return [before, *found, unstructured_mode(self.setup, before)]

    def compare(self, models: Sequence[FittedFrfs]) -> Comparison[FittedFrfs]:
        """On the postures that were fitted and those held out, and on modes."""
        found = compare_models(models, self.setup.observations, self.setup.seed)
        return found if self.modes is None else self.modes.added_to(found)

    def without(self, model: FittedFrfs, key: tuple[str, str]) -> FittedFrfs:
        """See `Data`."""
        return self._refits.without(model, key)

    def worth(self, before: FittedFrfs, after: FittedFrfs, number: int) -> Answer:
        """Of the sum of squares; from the data, or from parameters beyond belief.

        From these, beside others, only where the others are enough: what is missing takes them there.
        What lies within tolerances is one error for all lines, however much evidence that looks like.
        """
        if not self.campaign.tolerance.is_exact and self.is_enough(before):
            return Answer.NO
        there = self._is_there(
            after, [key for key in after.hypothesis.keys if key not in before.hypothesis.keys]
        )
        taken = float(1 - after.costs.sum() / max(before.costs.sum(), 1e-300))
        back = number == 0 or self.is_enough(before)
        far = (before.prior / 2, after.prior / 2) if back else (0.0, 0.0)
        return min(there, takes_enough(taken, *far, number))

    def _that_are(self, found: Sequence[FittedFrfs]) -> list[FittedFrfs]:
        """Models whose last effect is not nothing: what re-tunes a joint says nothing of what is missing."""
        return [one for one in found if self._is_there(one, [one.key]) > Answer.NO]

    def _is_there(self, model: FittedFrfs, added: Sequence[tuple[str, str]]) -> Answer:
        """Whether what makes some effects differs from nothing: a coupling of 0 re-tunes either joint."""
        hypothesis, found = model.hypothesis, Answer.YES
        for placed in hypothesis.placed:
            made_by = placed.effect.made_by if placed.key in added else ()
            if made_by:
                values, _, errors = effect_parameters(hypothesis, placed.key, model.x, self.covariance(model))
                far = max(abs(values[name]) / max(errors[name], 1e-300) for name in made_by)
                found = min(found, reaches(far, THERE, THERE_MARGIN))
        return found

    def is_enough(self, model: FittedFrfs) -> bool:
        """Whether it reaches the noise, and every mode has a partner."""
        return over_noise(self.setup, model) <= FLOOR_REACHED and not self.lacking(model)

    def is_close(self, model: FittedFrfs) -> bool:
        """Whether it is where no further effect hides in the noise."""
        return over_noise(self.setup, model) <= NOTHING_HIDDEN

    def is_slow(self, model: FittedFrfs) -> bool:
        """See `Data`: torques that are not linear are integrated in time."""
        return has_law(model.hypothesis)

    def lacking(self, model: FittedFrfs) -> Mapping[int, float]:
        """See `Data`."""
        return {} if self.modes is None else unmatched(self.modes.predicted(model)[0])

    def gaps(self, before: FittedFrfs, after: FittedFrfs) -> Gaps:
        """Of single records."""
        return gaps_of(self.setup, before, after)

    def compared_gaps(self, model: FittedFrfs) -> tuple[float, float | None]:
        """Of postures fitted, and held out."""
        held = self.setup.held
        return gap_of(self.setup, model, ~held), gap_of(self.setup, model, held) if held.any() else None

    def covariance(self, model: FittedFrfs) -> Float[np.ndarray, "parameter parameter"]:
        """By clusters."""
        return uncertainty(model.hypothesis.space, model.fitted.normal, self.setup.fitted).covariance

    def conclude(self, first: FittedFrfs, last: FittedFrfs, *, again: bool) -> Conclusion[FittedFrfs]:
        """See `Data`; the gaps on what was held out are those of before."""
        setup = self.setup
        setup.advance("fitting everything once more", 0.0)
        apart, before, after = gaps_of(setup, first, last), first, last
        if again and setup.held.any():
            setup, (before, after) = with_everything(setup, [first, last])
            before, after = (fitted_to_everything(setup, one) for one in (before, after))
        every = setup.observations
        gaps = gaps_of(setup, before, after, gap(every, as_believed(setup)).value)
        over = over_noise(setup, after)
        seen = every if again else setup.fitted
        sure = uncertainty(after.hypothesis.space, after.fitted.normal, seen).covariance
        whole = first if setup is self.setup else before  # seen where the test is thought to be set up
        return Conclusion(
            before, after,
            replace(gaps, held_out_before=apart.held_out_before, held_out_after=apart.held_out_after),
            disagreement(every, before.predicted), disagreement(every, after.predicted), sure, over,
            reached(over, left(setup, whole, after), Answer.NO if after.hypothesis.by_force else self.force),
            setup,
        )  # fmt: skip

    def place(self, model: FittedFrfs, findings: Findings | None) -> str:
        """Where the law-free look points, else the place of what comes nearest, or the worst point."""
        if self.look.explains:
            return self.look.place
        keys = model.hypothesis.keys
        return keys[-1][1] if keys else worst_point(self.setup.observations, model.predicted)

    def modes_seen(
        self, first: FittedFrfs, last: FittedFrfs, conclusion: Conclusion[FittedFrfs]
    ) -> ModesSeen | None:
        """See `Data`."""
        if self.modes is None:
            return None
        return self.modes.shown((first, last), (conclusion.before, conclusion.after), self.held_out)

    def stand_in(self, model: FittedFrfs, further: FittedFrfs | None, *, search: bool) -> FittedFrfs | None:
        """See `Data`: at the places that the law-free look points to; where all of them are named, none."""
        if further is not None and stands_in(self.setup, model, further):
            return further
        if not search or not self.look.needed or self.is_named(model):
            return None
        return stand_in(self.setup, self.look, model, starts, with_force=self.force > Answer.NO)

    def baselines(self, model: FittedFrfs) -> Baselines | None:
        """See `Data`."""
        return beside_nothing(self.setup, model)

    def next_measurement(self, models: Sequence[tuple[FittedFrfs, float]]) -> NextMeasurement:
        """See `Data`."""
        return next_among_fits(self.setup.observations, models, self.covariance, self.setup.seed)

    def shown(self, conclusion: Conclusion[FittedFrfs]) -> dict[str, Any]:
        """The FRFs and what the models have for them."""
        before, after = conclusion.before.predicted, conclusion.after.predicted
        seen = conclusion.setup or self.setup
        told = {"believed": as_believed(seen), "before": before, "after": after}
        return {"frfs": seen.observations, "predicted": told, "moved": seen.moved}
