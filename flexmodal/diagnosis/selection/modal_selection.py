"""Forward selection on measured modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects import Context, Effect, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.modal_search import (
    bare_starts,
    best_fits,
    effect_starts,
    free_starts,
    unmatched,
)
from flexmodal.diagnosis.selection.comparison import TIED, Comparison
from flexmodal.diagnosis.selection.decision import more_than_tied, needed
from flexmodal.diagnosis.selection.selection import ForwardSelection
from flexmodal.diagnosis.selection.variants import FittedModes, under_variants
from flexmodal.diagnosis.setup import Advance
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.likelihood.errors import errors
from flexmodal.identification.evidence.likelihood.held_out import in_turn, together
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.predictive import restricted
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.identification.evidence.modal_gap import gap_of_errors, noise_of
from flexmodal.model import Robot
from flexmodal.structure import ParameterSpace

FINALISTS = 9
"""Effects that are weighed under every variant."""
WITHIN = 16.0
"""Margin behind the best from which on an effect is not [nat]."""


class ModalSelection(ForwardSelection[FittedModes]):
    """Effects are needed as long as modes have no partner, and added where nothing is tied with them."""

    def __init__(
        self,
        whole: ModeObservations,
        robot: Robot,
        base: ParameterSpace,
        asked: Mapping[str, tuple[str, ...]] | None,
        held: np.ndarray | None,
        advance: Advance,
    ) -> None:
        """Re-tune the robot.

        Args:
            whole: every measured mode.
            robot: as it is believed to be.
            base: its parameters.
            asked: effects that were asked for, with places; None for all.
            held: which modes no fit sees; None where postures are left out in turn.
            advance: called with what is being done and the part of it that is done.

        Raises:
            InvalidRequest: a robot without modes.
        """
        self.whole, self.held, self.base, self.asked, self.advance = whole, held, base, asked, advance
        self.measured = whole if held is None else whole.keeping(~held)
        self.context = context_of(robot, whole)
        self.effects = tuple(catalogue(None if asked is None else list(asked)).values())
        self.untestable = {e.name: why for e in self.effects if (why := untestable(e, self.context))}
        advance("re-tuning the robot", 0.0)
        bare = ModalModel(Hypothesis(self.context, base))
        fits = best_fits(
            bare, self.measured, bare_starts(bare, self.measured, np.zeros(len(base))), Beliefs()
        )
        if not fits:
            raise InvalidRequest(Fault(robot.name, "", "no modes to be compared", "a robot that oscillates"))
        super().__init__(self._under_variants(bare, fits))

    def candidates(self, number: int) -> list[FittedModes]:
        """The best of every effect in every place, and a mode with no structure."""
        doing = "looking for an effect" if not number else "looking for another effect"
        self.advance(doing, 0.0)
        best = self.current.fit
        hypothesis, zero = self.current.hypothesis, best.x if number else np.zeros(len(self.base))
        wider = ModalModel(hypothesis, 1)
        free = best_fits(wider, self.measured, free_starts(wider, self.measured, zero), Beliefs())
        states = [(zero, unmatched(best))]
        if free:
            states.append((free[0].x[: len(zero)], unmatched(free[0])))
        searched, beside = [], [(wider, free)] if free else []
        places = self._places(hypothesis)
        for k, placed in enumerate(places):
            one = ModalModel(hypothesis.and_also(placed))
            found = best_fits(
                one, self.measured, effect_starts(placed, one, states, self.measured), Beliefs()
            )
            searched += [(one, found)] if found else []
            self.advance(doing, 0.7 * (k + 1) / max(len(places), 1))
        searched.sort(key=lambda some: -some[1][0].evidence)
        top = max([some[0].evidence for _, some in (*searched, *beside)], default=-np.inf)
        close = [some for some in searched[:FINALISTS] if some[1][0].evidence > top - WITHIN]
        close += [some for some in searched[:FINALISTS] if self.asked is not None and some not in close]
        finalists = [*beside, *close]
        models = [self.current]
        for k, (one, some) in enumerate(finalists, start=1):
            models.append(self._under_variants(one, some))
            self.advance(doing, 0.7 + 0.3 * k / len(finalists))
        return models

    def compare(self, models: Sequence[FittedModes]) -> Comparison[FittedModes]:
        """Under every set of beliefs."""
        table = np.array([one.evidence for one in models])
        return Comparison(models, table[:, 0], table, margin=TIED)

    def choose(self, comparison: Comparison[FittedModes], number: int) -> int | None:
        """The candidate that is decided among all, or the best of what was asked for."""
        structured = [k for k in comparison.order if k and not comparison.models[k].model.free]
        if self.asked is None:
            tied = comparison.tied
            decided = len(tied) == 1 and tied[0] in structured and needed(comparison, tied[0])
            return tied[0] if decided else None
        structured.sort(key=lambda k: -comparison.gain(k))
        for k in structured:
            name, where = comparison.models[k].key
            placed = where in self.asked[name] and more_than_tied(comparison.first_gain(k))
            if placed or needed(comparison, k):
                return k
        return None

    def is_enough(self, model: FittedModes) -> bool:
        """Whether every measured mode has a partner."""
        return not unmatched(model.fit)

    def gaps(self, before: FittedModes, after: FittedModes) -> Gaps:
        """With modes that a model lacks."""
        tables = [errors(self.everywhere(one.fit)) for one in (before, after)]
        held = [None if one.held is None else gap_of_errors(one.held.errors) for one in (before, after)]
        return Gaps(
            before=gap_of_errors(tables[0]),
            after=gap_of_errors(tables[1]),
            held_out_before=held[0],
            held_out_after=held[1],
            noise_floor=noise_of(self.whole, tables[1]),
        )

    def covariance(self, model: FittedModes) -> np.ndarray:
        """Scales at their best."""
        return model.covariance

    def weighed_gaps(self, model: FittedModes) -> tuple[float, float | None]:
        """On all modes, and as predicted by fits that had not seen them."""
        held = None if model.held is None else gap_of_errors(model.held.errors)
        return gap_of_errors(errors(self.everywhere(model.fit))), held

    def everywhere(self, fit: ModalFit) -> ModalFit:
        """A fit looked at with all modes, the held out ones included."""
        return fit if self.held is None else restricted(fit, self.whole)

    def _under_variants(self, model: ModalModel, fits: Sequence[ModalFit]) -> FittedModes:
        """With its predictions of the postures held out, or of each in turn."""
        found = under_variants(model, fits, self.measured)
        held = (
            in_turn(found.fit)
            if self.held is None
            else together([found.fit], self.whole, [self.held], found.fit)
        )
        return replace(found, held=held)

    def _places(self, hypothesis: Hypothesis) -> list[Placed]:
        """Effects that modes can tell of, in every place that is not taken."""
        found = []
        for effect in self.effects:
            if effect.name in self.untestable:
                continue
            places = effect.places(self.context)
            wanted = () if self.asked is None else self.asked[effect.name]
            unknown = [where for where in wanted if where not in places]
            if unknown:
                raise InvalidRequest(
                    [
                        Fault("call", "effects", f"{effect.name}@{where}", ", ".join(places))
                        for where in unknown
                    ]
                )
            found += [
                Placed(effect, where)
                for where in wanted or places
                if (effect.name, where) not in hypothesis.keys
            ]
        return found


def context_of(robot: Robot, measured: ModeObservations) -> Context:
    """The layout of a test of which modes are known and no line."""
    points = tuple(measured.campaign.points)
    return Context(robot, measured.postures, points, measured.responses, (), measured.band, every_line=False)


def untestable(effect: Effect, context: Context) -> str | None:
    """Why modes alone cannot tell of an effect."""
    if effect.read is not None or effect.turn is not None:
        return "modes have no calibrated FRF of a single sensor"
    if effect.by_force:
        return "modes were measured at one force, or do not say at which"
    if "response" in effect.variants:
        return "one set of modes for all places of the sensor"
    if effect.name == "structural_damping":
        return "a mode has one damping ratio; how loss depends on frequency is in the FRFs"
    return effect.untestable(context)
