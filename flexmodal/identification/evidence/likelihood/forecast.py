"""The modes that a model predicts in each posture, with their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.identification.evidence.likelihood.spectrum import spectrum
from flexmodal.identification.evidence.measured_modes import Place
from flexmodal.structure import ParameterSpace
from flexmodal.structure.structure import Structure

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

    @staticmethod
    def none(places: int, parameters: int) -> Forecast:
        """No modes at all, seen at so many places.

        Args:
            places: how many.
            parameters: how many.
        """
        empty, slopes = np.zeros(0), np.zeros((parameters, 0))
        shape, turned = np.zeros((places, 0), complex), np.zeros((parameters, places, 0), complex)
        return Forecast(empty, empty, shape, slopes, slopes, turned)

    @property
    def structured(self) -> int:
        """How many of the modes have a structure."""
        return int(np.sum(~np.isnan(self.shape[0])))


@runtime_checkable
class ModeModel(Protocol):
    """Anything that predicts the modes of several postures from the coordinates of a parameter space."""

    @property
    def space(self) -> ParameterSpace:
        """What they depend on."""
        ...

    @property
    def key(self) -> tuple[str, str]:
        """What it is called: a name and a place."""
        ...

    def forecasts(
        self, x: Float[np.ndarray, " parameter"], places: Sequence[Place], *, slopes: bool
    ) -> list[Forecast]:
        """Modes of every posture, seen at these places.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            places: point and direction of each response.
            slopes: whether derivatives are wanted.
        """
        ...


def forecasts_of(structures: Sequence[Structure], names: tuple[str, ...], count: int) -> list[Forecast]:
    """Modes of structures, one for each posture.

    Args:
        structures: seen at the places that count, with derivatives where there are names.
        names: parameters to differentiate along, the first of all.
        count: how many parameters there are; the derivatives along the others are 0.

    Raises:
        InvalidSystem: a mass matrix that is not positive definite.
    """
    made, own, found = spectrum(structures, names), len(names), []
    for number, n in enumerate(made.count):
        pole, seen = made.pole[number, :n], made.seen[number, :, :n]
        size = np.abs(pole)
        ratio = np.maximum(-pole.real / size, LEAST_DAMPING)
        turned = np.zeros((count, len(seen), n), dtype=complex)
        fall, loss = np.zeros((2, count, n))
        part = made.pole_slope[number, :, :n] / pole
        fall[:own], loss[:own] = part.real, part.imag * pole.imag / size / ratio
        turned[:own] = made.seen_slope[number, :, :, :n]
        found.append(Forecast(np.log(size / (2 * np.pi)), np.log(ratio), seen, fall, loss, turned))
    return found


def joined(parts: Sequence[Forecast]) -> Forecast:
    """Modes of one posture, side by side."""
    return Forecast(
        *(np.concatenate([getattr(one, name) for one in parts], axis=-1) for name in Forecast.__annotations__)
    )
