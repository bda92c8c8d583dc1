"""What a selection comes to: the first and the last model on everything that was measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.outcome import Gaps, Region
from flexmodal.diagnosis.selection.comparison import M
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.setup import Setup


@dataclass(frozen=True, eq=False)
class Conclusion(Generic[M]):
    """The first and the last model on everything that was measured, what was held out included."""

    before: M
    after: M
    gaps: Gaps
    disagreement: tuple[Region, ...]
    remaining: tuple[Region, ...]
    covariance: Float[np.ndarray, "parameter parameter"]
    """Of the last model's coordinates."""
    over_noise: float | None
    """Distance of the last model from the measurement, over that of the noise; None where scatter is inferred
    along, so that there is no such figure."""
    reached: Answer
    """Whether that is noise."""
    setup: Setup | None = None
    """The test as it was set up by everything that was measured; None of modes alone."""

    @property
    def deviation(self) -> Float[np.ndarray, " parameter"]:
        """Standard errors of the last model's coordinates."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
