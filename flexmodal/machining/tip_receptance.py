"""What every method asks of the tip of a cutter."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from jaxtyping import Complex, Float


class TipReceptance(ABC):
    """Anything that gives the 3 × 3 receptance of the tip over frequency."""

    @abstractmethod
    def receptance(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, "line 3 3"]:
        """Displacement along x, y, z per force along x, y, z of the cut, at ascending frequencies [m/N]."""

    @property
    @abstractmethod
    def lines(self) -> Float[np.ndarray, " line"]:
        """Frequencies dense enough to show every resonance; chatter is sought between the ends [Hz]."""

    @property
    @abstractmethod
    def resonances(self) -> Float[np.ndarray, " few"]:
        """A few frequencies about each resonance, ascending [Hz]."""

    @property
    @abstractmethod
    def highest(self) -> float:
        """Beyond this frequency nothing is known of the tip; infinite for a model [Hz]."""
