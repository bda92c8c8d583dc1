"""How a link gives: anything clamped at one end whose deflection and slope follow from a few coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float


@runtime_checkable
class Flexure(Protocol):
    """What the assembly asks of a bending or twisting link."""

    @property
    def length(self) -> float:
        """From the clamp to the far end [m]."""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "kept kept"]:
        """Stiffness over its coordinates."""

    def shape(self, place: float) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, " kept"]]:
        """Deflection and slope at a distance from the clamp [m], each a row over its coordinates."""


@dataclass(frozen=True, eq=False)
class Hinges:
    """Stiff pieces on hinges with a spring each; one coordinate a hinge, the angle it opens [rad]."""

    length: float
    """[m]"""
    places: tuple[float, ...]
    """Of the hinges, from the clamp [m]."""
    springs: tuple[float, ...]
    """[N·m/rad]"""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "hinge hinge"]:
        """The springs, each on its own angle."""
        return np.diag(self.springs)

    def shape(self, place: float) -> tuple[Float[np.ndarray, " hinge"], Float[np.ndarray, " hinge"]]:
        """Deflection and slope at a distance from the clamp [m], each a row over the angles."""
        lever = place - np.array(self.places)
        return np.maximum(lever, 0.0), np.where(lever >= 0, 1.0, 0.0)


@dataclass(frozen=True, eq=False)
class Shaft:
    """Twist that grows evenly along the link; its coordinate is the angle at the far end [rad]."""

    length: float
    """[m]"""
    spring: float
    """G J / length [N·m/rad]."""

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "1 1"]:
        """Of the twist at the far end."""
        return np.array([[self.spring]])

    def shape(self, place: float) -> tuple[Float[np.ndarray, " 1"], Float[np.ndarray, " 1"]]:
        """No deflection, and the twist at a distance from the clamp [m]."""
        return np.zeros(1), np.array([place / self.length])
