"""Sensors as they are, beside what the records say of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float


@dataclass
class Sensor:
    """One accelerometer on its point; made sound, then spoilt by effects."""

    gain: float = 1.0
    """Reading over truth."""
    delay: float = 0.0
    """[s]"""
    turned: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    """Rotation of the sensor on its link, axes of the link."""
    mass: float = 0.0
    """[kg]"""
    range: float = np.inf
    """Where it saturates [m/s²]."""

    def direction(
        self, axes: Float[np.ndarray, "3 3"], nominal: Float[np.ndarray, "3"]
    ) -> Float[np.ndarray, "3"]:
        """World direction that it measures when it is recorded as `nominal`, on a link with these axes.

        Args:
            axes: of the link in the world, column by column.
            nominal: unit vector in the world that the record names.
        """
        return axes @ self.turned @ axes.T @ nominal
