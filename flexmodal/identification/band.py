"""What the uncertainty of the parameters makes of a predicted FRF: its error band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.identification.model import FrfModel, predictions
from flexmodal.identification.observations import Observations
from flexmodal.identification.uncertainty import Uncertainty


@dataclass(frozen=True, eq=False)
class Banded:
    """Predicted receptances with the standard error of ln |α|."""

    value: Complex[np.ndarray, "observation line"]
    """[m/N]"""
    error: Float[np.ndarray, "observation line"]

    def reach(self, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end of |α| [m/N]."""
        from scipy.special import ndtri

        factor = np.exp(float(ndtri((1 + level) / 2)) * self.error)
        return np.abs(self.value) / factor, np.abs(self.value) * factor


def banded(
    model: FrfModel,
    x: Float[np.ndarray, " parameter"],
    observations: Observations,
    sure: Uncertainty,
    keep: Bool[np.ndarray, " observation"],
) -> Banded:
    """Predict some observations with their error, to first order: √(∂ ln|α| cov ∂ ln|α|ᵀ).

    Args:
        model: of receptances.
        x: coordinates of the parameters, 0 at the card's values.
        observations: what was measured.
        sure: covariance of the parameters.
        keep: which of the observations.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    some = observations.keeping(keep)
    value = np.zeros(some.value.shape, dtype=complex)
    error = np.zeros(some.value.shape)
    for seen in predictions(model, x, some, slice(None), slopes=True):
        relative = seen.slopes(1 / np.where(seen.value == 0, np.inf, seen.value))[:, :, 0]
        spread = np.einsum("pnl,pq,qnl->nl", relative, sure.covariance, relative)
        value[seen.observations] = seen.value[seen.entry]
        error[seen.observations] = np.sqrt(np.maximum(spread, 0.0))[seen.entry]
    return Banded(value, error)
