"""Effects added one after the other, until the noise is reached or nothing significant is left."""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.compare import force_dependence
from flexmodal.diagnosis.describe import describe, weighed
from flexmodal.diagnosis.explanations import explanations
from flexmodal.diagnosis.figures import over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.looking import looked_at
from flexmodal.diagnosis.outcome import Step, Weighed
from flexmodal.diagnosis.preparation import Bench
from flexmodal.diagnosis.unstructured import unstructured_mode
from flexmodal.diagnosis.weigh import Weighable, weigh
from flexmodal.identification import predict

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


class Course:
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
        self.beside: Weighable | None = None
        """The best pair of effects, added or not."""
        self.force_matters = force_dependence(bench.observations) > FORCE

    def run(self) -> None:
        """Add effects until nothing significant is left; those that nobody misses go."""
        for number in range(MOST_STEPS):
            if number and over_noise(self.bench, self.current) <= FLOOR_REACHED:
                break
            step = self._step(number)
            if step is None:
                break
        if self.beside is not None and over_noise(self.bench, self.current) > FLOOR_REACHED:
            self._exchanged(self.beside)
        self._still_needed()

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
        if number and found:
            self.beside = looked[1 + int(np.argmax(scales.scores[1:-1]))]
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

    def _exchanged(self, pair: Weighable) -> None:
        """Look for the first effect again beside the second, where both together are not enough.

        Alone, an effect takes up what it can of another one, and may then sit in the wrong place.
        """
        kept = self.current, list(self.steps), self.refused, self.runner_up
        wrong = pair.hypothesis.keys[0]
        alone = self._without(pair, wrong)
        looked = [self.before, alone]
        scales = weigh(looked, self.bench.observations, self.bench.seed)
        self.steps[:] = [describe(self.bench, looked, scales, 1, self.before)]
        self.current, self.refused = alone, []
        step = self._step(1)
        if step is None or over_noise(self.bench, self.current) > FLOOR_REACHED:
            self.current, self.steps, self.refused, self.runner_up = kept

    def _still_needed(self) -> None:
        """Leave out every effect in turn; those that nobody misses go.

        The last one too: what it took away may have been due to a fit of those before it that had not ended.
        """
        for number, step in enumerate(list(self.steps)):
            if len(self.steps) == 1:
                break
            less = self._without(self.current, (step.effect, step.where))
            scales = weigh([less, self.current], self.bench.observations, self.bench.seed)
            if scales.gain[1] < SIGNIFICANT or (number and not _worth(less, self.current, number)):
                self.current = less
                self.steps.remove(step)

    def _without(self, one: Weighable, key: tuple[str, str]) -> Weighable:
        """Fitted again with one effect less."""
        prefix = "{}@{}.".format(*key)
        kept = [not name.startswith(prefix) for name in one.hypothesis.space.names]
        return looked_at(self.bench, one.hypothesis.without(key), one.fitted.x[np.array(kept)])


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
