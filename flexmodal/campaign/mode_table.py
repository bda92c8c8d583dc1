"""Modal parameters that somebody identified, one row for each place and mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int


@dataclass(frozen=True, eq=False)
class ModeTable:
    """The rows of `modes.csv`; NaN where a number is missing from the file."""

    posture: Int[np.ndarray, " row"]
    response: Int[np.ndarray, " row"]
    """Point ids."""
    reference: Int[np.ndarray, " row"]
    """Point ids."""
    mode: Int[np.ndarray, " row"]
    natural_frequency: Float[np.ndarray, " row"]
    """[Hz]."""
    damping_ratio: Float[np.ndarray, " row"]
    amplitude: Complex[np.ndarray, " row"]
    """Amplitude multiplier of the mobility residue form; both parts NaN where missing."""
    flag: tuple[str, ...]
    """Remarks on the row, `field:mark` joined by semicolons; empty without one."""

    def __len__(self) -> int:
        """How many rows there are."""
        return len(self.flag)
