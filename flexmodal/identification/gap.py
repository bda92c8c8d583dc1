"""The gap between model and measurement, as the file formats define it.

Root mean square over FRF lines of |ln(model / measured)|, over the lines inside the band with coherence 0.8
or more, each weighted by its coherence; a line where one of them is exactly zero counts as 10. The noise
floor beside it is the campaign's own, see `flexmodal.campaign.noise`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.campaign.noise import ZERO, expected_log_square
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.observations import Observations


@dataclass(frozen=True)
class Gap:
    """How far a model is from the records, and how far their noise alone would put it."""

    value: float
    noise_floor: float

    @property
    def over_floor(self) -> float:
        """The gap as a multiple of the noise floor."""
        return self.value / self.noise_floor if self.noise_floor > 0 else float("inf")


def gap(
    observations: Observations,
    predicted: Complex[np.ndarray, "observation line"],
    keep: Bool[np.ndarray, " observation"] | None = None,
) -> Gap:
    """Gap of predicted receptances.

    Args:
        observations: measured receptances; the gap is of their single records.
        predicted: for every observation, on every line [m/N].
        keep: observations to look at; all by default.
    """
    rows = np.arange(len(observations.records))
    if keep is not None:
        rows = rows[keep[observations.of_record]]
    records, owner = observations.records, observations.of_record[rows]
    weight = records.weight[rows]
    total = float(weight.sum())
    if not total > 0:
        return Gap(float("nan"), float("nan"))
    # What is zero but for rounding counts as zero.
    squared = np.minimum(np.abs(residual(predicted[owner], records.value[rows])), ZERO) ** 2
    noise = observations.noise[rows]
    return Gap(
        float(np.sqrt((weight * squared).sum() / total)), float(np.sqrt((weight * noise).sum() / total))
    )


def share(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> Float[np.ndarray, "observation line"]:
    """|ln(model / measured)|² of the averaged receptances; 0 on lines that are not used.

    Args:
        observations: what was measured.
        predicted: receptances [m/N].
    """
    found = np.abs(residual(predicted, observations.value)) ** 2
    return np.where(observations.used, found, 0.0)


def over_noise(observations: Observations, predicted: Complex[np.ndarray, "observation line"]) -> float:
    """Root mean square of |ln(model / measured)| over that of the noise, on the lines that a fit uses.

    Other than the gap it leaves out what is noise: a point that stands still in the model, at which the
    sensor hears little but its own amplifier. 1 for a perfect model; NaN where no line is used.

    Args:
        observations: what was measured.
        predicted: receptances [m/N].
    """
    used = observations.used
    away = float(share(observations, predicted)[used].sum())
    noise = float(expected_log_square(observations.variance[used]).sum())
    return float(np.sqrt(away / noise)) if noise > 0 else float("nan")
