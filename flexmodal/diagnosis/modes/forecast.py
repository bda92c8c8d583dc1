"""The modes that an explanation predicts in each posture, with their derivatives.

An explanation is the robot with some effects, and perhaps modes with no structure behind them: a natural
frequency and a damping ratio that are the same in every posture, and a shape that says nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modes.spectrum import spectrum
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.identification.evidence.measured_modes import Place
from flexmodal.structure import Parameter, ParameterSpace

USUAL_DAMPING, DAMPING_SPREAD = 0.05, 1.0
"""Damping ratio of a mode that nothing is known of, and standard deviation of its logarithm."""
LEAST_DAMPING = 1e-6


@dataclass(frozen=True, eq=False)
class Forecast:
    """Modes of one posture that oscillate, by natural frequency, those without structure last."""

    log_frequency: Float[np.ndarray, " mode"]
    log_damping: Float[np.ndarray, " mode"]
    shape: Complex[np.ndarray, "place mode"]
    """What each response place sees; NaN for a mode without structure."""
    frequency_slope: Float[np.ndarray, "parameter mode"]
    damping_slope: Float[np.ndarray, "parameter mode"]
    shape_slope: Complex[np.ndarray, "parameter place mode"]


@dataclass(frozen=True, eq=False)
class Explanation:
    """A robot with effects and modes without structure, as a model of modes."""

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

        Raises:
            InvalidSystem: a mass matrix that is not positive definite.
        """
        count = len(self.space) if slopes else 0
        inner = x[: len(self.hypothesis.space)]
        names = self.hypothesis.space.names if slopes else ()
        structures = self.hypothesis.structures(inner, places, (), slopes=slopes)
        made = spectrum(structures, names)
        own, found = len(names), []
        for number, n in enumerate(made.count):
            pole = made.pole[number, :n]
            size = np.abs(pole)
            ratio = np.maximum(-pole.real / size, LEAST_DAMPING)
            turned = np.zeros((count, len(places), n), dtype=complex)
            fall, loss = np.zeros((2, count, n))
            part = made.pole_slope[number, :, :n] / pole
            fall[:own], loss[:own] = part.real, part.imag * pole.imag / size / ratio
            turned[:own] = made.seen_slope[number, :, :, :n]
            seen = made.seen[number, :, :n]
            found.append(Forecast(np.log(size / (2 * np.pi)), np.log(ratio), seen, fall, loss, turned))
        return [self._with_free(one, x, count) for one in found]

    def _with_free(self, one: Forecast, x: np.ndarray, count: int) -> Forecast:
        if not self.free:
            return one
        values, index = self.space.values(x), self.space.index
        parts = [one]
        for number in range(self.free):
            frequency, damping = (
                f"{UNSTRUCTURED}.{number + 1}.{kind}" for kind in ("frequency", "damping_ratio")
            )
            fall, loss = np.zeros((2, count, 1))
            if count:
                fall[index[frequency]] = loss[index[damping]] = 1.0
            parts.append(
                Forecast(
                    np.log([values[frequency]]), np.log([values[damping]]),
                    np.full((len(one.shape), 1), np.nan, dtype=complex), fall, loss,
                    np.zeros((count, len(one.shape), 1), dtype=complex),
                )
            )  # fmt: skip
        return Forecast(
            *(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in Forecast.__annotations__)
        )
