"""Forward selection: effects added one after the other, until nothing significant is left."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Gaps, Step, Weighed
from flexmodal.diagnosis.selection.comparison import Comparison, M

MOST_STEPS = 2
"""Effects added at most: more of them explain anything."""
SIGNIFICANT = 8.0
"""Score that an effect has to gain [nat]."""
STEP = 1e-5
"""Of the differences along parameters."""


@dataclass(frozen=True, eq=False)
class Round(Generic[M]):
    """One comparison."""

    comparison: Comparison[M]
    chosen: int | None
    """Number of the model that was added; None where none was."""


class ForwardSelection(ABC, Generic[M]):
    """One run; keeps what it has found so far. What depends on the kind of data is left open."""

    def __init__(self, root: M) -> None:
        """Begin.

        Args:
            root: the robot re-tuned, nothing added.
        """
        self.root = self.current = root
        self.rounds: list[Round[M]] = []
        self.steps: list[Step] = []
        self.refused: list[Weighed] = []
        """What was compared last and not added."""

    @abstractmethod
    def candidates(self, number: int) -> list[M]:
        """The current model, and what might be added to it."""

    @abstractmethod
    def compare(self, models: Sequence[M]) -> Comparison[M]:
        """Their scores."""

    @abstractmethod
    def choose(self, comparison: Comparison[M], number: int) -> int | None:
        """The model that is added, if any."""

    @abstractmethod
    def is_enough(self, model: M) -> bool:
        """Whether nothing is left to be explained."""

    def is_over(self, model: M) -> bool:
        """Whether no further effect is looked for."""
        return self.is_enough(model)

    @abstractmethod
    def gaps(self, before: M, after: M) -> Gaps:
        """Of a pair of models."""

    @abstractmethod
    def covariance(self, model: M) -> Float[np.ndarray, "parameter parameter"]:
        """Of the coordinates of its hypothesis."""

    @abstractmethod
    def weighed_gaps(self, model: M) -> tuple[float, float | None]:
        """Its gap on what it was fitted to, and on what was held out."""

    def run(self) -> None:
        """Add effects until nothing significant is left."""
        for number in range(MOST_STEPS):
            if number and self.is_over(self.current):
                break
            if self.step(number) is None:
                break

    def step(self, number: int) -> Step | None:
        """One effect more, if one is needed."""
        comparison = self.compare(self.candidates(number))
        chosen = self.choose(comparison, number)
        self.rounds.append(Round(comparison, chosen))
        if chosen is None:
            self.refused = [self.weighed(comparison, k) for k in comparison.order]
            return None
        self.current = comparison.models[chosen]
        self.steps.append(self.describe(comparison, chosen))
        return self.steps[-1]

    def describe(self, comparison: Comparison[M], chosen: int) -> Step:
        """What a step added, how large it is and how surely, and what it was compared with."""
        model = comparison.models[chosen]
        parameters, units, errors = effect_parameters(
            model.hypothesis, model.key, model.x, self.covariance(model)
        )
        ties = [k for k in comparison.tied if k != chosen]
        others = {k: self.weighed(comparison, k) for k in comparison.order if k != chosen}
        return Step(
            effect=model.key[0],
            where=model.key[1],
            parameters=parameters,
            units=units,
            uncertainty=errors,
            confidence=float(comparison.probability[chosen]),
            gaps=self.gaps(comparison.models[0], model),
            alternatives=tuple(others.values()),
            ties=tuple((others[k].effect, others[k].where) for k in ties),
        )

    def weighed(self, comparison: Comparison[M], number: int) -> Weighed:
        """A model of a comparison, in figures."""
        model = comparison.models[number]
        effect, where = model.key if number else (NONE, "")
        return Weighed(
            effect,
            where,
            *self.weighed_gaps(model),
            float(comparison.scores[number] - comparison.scores.max()),
            float(comparison.probability[number]),
            model.parameters - comparison.models[0].parameters,
        )


def effect_parameters(
    hypothesis: Hypothesis,
    key: tuple[str, str],
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
) -> tuple[dict[str, float], dict[str, str], dict[str, float]]:
    """Physical parameters of an effect, their units and standard errors, by finite differences.

    Args:
        hypothesis: with the effect.
        key: name and place of the effect.
        x: coordinates.
        covariance: of these.
    """
    space, context = hypothesis.space, hypothesis.context
    placed = next(one for one in hypothesis.placed if one.key == key)
    own = {p.name: p.unit for p in placed.effect.parameters(context, placed.where)}

    def physical(at: np.ndarray) -> Mapping[str, float]:
        values = hypothesis.values_of(placed, space.values(at))
        found = placed.effect.physical(context, placed.where, values)
        return {k: v for k, v in found.items() if k in own or "." not in k}

    here = physical(x)
    middle = np.array(list(here.values()))
    slopes = np.array(
        [(np.array(list(physical(x + STEP * unit).values())) - middle) / STEP for unit in np.eye(len(x))]
    ).T
    errors = np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", slopes, covariance, slopes), 0.0))
    units = {name: placed.effect.units.get(name, own.get(name, "")) for name in here}
    return dict(here), units, dict(zip(here, errors.tolist(), strict=True))
