"""Modal parameters that somebody identified, one row for each place and mode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several


@dataclass(frozen=True, eq=False, repr=False)
class ModeTable(Shown):
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
    frequency_error: Float[np.ndarray, " row"] | None = None
    """Standard error of the natural frequency [Hz]; None where the table has none."""
    damping_error: Float[np.ndarray, " row"] | None = None
    """Of the damping ratio."""
    amplitude_error: Float[np.ndarray, " row"] | None = None
    """Of the amplitude's size."""

    def _facts(self) -> Mapping[str, object]:
        return {"": f"{len(self)} rows", "postures": several(sorted(set(self.posture.tolist())))}

    def to_pandas(self) -> Any:
        """The rows as a table.

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        return pandas.DataFrame(
            {one.name: getattr(self, one.name) for one in fields(self) if getattr(self, one.name) is not None}
        )

    def __len__(self) -> int:
        """How many rows there are."""
        return len(self.flag)
