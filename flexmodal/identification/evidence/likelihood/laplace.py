"""An explanation at its best, with its evidence by Laplace's integral over parameters and scales together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.likelihood.forecast import Forecast, ModeModel
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood, Pairs
from flexmodal.identification.evidence.likelihood.residuals import Residuals, residuals
from flexmodal.identification.evidence.likelihood.scales import scale_term
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations


@dataclass(frozen=True, eq=False)
class ModalFit:
    """An explanation at its best."""

    model: ModeModel
    measured: ModeObservations
    beliefs: Beliefs
    x: Float[np.ndarray, " parameter"]
    scales: Mapping[str, float]
    """Logarithms of the scales: frequency, damping, `shape.NUMBER`."""
    pairs: Pairs
    log_posterior: float
    evidence: float
    """ln of the evidence [nat]."""
    covariance: Float[np.ndarray, "parameter parameter"]
    """Of x, scales at their best."""
    forecasts: tuple[Forecast, ...]
    """Of each posture, with slopes."""


def integrated(
    likelihood: Likelihood,
    x: Float[np.ndarray, " parameter"],
    scales: Mapping[str, float],
    pairs: Pairs,
) -> ModalFit:
    """The fit whose posterior is highest at x and these scales.

    Args:
        likelihood: of the measured modes.
        x: coordinates of the parameters, 0 at the card's values.
        scales: logarithms of the scales of the scatter.
        pairs: number of the model's mode for each measured one, −1 for none.

    Raises:
        InvalidSystem: no model there.
    """
    seen = likelihood.see(x, slopes=True)
    bend = hessian(likelihood, residuals(likelihood, seen, pairs), scales)
    posterior = likelihood.log_likelihood(seen, scales, pairs) + likelihood.log_prior(x, scales)
    known = np.concatenate([likelihood.space.precision > 0, np.ones(len(scales), dtype=bool)])
    values = np.maximum(np.linalg.eigvalsh(bend[np.ix_(known, known)]), 1e-9)
    evidence = posterior - 0.5 * float(np.sum(np.log(values / (2 * np.pi))))
    size = len(likelihood.space)
    return ModalFit(
        likelihood.model, likelihood.measured, likelihood.beliefs, x, dict(scales), pairs, posterior,
        evidence, np.linalg.pinv(bend[:size, :size], hermitian=True), tuple(seen),
    )  # fmt: skip


def hessian(
    likelihood: Likelihood, found: Residuals, scales: Mapping[str, float]
) -> Float[np.ndarray, "coordinate coordinate"]:
    """Of minus the log-posterior over parameters and scales, Gauss–Newton in the parameters.

    Args:
        likelihood: of the measured modes.
        found: residuals of the pairs, with their derivatives.
        scales: logarithms of the scales of the scatter.
    """
    size, names, step = len(likelihood.space), list(scales), 1e-4
    w = found.weights(scales, 0.0)
    total = np.zeros((size + len(names), size + len(names)))
    total[:size, :size] = (found.slopes * w) @ found.slopes.T + np.diag(likelihood.space.precision)
    for k, name in enumerate(names, start=size):
        at = scales[name]
        around = [scale_term(found, likelihood.beliefs, name, at + d) for d in (-0.05, 0.0, 0.05)]
        total[k, k] = max(-(around[0] - 2 * around[1] + around[2]) / 0.05**2, 1e-3)
        moved = found.weights({**scales, name: at + step}, 0.0)
        total[k, :size] = total[:size, k] = found.slopes @ ((moved - w) / step * found.away)
    return total
