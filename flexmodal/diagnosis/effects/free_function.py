"""What a law-free look found at a place: functions of frequency, from which fits may set out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float


@dataclass(frozen=True, eq=False)
class FreeFunction:
    """Functions of a port that are the same in all postures, and where it was found to sit."""

    frequency: Float[np.ndarray, " line"]
    """[Hz]"""
    value: Complex[np.ndarray, "function line"]
    """In the unit of the port; of a body's, in the plane or in space, the dynamic stiffness [N/m] along the
    link and across it, the upper triangle row by row."""
    geometry: Mapping[str, float]
    """Parameters of the place."""
    fitted: Float[np.ndarray, " known"]
    """Coordinates of what is believed, as fitted beside it."""
    information: Complex[np.ndarray, "line function function"] | None = None
    """How well they are known, each line by itself: the inverse of their covariance; None if nobody says."""
    turns: bool = False
    """Whether they are of turns too, three in space and one in the plane, behind those of motions."""

    @property
    def tensor(self) -> Complex[np.ndarray, "line way way"]:
        """The functions as a symmetric matrix."""
        count = round((np.sqrt(8 * len(self.value) + 1) - 1) / 2)
        found = np.zeros((len(self.frequency), count, count), dtype=complex)
        row, column = np.triu_indices(count)
        found[:, row, column] = found[:, column, row] = self.value.T
        return found
