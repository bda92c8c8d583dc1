"""Diagnosis of a campaign of modes: the same course as with FRFs, on natural frequencies, damping and shapes.

Re-tune, compare, fit every effect that adds to the structure in every place, one mode without structure
beside them, weigh under several beliefs, and add what is decided. What is tied is said to be tied. Where
the caller names effects, the best of them is added even so, with its ties.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.effects import Context, Effect, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis, Placed
from flexmodal.diagnosis.modes.conclude import conclude
from flexmodal.diagnosis.modes.elsewhere import restricted
from flexmodal.diagnosis.modes.evidence import ModalFit
from flexmodal.diagnosis.modes.forecast import Explanation
from flexmodal.diagnosis.modes.held_out import HeldOut, in_turn, together
from flexmodal.diagnosis.modes.measured import MeasuredModes
from flexmodal.diagnosis.modes.scatter import Beliefs
from flexmodal.diagnosis.modes.search import bare_starts, best_fits, effect_starts, free_starts, unmatched
from flexmodal.diagnosis.modes.stand_in import placed_on
from flexmodal.diagnosis.modes.weigh import TIED, Candidate, Scales, under_variants
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.preparation import numbers_of, trust_of
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.compatibility import check_compatible
from flexmodal.identification.evidence.measured_modes import modes_of_table
from flexmodal.model import Robot
from flexmodal.structure import ParameterSpace, robot_space

TRUST = {"stiffness": 0.5, "damping": 1.0, "mass": 0.2, "inertia": 0.2}
"""Standard deviation of ln(true / card) unless the card or the caller says other; weighing halves and
doubles it."""
SIGNIFICANT = 8.0
"""Evidence that an explanation has to gain under the first beliefs; under others more than a tie."""
FINALISTS = 9
"""Effects that are weighed under every variant."""
WITHIN = 16.0
"""Margin behind the best from which on an effect is not [nat]."""
MARGIN = 1.0
"""On both sides of what an explanation that was asked for by its place has to gain: inside, it is undecided,
and no rounding turns that into a name [nat]."""
MOST_STEPS = 2

Advance = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Round:
    """One round of weighing."""

    scales: Scales
    chosen: int | None
    """Number of the candidate that is added; None where none is."""


def is_modal(campaign: Campaign) -> bool:
    """Whether a campaign has modes and nothing else."""
    return campaign.frfs is None and not campaign.blows and campaign.modes is not None


def diagnose_modes(
    campaign: Campaign,
    robot: Robot,
    *,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and measured modes; see `flexmodal.diagnosis.diagnose`.

    Args:
        campaign: with `modes.csv`; a point on a link that the robot lacks is taken where its card has a point
            of that name.
        robot: as it is believed to be.
        hold_out: postures that no fit sees. By default each is left out in turn, with three or more.
        effects: names; what explains best among them is added if it is needed, tied or not. Or `NAME@WHERE`:
            that is added if it gains more than a tie under the first beliefs.
        trust: standard deviation of ln(true / card) by kind or name.
        seed: of the postures tried for the next measurement.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no modes, unknown effects or postures, a campaign that does not belong to the robot.
    """
    placed, moved = placed_on(campaign, robot)
    check_compatible(placed, robot)
    measured = MeasuredModes(modes_of_table(placed))
    asked = _asked(effects)
    base = robot_space(robot, trust={**trust_of(robot, TRUST), **(trust or {})})
    held = None
    if hold_out is not None:
        away = numbers_of(measured.observed.postures, hold_out, seen_by="modes")
        held = np.array([mode.posture in away for mode in measured.observed.modes])
    with threadpool_limits(1):
        return _Course(measured, robot, base, asked, held, moved, seed, advance).run()


class _Course:
    """One run; keeps what it has found so far."""

    def __init__(
        self,
        whole: MeasuredModes,
        robot: Robot,
        base: ParameterSpace,
        asked: Mapping[str, tuple[str, ...]] | None,
        held: np.ndarray | None,
        moved: tuple[str, ...],
        seed: int,
        advance: Advance,
    ) -> None:
        self.whole, self.held = whole, held
        self.measured = whole if held is None else whole.keeping(~held)
        self.scene = replace(Context.of(robot, whole.stand_in), every_line=False)
        self.base, self.asked, self.moved, self.seed, self.advance = base, asked, moved, seed, advance
        self.effects = tuple(catalogue(None if asked is None else list(asked)).values())
        self.untestable = {e.name: why for e in self.effects if (why := untestable(e, self.scene))}

    def run(self) -> Diagnosis:
        self.advance("re-tuning the robot", 0.0)
        zero = np.zeros(len(self.base))
        bare = Explanation(Hypothesis(self.scene, self.base))
        fits = best_fits(bare, self.measured, bare_starts(bare, self.measured, zero), Beliefs())
        if not fits:
            raise InvalidRequest(
                Fault(self.scene.robot.name, "", "no modes to be compared", "a robot that oscillates")
            )
        rounds: list[Round] = []
        root = fits
        for number in range(MOST_STEPS):
            rounds.append(self._round(fits, number))
            chosen = rounds[-1].chosen
            if chosen is None or not unmatched(rounds[-1].scales.candidates[chosen].fit):
                break
            fits = [rounds[-1].scales.candidates[chosen].fit]
        return conclude(self, root[0], rounds)

    def _round(self, before: list[ModalFit], number: int) -> Round:
        doing = "looking for an effect" if not number else "looking for another effect"
        self.advance(doing, 0.0)
        best = before[0]
        hypothesis, zero = best.explanation.hypothesis, best.x if number else np.zeros(len(self.base))
        wider = Explanation(hypothesis, 1)
        free = best_fits(wider, self.measured, free_starts(wider, self.measured, zero), Beliefs())
        states = [(zero, unmatched(best))]
        if free:
            states.append((free[0].x[: len(zero)], unmatched(free[0])))
        searched = []
        places = self._places(hypothesis)
        for k, placed in enumerate(places):
            one = Explanation(hypothesis.and_also(placed))
            found = best_fits(
                one, self.measured, effect_starts(placed, one, states, self.measured), Beliefs()
            )
            searched += [found] if found else []
            self.advance(doing, 0.7 * (k + 1) / max(len(places), 1))
        searched.sort(key=lambda some: -some[0].evidence)
        top = max([some[0].evidence for some in (*searched, *([free] if free else []))], default=-np.inf)
        close = [some for some in searched[:FINALISTS] if some[0].evidence > top - WITHIN]
        close += [some for some in searched[:FINALISTS] if self.asked is not None and some not in close]
        finalists = [before, *([free] if free else []), *close]
        candidates = []
        for k, some in enumerate(finalists):
            weighed = under_variants(some, self.measured)
            candidates.append(Candidate(weighed.fit, weighed.evidence, self.predict(weighed.fit)))
            self.advance(doing, 0.7 + 0.3 * (k + 1) / len(finalists))
        scales = Scales(tuple(candidates))
        return Round(scales, self._choose(scales))

    def _places(self, hypothesis: Hypothesis) -> list[Placed]:
        """Effects that modes can tell of, in every place that is not taken."""
        found = []
        for effect in self.effects:
            if effect.name in self.untestable:
                continue
            places = effect.places(self.scene)
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

    def _choose(self, scales: Scales) -> int | None:
        """The candidate that is added: decided among all, or the best of what was asked for."""
        structured = [k for k in scales.order if k and not scales.candidates[k].fit.explanation.free]
        if self.asked is None:
            tied = scales.tied
            return tied[0] if len(tied) == 1 and tied[0] in structured and needed(scales, tied[0]) else None
        structured.sort(key=lambda k: -scales.gain(k))
        for k in structured:
            name, where = scales.candidates[k].key
            if needed(scales, k) or (where in self.asked[name] and more_than_tied(scales.first_gain(k))):
                return k
        return None

    def predict(self, fit: ModalFit) -> HeldOut | None:
        """Of the postures held out, or of each in turn."""
        if self.held is None:
            return in_turn(fit)
        return together([fit], self.whole, [self.held], fit)

    def everywhere(self, fit: ModalFit) -> ModalFit:
        """A fit looked at with all modes, the held out ones included."""
        return fit if self.held is None else restricted(fit, self.whole)


def needed(scales: Scales, number: int) -> bool:
    """Whether a candidate gains enough under the first beliefs, and more than a tie under all."""
    return bool(scales.table[number, 0] - scales.table[0, 0] >= SIGNIFICANT and scales.gain(number) >= TIED)


def more_than_tied(gain: float) -> bool:
    """Whether what was asked for by its place gains clearly more than a tie under the first beliefs [nat]."""
    return gain > TIED + MARGIN


def undecided(gain: float) -> bool:
    """Whether that gain is too near to a tie's for a yes or a no."""
    return abs(gain - TIED) <= MARGIN


def untestable(effect: Effect, scene: Context) -> str | None:
    """Why modes alone cannot tell of an effect."""
    if effect.read is not None or effect.turn is not None:
        return "modes have no calibrated FRF of a single sensor"
    if effect.by_force:
        return "modes were measured at one force, or do not say at which"
    if "response" in effect.variants:
        return "one set of modes for all places of the sensor"
    if effect.name == "structural_damping":
        return "a mode has one damping ratio; how loss depends on frequency is in the FRFs"
    return effect.untestable(scene)


def _asked(effects: Sequence[str] | None) -> dict[str, tuple[str, ...]] | None:
    """Names with the places that were named along; none for all."""
    if effects is None:
        return None
    found: dict[str, tuple[str, ...]] = {}
    for one in effects:
        name, _, where = one.partition("@")
        found[name] = (*found.get(name, ()), *([where] if where else []))
    catalogue(list(found))  # says what is unknown
    return found
