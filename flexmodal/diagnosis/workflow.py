"""The workflow: re-tune, compare, hypothesise, weigh, add, and again, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.compare import disagreement, force_dependence
from flexmodal.diagnosis.describe import describe, weighed
from flexmodal.diagnosis.explanations import explanations
from flexmodal.diagnosis.figures import gaps_of, left, over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.looking import looked_at
from flexmodal.diagnosis.modes.workflow import diagnose_modes, is_modal
from flexmodal.diagnosis.next_measurement import next_measurement
from flexmodal.diagnosis.outcome import (
    Diagnosis,
    NextMeasurement,
    Step,
    Weighed,
)
from flexmodal.diagnosis.preparation import Advance, Bench, prepare
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.search import by_force
from flexmodal.diagnosis.unstructured import unstructured_mode
from flexmodal.diagnosis.verdict import verdict
from flexmodal.diagnosis.weigh import Weighable, weigh
from flexmodal.identification import (
    gap,
    predict,
    uncertainty,
)
from flexmodal.model import Robot

MOST_STEPS = 2
"""Effects added at most: more of them explain anything."""
FORCE = 1.5
"""Change of FRFs with the force of the blow, over their noise, from which a structure is not linear."""
SIGNIFICANT = 8.0
"""Score that an effect has to gain, in 19 of 20 draws of the bootstrap [nat]."""
WORTH = 0.03
"""Part of the sum of squares that it has to take away besides."""
ANOTHER = 0.35
"""The same for every further effect: what a good but not perfect model leaves is not another effect."""
FLOOR_REACHED = 1.4
"""Distance of a model from the measurement, over that of the noise, that needs no explanation."""
EXPLAINED = 2.0
"""The same that the model of a strong effect may show."""
LEFT = 0.03
"""Part of the disagreement above the noise that may be left then."""


def diagnose(
    campaign: Campaign,
    robot: Robot,
    *,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and a campaign of hammer tests on it.

    Args:
        campaign: with FRFs, or blows to estimate them from; with modes alone they are diagnosed (`modes`).
        robot: as it is believed to be.
        hold_out: postures (ids or names) that no weighed fit sees. By default one in four, at least one,
            those on which the re-tuned robot is neither best nor worst; with fewer than three postures none.
        effects: names from the catalogue; all by default.
        trust: standard deviation of ln(true / card) by kind or parameter name.
        seed: of the bootstrap.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no data, unknown effects or postures, a campaign that does not belong to the robot.
    """
    if is_modal(campaign):
        return diagnose_modes(
            campaign, robot, hold_out=hold_out, effects=effects, trust=trust, seed=seed, advance=advance
        )
    with threadpool_limits(1):  # matrices this small only wait for the threads of a BLAS
        return _Course(prepare(campaign, robot, hold_out, effects, trust, seed, advance)).run()


class _Course:
    """One run of the workflow; keeps what it has found so far."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        advance = bench.advance
        advance("re-tuning the robot", 0.0)
        root = Hypothesis(bench.scene, bench.base)
        zero = np.zeros(len(bench.base))
        self.believed = predict(root, zero, bench.observations)
        self.root, self.current = root, looked_at(bench, root, zero)
        self.before = self.current
        self.steps: list[Step] = []
        self.refused: list[Weighed] = []
        self.runner_up: Weighable | None = None
        self.force_matters = force_dependence(bench.observations) > FORCE

    def run(self) -> Diagnosis:
        """Add effects until nothing significant is left."""
        for number in range(MOST_STEPS):
            if number and over_noise(self.bench, self.current) <= FLOOR_REACHED:
                break
            step = self._step(number)
            if step is None:
                break
        self._still_needed()
        return self._conclude()

    # one step

    def _step(self, number: int) -> Step | None:
        bench, before = self.bench, self.current
        doing = f"looking for {'an effect' if not number else 'another effect'}"
        found = explanations(
            bench,
            before,
            _set_out(before),
            loud=self.force_matters,
            enough=FLOOR_REACHED,
            advance=lambda part: bench.advance(doing, part),
        )
        looked = [before, *found, unstructured_mode(bench, before)]
        scales = weigh(looked, bench.observations, bench.seed)
        best = int(np.argmax(scales.scores[:-1]))  # a mode with no structure is no explanation
        if best == 0 or scales.gain[best] < SIGNIFICANT or not _worth(before, looked[best], number):
            order = np.argsort(-scales.scores).tolist()
            self.refused = [weighed(bench, looked[k], before, scales, k) for k in order]
            return None
        self.current = looked[best]
        step = describe(bench, looked, scales, best, before)
        self.steps.append(step)
        second = [k for k in np.argsort(-scales.scores[:-1]).tolist() if k not in (0, best)]
        self.runner_up = looked[second[0]] if step.ties and second else None
        return step

    def _still_needed(self) -> None:
        """Leave out every effect in turn; those that nobody misses go.

        The last one too: what it took away may have been due to a fit of those before it that had not ended.
        """
        for number, step in enumerate(list(self.steps)):
            if len(self.steps) == 1:
                break
            key = (step.effect, step.where)
            without = self.current.hypothesis.without(key)
            kept = [
                float(v)
                for name, v in zip(self.current.hypothesis.space.names, self.current.fitted.x, strict=True)
                if not name.startswith(f"{step.effect}@{step.where}.")
            ]
            less = looked_at(self.bench, without, np.array(kept))
            scales = weigh([less, self.current], self.bench.observations, self.bench.seed)
            if scales.gain[1] < SIGNIFICANT or (number and not _worth(less, self.current, number)):
                self.current = less
                self.steps.remove(step)

    # the end

    def _conclude(self) -> Diagnosis:
        bench = self.bench
        bench.advance("fitting everything once more", 0.0)
        held_pair = gaps_of(bench, self.before, self.current)
        final = self.current
        if bench.held.any():
            every = bench.observations
            final = looked_at(bench, final.hypothesis, final.fitted.x, fitted_to=every)
            before = looked_at(bench, self.root, self.before.fitted.x, fitted_to=every)
        else:
            before = self.before
        over = over_noise(bench, final)
        explained = over <= FLOOR_REACHED or (over <= EXPLAINED and left(bench, self.before, final) <= LEFT)
        if self.force_matters and not by_force(final.hypothesis):
            explained = False  # nothing linear changes with the force
        everything = gap(bench.observations, self.believed)
        gaps = replace(
            gaps_of(bench, before, final, everything.value),
            held_out_before=held_pair.held_out_before,
            held_out_after=held_pair.held_out_after,
        )
        says = verdict(bench, self.steps, final, gaps, over, explained=explained)
        sure = uncertainty(final.hypothesis.space, final.fitted.normal, bench.observations)
        bench.advance("what to measure next", 0.5)
        return Diagnosis(
            campaign=bench.observations.campaign.title,
            robot=bench.scene.robot.name,
            gaps=gaps,
            disagreement=disagreement(bench.observations, before.predicted),
            remaining=disagreement(bench.observations, final.predicted),
            steps=tuple(self.steps) if explained else (),
            verdict=says,
            next_measurement=self._next(final),
            untestable={
                effect.name: why for effect in bench.effects if (why := effect.untestable(bench.scene))
            },
            left_out=bench.observations.silent,
            held_out=tuple(
                bench.observations.postures[int(k)].id
                for k in np.unique(bench.observations.posture[bench.held])
            ),
            model=final.hypothesis,
            x=final.fitted.x,
            deviation=sure.deviation,
            observations=bench.observations,
            predicted={"believed": self.believed, "before": before.predicted, "after": final.predicted},
            refused=tuple(self.refused),
            provenance=provenance(bench.observations.campaign, bench.scene.robot, bench.seed),
        )

    def _next(self, final: Weighable) -> NextMeasurement | None:
        if self.runner_up is None:
            return None
        return next_measurement(
            self.bench.scene,
            (final.hypothesis, final.fitted.x),
            (self.runner_up.hypothesis, self.runner_up.fitted.x),
        )


def _set_out(before: Weighable) -> list[np.ndarray]:
    """Where a search sets out: at the card, with the effects there are, and where the last fit ended.

    A fit without an effect that is there runs away from the truth.
    """
    count = len(before.hypothesis.base)
    x = before.fitted.x
    at_card = np.concatenate([np.zeros(count), x[count:]])
    return [at_card, x] if before.hypothesis.placed else [at_card]


def _worth(before: Weighable, after: Weighable, number: int) -> bool:
    """Whether an effect takes enough away; the first one from the data, or from parameters beyond belief."""
    taken = 1 - after.costs.sum() / max(before.costs.sum(), 1e-300)
    if number:
        return bool(taken >= ANOTHER)
    return bool(taken >= WORTH or (before.prior - after.prior) / 2 >= SIGNIFICANT)
