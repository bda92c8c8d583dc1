"""Measured modes as forward selection sees them: natural frequencies, damping ratios and shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.modal_regions import regions
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.next_measurement.choose import next_frf
from flexmodal.diagnosis.next_measurement.predicted import Sure
from flexmodal.diagnosis.outcome import Gaps, NextMeasurement
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.modal_search import (
    bare_starts,
    best_fits,
    effect_starts,
    free_starts,
    unmatched,
)
from flexmodal.diagnosis.selection.asked import effects_of
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import Answer, Asked, Round, any_gains
from flexmodal.diagnosis.selection.untestable import of_modes
from flexmodal.diagnosis.selection.variants import FittedModes, under_variants
from flexmodal.diagnosis.setup import Advance
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.likelihood.errors import errors, mean_of_others
from flexmodal.identification.evidence.likelihood.fit import COARSE
from flexmodal.identification.evidence.likelihood.held_out import in_turn, together
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.predictive import restricted
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.likelihood.shapes import compare_shapes
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.identification.evidence.modal_gap import gap_of_errors, noise_of
from flexmodal.model import Robot
from flexmodal.structure import ParameterSpace

FINALISTS = 9
"""Effects that are compared under every variant."""
WITHIN = 16.0
"""Margin behind the best from which on an effect is not [nat]."""
EVERYWHERE = "arm"
"""Where something sits that cannot be placed."""


class ModalData(Data[FittedModes]):
    """Effects are needed as long as modes have no partner."""

    def __init__(
        self,
        whole: ModeObservations,
        robot: Robot,
        base: ParameterSpace,
        asked: Asked | None,
        held: np.ndarray | None,
        seed: int,
        advance: Advance,
    ) -> None:
        """Re-tune the robot.

        Args:
            whole: every measured mode.
            robot: as it is believed to be.
            base: its parameters.
            asked: effects that were asked for, with places; None for all.
            held: which modes no fit sees; None where postures are left out in turn.
            seed: of the postures tried for the next measurement.
            advance: called with what is being done and the part of it that is done.

        Raises:
            InvalidRequest: a robot without modes, or an effect where it cannot sit.
        """
        self.whole, self.held, self.base, self.asked, self.advance = whole, held, base, asked, advance
        self.seed, self.campaign = seed, whole.campaign
        self.measured = whole if held is None else whole.keeping(~held)
        self.context = context_of(robot, whole)
        self.effects = effects_of(asked, self.context)
        advance("re-tuning the robot", 0.0)
        bare = ModalModel(Hypothesis(self.context, base))
        found = self._fitted(bare, np.zeros(len(base)))
        if found is None:
            raise InvalidRequest(Fault(robot.name, "", "no modes to be compared", "a robot that oscillates"))
        self._root = found

    @property
    def root(self) -> FittedModes:
        """See `Data`."""
        return self._root

    @property
    def untestable(self) -> Mapping[str, str]:
        """See `Data`."""
        return {one.name: why for one in self.effects if (why := of_modes(one, self.context))}

    @property
    def held_out(self) -> tuple[int, ...]:
        """See `Data`; none where each posture is left out in turn."""
        if self.held is None:
            return ()
        numbers = {mode.posture for mode, out in zip(self.whole.modes, self.held, strict=True) if out}
        return tuple(self.whole.postures[k].id for k in sorted(numbers))

    def candidates(self, before: FittedModes, number: int) -> list[FittedModes]:
        """The best of every effect in every place, and a mode with no structure."""
        doing = "looking for an effect" if not number else "looking for another effect"
        self.advance(doing, 0.0)
        best = before.fit
        hypothesis, zero = before.hypothesis, best.x if number else np.zeros(len(self.base))
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
        models = [before]
        for k, (one, some) in enumerate(finalists, start=1):
            models.append(self._under_variants(one, some))
            self.advance(doing, 0.7 + 0.3 * k / len(finalists))
        return models

    def compare(self, models: Sequence[FittedModes]) -> Comparison[FittedModes]:
        """Under every set of beliefs."""
        table = np.array([one.evidence for one in models])
        return Comparison(models, table[:, 0], table, beliefs=True)

    def without(self, model: FittedModes, key: tuple[str, str]) -> FittedModes:
        """See `Data`."""
        prefix = "{}@{}.".format(*key)
        kept = [not name.startswith(prefix) for name in model.hypothesis.space.names]
        found = self._fitted(ModalModel(model.hypothesis.without(key)), model.x[np.array(kept)])
        return self.root if found is None else found

    def worth(self, before: FittedModes, after: FittedModes, number: int) -> Answer:
        """The evidence says it all: the scatter is inferred along."""
        return Answer.YES

    def is_enough(self, model: FittedModes) -> bool:
        """Whether every measured mode has a partner."""
        return not self.lacking(model)

    def lacking(self, model: FittedModes) -> Mapping[int, float]:
        """See `Data`."""
        return unmatched(model.fit)

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

    def covariance(self, model: FittedModes) -> Float[np.ndarray, "parameter parameter"]:
        """Scales at their best."""
        return model.covariance

    def compared_gaps(self, model: FittedModes) -> tuple[float, float | None]:
        """On all modes, and as predicted by fits that had not seen them."""
        held = None if model.held is None else gap_of_errors(model.held.errors)
        return gap_of_errors(errors(self.everywhere(model.fit))), held

    def conclude(self, first: FittedModes, last: FittedModes, *, again: bool) -> Conclusion[FittedModes]:
        """Every fit has seen everything but what was held out."""
        card = replace(first.fit, x=np.zeros(len(first.fit.x)))  # which may be far off and have the modes
        believed = gap_of_errors(errors(restricted(card, self.whole, COARSE[0])))
        return Conclusion(
            first, last, replace(self.gaps(first, last), believed=believed),
            regions(self.everywhere(first.fit)), regions(self.everywhere(last.fit)), last.covariance, None,
            Answer.YES,
        )  # fmt: skip

    def everywhere(self, fit: ModalFit) -> ModalFit:
        """A fit looked at with all modes, the held out ones included."""
        return fit if self.held is None else restricted(fit, self.whole)

    def findings(
        self,
        rounds: Sequence[Round[FittedModes]],
        current: FittedModes,
        compared: tuple[FittedModes, FittedModes] | None,
    ) -> Findings:
        """See `Data`; `after` is the final model, or without a step the best of what was compared."""
        first, stepped = rounds[0].comparison, current is not self.root
        best = current if stepped else first.models[first.order[0]]
        worth_it = stepped or any_gains(first) is Answer.YES
        free = next((one for one in first.models if one.key[0] == UNSTRUCTURED), None)
        pair = compared if compared and all(one.hypothesis.placed for one in compared) else None
        tied = tuple(first.models[k].key for k in first.tied)
        return Findings(
            modes=ModesSeen(
                measured=self.whole,
                before=self.everywhere(self.root.fit),
                after=self.everywhere(best.fit),
                held_before=first.models[0].held,
                held_after=best.held,
                mean=mean_of_others(self.whole),
                free=None if free is None else self.everywhere(free.fit),
                held_free=None if free is None else free.held,
            ),
            comparison=first,
            tied=tied if worth_it and len(tied) > 1 else (),
            missing=tuple(unmatched(self.root.fit).items()),
            left=tuple(unmatched(best.fit if worth_it else self.root.fit).items()),
            shapes=() if pair is None else compare_shapes(pair[0].fit, pair[1].fit),
            compared=None if pair is None else (pair[0].key, pair[1].key),
            told=self.asked is not None,
        )

    def place(self, model: FittedModes, findings: Findings | None) -> str:
        """The one place that everything tied points at; the arm as a whole where there is none."""
        named = (model.key,) if findings is None else findings.tied or (findings.modes.after.model.key,)
        places = {where for effect, where in named if effect != NONE}
        return places.pop() or EVERYWHERE if len(places) == 1 else EVERYWHERE

    def next_measurement(self, models: Sequence[tuple[FittedModes, float]]) -> NextMeasurement:
        """An FRF."""
        every = [Sure(one.hypothesis, one.x, one.covariance, weight) for one, weight in models]
        return next_frf(self.campaign, self.whole.responses[0][1], every, self.seed)

    def alike(self, one: FittedModes, other: FittedModes) -> bool:
        """Whether as many measured modes have no partner in both."""
        lacks = [sum(partner < 0 for partner in model.fit.pairs) for model in (one, other)]
        return lacks[0] == lacks[1]

    def _fitted(self, model: ModalModel, x: Float[np.ndarray, " parameter"]) -> FittedModes | None:
        """From given coordinates, in every way to pair modes."""
        fits = best_fits(model, self.measured, bare_starts(model, self.measured, x), Beliefs())
        return self._under_variants(model, fits) if fits else None

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
        return [
            Placed(effect, where)
            for effect in self.effects
            if effect.name not in self.untestable
            for where in effect.places(self.context)
            if (effect.name, where) not in hypothesis.keys
        ]


def context_of(robot: Robot, measured: ModeObservations) -> Context:
    """The layout of a test of which modes are known and no line.

    Args:
        robot: as it is believed to be.
        measured: every measured mode.
    """
    points = tuple(measured.campaign.points)
    return Context(robot, measured.postures, points, measured.responses, (), measured.band, every_line=False)
