"""Forward selection on FRFs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.compare import force_dependence
from flexmodal.diagnosis.disagreement.gaps import gap_of, gaps_of, left, over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.first_look import looked_freely
from flexmodal.diagnosis.lawfree.result import CLASSES_OF, Findings
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.search.explanations import explanations
from flexmodal.diagnosis.search.looking import looked_at
from flexmodal.diagnosis.search.modal_search import unmatched
from flexmodal.diagnosis.search.unstructured import unstructured_mode
from flexmodal.diagnosis.selection.beside_frfs import ModesBeside
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs, compare_models
from flexmodal.diagnosis.selection.selection import SIGNIFICANT, ForwardSelection
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import predict, uncertainty

FORCE = 1.5
"""Change of FRFs with the force of the blow, over their noise, from which a structure is not linear."""
WORTH = 0.03
"""Part of the sum of squares that an effect has to take away besides."""
ANOTHER = 0.35
"""The same for every further effect: what a good but not perfect model leaves is not another effect."""
LARGER_PART, NEARLY_ALL = 0.5, 0.9
"""Part of the disagreement that an effect takes to be named where its law is not quite the catalogue's; the
second where no curve tells its class."""
FLOOR_REACHED = 1.4
"""Distance of a model from the measurement, over that of the noise, that needs no explanation."""


class FrfSelection(ForwardSelection[FittedFrfs]):
    """Effects are needed as long as the model is far from the averages over repeats."""

    def __init__(self, setup: Setup, modes: ModesBeside | None = None) -> None:
        """Re-tune the robot.

        Args:
            setup: what the diagnosis works with.
            modes: that were measured too; they count in every comparison.
        """
        self.modes = modes
        setup.advance("re-tuning the robot", 0.0)
        bare, zero = Hypothesis(setup.context, setup.base), np.zeros(len(setup.base))
        self.setup = setup
        self.believed = predict(bare, zero, setup.observations)
        super().__init__(looked_at(setup, bare, zero))
        self.runner_up: FittedFrfs | None = None
        """What is tied with the effect that was added last."""
        self.beside: FittedFrfs | None = None
        """The best pair of effects, added or not."""
        self.force_matters = force_dependence(setup.observations) > FORCE

    def run(self) -> None:
        """Add effects until nothing significant is left; those that nobody misses go."""
        super().run()
        if self.beside is not None and not self.is_over(self.current):
            self.exchange(self.beside)
        self.drop_needless()

    @cached_property
    def look(self) -> Findings:
        """The law-free look at the re-tuned robot."""
        return looked_freely(self.setup, self.root, by_force=self.force_matters, advance=self.setup.advance)

    def candidates(self, number: int) -> list[FittedFrfs]:
        """The finalists of a search, and a mode with no structure last.

        The first search is where the law-free look points; if nothing there is enough, it is everywhere.
        """
        before = self.current
        found: list[FittedFrfs] = []
        if not number and self.look.explains:
            found = self._searched(number, self.look.worth_trying)
        if not any(self.is_enough(one) or self.is_named(one) for one in found):
            found = self._searched(number, lambda effect, where: True)
        return [before, *found, unstructured_mode(self.setup, before)]

    def _searched(self, number: int, allowed: Callable[[str, str], bool]) -> list[FittedFrfs]:
        doing = f"looking for {'an effect' if not number else 'another effect'}"
        return explanations(
            self.setup,
            self.current,
            _starts(self.current),
            loud=self.force_matters,
            enough=FLOOR_REACHED,
            advance=lambda part: self.setup.advance(doing, part),
            allowed=allowed,
        )

    def compare(self, models: Sequence[FittedFrfs]) -> Comparison[FittedFrfs]:
        """On the postures that were fitted and those held out, and on modes."""
        found = compare_models(models, self.setup.observations, self.setup.seed)
        return found if self.modes is None else self.modes.added_to(found)

    def choose(self, comparison: Comparison[FittedFrfs], number: int) -> int | None:
        """The best, if it gains enough; a mode with no structure is no explanation."""
        before, scores = comparison.models[0], comparison.scores[:-1]
        best = int(np.argmax(scores))
        if number and len(scores) > 1:
            self.beside = comparison.models[1 + int(np.argmax(scores[1:]))]
        chosen = comparison.models[best]
        if best == 0 or comparison.gain(best) < SIGNIFICANT or not _worth(before, chosen, number):
            return None
        second = [k for k in np.argsort(-scores).tolist() if k not in (0, best)]
        tied = set(comparison.tied) - {best}
        self.runner_up = comparison.models[second[0]] if tied and second else None
        return best

    def is_enough(self, model: FittedFrfs) -> bool:
        """Whether it reaches the noise, and every mode has a partner."""
        return over_noise(self.setup, model) <= FLOOR_REACHED and not self.lacking(model)

    def is_named(self, model: FittedFrfs) -> bool:
        """Whether its only effect sits where the law-free look points and takes the larger part.

        With its function free that place explains everything, so that what the model leaves is due to the law
        of the effect and not to another one.
        """
        if len(model.hypothesis.placed) != 1 or not self.look.explains:
            return False
        name, where = model.key
        enough = LARGER_PART if name in CLASSES_OF else NEARLY_ALL
        return self.look.could_be(name, where) and 1 - left(self.setup, self.root, model) >= enough

    def is_over(self, model: FittedFrfs) -> bool:
        """Whether no further effect is looked for."""
        return self.is_enough(model) or self.is_named(model)

    def lacking(self, model: FittedFrfs) -> dict[int, float]:
        """Measured modes that it has none for in at least half the postures: frequencies [Hz]."""
        return {} if self.modes is None else unmatched(self.modes.predicted(model)[0])

    def gaps(self, before: FittedFrfs, after: FittedFrfs) -> Gaps:
        """Of single records."""
        return gaps_of(self.setup, before, after)

    def covariance(self, model: FittedFrfs) -> Float[np.ndarray, "parameter parameter"]:
        """By clusters."""
        return uncertainty(model.hypothesis.space, model.fitted.normal, self.setup.fitted).covariance

    def weighed_gaps(self, model: FittedFrfs) -> tuple[float, float | None]:
        """Of postures fitted, and held out."""
        held = self.setup.held
        return gap_of(self.setup, model, ~held), gap_of(self.setup, model, held) if held.any() else None

    def exchange(self, pair: FittedFrfs) -> None:
        """Look for the first effect again beside the second, where both together are not enough.

        Alone, an effect takes up what it can of another one, and may then sit in the wrong place.
        """
        kept = self.current, list(self.steps), self.refused, self.runner_up
        alone = self._without(pair, pair.hypothesis.keys[0])
        self.steps[:] = [self.describe(self.compare([self.root, alone]), 1)]
        self.current, self.refused = alone, []
        if self.step(1) is None or not self.is_enough(self.current):
            self.current, self.steps, self.refused, self.runner_up = kept

    def drop_needless(self) -> None:
        """Leave out every effect in turn; those that nobody misses go.

        The last one too: what it took away may have been due to a fit of those before it that had not ended.
        """
        for number, step in enumerate(list(self.steps)):
            if len(self.steps) == 1:
                break
            less = self._without(self.current, (step.effect, step.where))
            gain = self.compare([less, self.current]).gain(1)
            if gain < SIGNIFICANT or (number and not _worth(less, self.current, number)):
                self.current = less
                self.steps.remove(step)

    def _without(self, one: FittedFrfs, key: tuple[str, str]) -> FittedFrfs:
        """Fitted again with one effect less."""
        prefix = "{}@{}.".format(*key)
        kept = [not name.startswith(prefix) for name in one.hypothesis.space.names]
        return looked_at(self.setup, one.hypothesis.without(key), one.x[np.array(kept)])


def _starts(before: FittedFrfs) -> list[np.ndarray]:
    """Where a search sets out: at the card, with the effects there are, and where the last fit ended.

    A fit without an effect that is there runs away from the truth.
    """
    count = len(before.hypothesis.base)
    at_card = np.concatenate([np.zeros(count), before.x[count:]])
    return [at_card, before.x] if before.hypothesis.placed else [at_card]


def _worth(before: FittedFrfs, after: FittedFrfs, number: int) -> bool:
    """Whether an effect takes enough away; the first one from the data, or from parameters beyond belief."""
    taken = 1 - after.costs.sum() / max(before.costs.sum(), 1e-300)
    if number:
        return bool(taken >= ANOTHER)
    return bool(taken >= WORTH or (before.prior - after.prior) / 2 >= SIGNIFICANT)
