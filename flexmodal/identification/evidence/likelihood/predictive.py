"""A model of modes looked at away from its fit: with other modes, with unseen ones, or not fitted yet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.likelihood.fit import COARSE
from flexmodal.identification.evidence.likelihood.forecast import ModeModel
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood
from flexmodal.identification.evidence.likelihood.pairing import paired
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations


def granted(model: ModeModel, measured: ModeObservations, x: Float[np.ndarray, " parameter"]) -> float:
    """Ln likelihood over that of peaks from anywhere, of a model that is granted to be far off.

    Args:
        model: of modes.
        measured: the modes that were measured.
        x: coordinates of the parameters, 0 at the card's values.

    Raises:
        InvalidSystem: no model there.
    """
    likelihood = Likelihood(model, measured, Beliefs(shapes=False))
    seen, scales = likelihood.see(x, slopes=False), likelihood.usual()
    pairs = paired(likelihood, seen, scales, COARSE[0])
    total = 0.0
    for number, here in enumerate(measured.here):
        for k in here:
            if pairs[k] >= 0:
                total += float(likelihood.gains(k, seen[number], scales, COARSE[0])[pairs[k]])
    return total


def predictive(fit: ModalFit) -> float:
    """Ln of the density of modes that a fit did not see, over that of peaks from anywhere.

    What is unsure of its parameters is included; they enter by their covariance, to first order.
    """
    likelihood = Likelihood(fit.model, fit.measured, fit.beliefs)
    total = 0.0
    for here, seen in zip(fit.measured.here, fit.forecasts, strict=True):
        if not here:
            continue
        slopes = (seen.frequency_slope, seen.damping_slope)
        spread = np.array([np.einsum("km,kl,lm->m", s, fit.covariance, s) for s in slopes])
        total += sum(likelihood.overlooked(seen, m) for m in range(len(seen.log_frequency)))
        total += sum(
            float(likelihood.gains(k, seen, fit.scales, 0.0, spread)[fit.pairs[k]])
            for k in here
            if fit.pairs[k] >= 0
        )
    return total


def restricted(fit: ModalFit, measured: ModeObservations, grant: float = 0.0) -> ModalFit:
    """The same parameters and scales looked at with other modes; pairs may be off by `grant` besides.

    Args:
        fit: a fit of modes.
        measured: the modes to look at.
        grant: relative error of frequencies that is granted besides.
    """
    likelihood = Likelihood(fit.model, measured, fit.beliefs)
    seen = likelihood.see(fit.x, slopes=True)
    pairs = paired(likelihood, seen, fit.scales, grant)
    return replace(fit, measured=measured, pairs=pairs, forecasts=tuple(seen))
