"""A hypothesis as a model of measured modes.

Beside the robot and its effects there may be modes with no structure behind them: a natural frequency and a
damping ratio that are the same in every posture, and a shape that says nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.identification.evidence.likelihood.forecast import (
    DAMPING_SPREAD,
    USUAL_DAMPING,
    Forecast,
    forecasts_of,
    joined,
)
from flexmodal.identification.evidence.measured_modes import Place
from flexmodal.structure import Parameter, ParameterSpace


@dataclass(frozen=True, eq=False)
class ModalModel:
    """A robot with effects and modes without structure (`identification`'s `ModeModel`)."""

    hypothesis: Hypothesis
    free: int = 0
    """How many modes without structure."""
    stretch: float = 1.0
    """Factor on the priors of what is added; 1 as the effects have them."""

    @property
    def key(self) -> tuple[str, str]:
        """What it adds last, and where."""
        if self.free:
            return UNSTRUCTURED, ""
        return self.hypothesis.keys[-1] if self.hypothesis.placed else (NONE, "")

    @cached_property
    def space(self) -> ParameterSpace:
        """The robot's parameters, those of effects, those of free modes."""
        low, high = self.hypothesis.context.band
        wide = float(np.log(high / low) / np.sqrt(12))
        found = list(self.hypothesis.space.parameters)
        base = len(self.hypothesis.base)
        if self.stretch != 1:
            trust = {p.name: p.deviation * self.stretch for p in found[base:]}
            found = list(self.hypothesis.space.trusting(trust).parameters)
        for number in range(self.free):
            name = f"{UNSTRUCTURED}.{number + 1}"
            middle = float(np.sqrt(low * high))
            found += [
                Parameter(f"{name}.frequency", "Hz", middle, wide, low, high),
                Parameter(f"{name}.damping_ratio", "", USUAL_DAMPING, DAMPING_SPREAD, 1e-4, 0.9),
            ]
        return ParameterSpace(tuple(found))

    def forecasts(
        self,
        x: Float[np.ndarray, " parameter"],
        places: Sequence[Place],
        *,
        slopes: bool,
    ) -> list[Forecast]:
        """Modes of every posture of the context, seen at these places.

        Args:
            x: coordinates.
            places: points and directions.
            slopes: with derivatives.

        Raises:
            InvalidSystem: a mass matrix that is not positive definite.
        """
        count = len(self.space) if slopes else 0
        names = self.hypothesis.space.names if slopes else ()
        inner = x[: len(self.hypothesis.space)]
        structures = self.hypothesis.structures(inner, places, (), slopes=slopes)
        free = [self._free(x, number, len(places), count) for number in range(self.free)]
        return [joined([one, *free]) for one in forecasts_of(structures, names, count)]

    def _free(self, x: np.ndarray, number: int, places: int, count: int) -> Forecast:
        """A mode without structure."""
        values, index = self.space.values(x), self.space.index
        frequency, damping = (
            f"{UNSTRUCTURED}.{number + 1}.{kind}" for kind in ("frequency", "damping_ratio")
        )
        fall, loss = np.zeros((2, count, 1))
        if count:
            fall[index[frequency]] = loss[index[damping]] = 1.0
        return Forecast(
            np.log([values[frequency]]), np.log([values[damping]]),
            np.full((places, 1), np.nan, dtype=complex), fall, loss,
            np.zeros((count, places, 1), dtype=complex),
        )  # fmt: skip
