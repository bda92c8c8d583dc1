"""Fit a model to the modes of several postures.

Which mode is which, the parameters and the scales of the scatter are improved in turn: pairs by the
likelihood, parameters by Gauss and Newton, scales one by one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.identification.descent import Normal, descend, prior_cost
from flexmodal.identification.evidence.likelihood.forecast import ModeModel
from flexmodal.identification.evidence.likelihood.laplace import ModalFit, integrated
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood, Pairs
from flexmodal.identification.evidence.likelihood.pairing import paired
from flexmodal.identification.evidence.likelihood.residuals import residuals
from flexmodal.identification.evidence.likelihood.scales import rescaled
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.modal import NO_MODES

COARSE = (0.12, 0.03)
"""Relative errors of frequencies that the first rounds grant a model, so that pairs can find each other."""
ROUNDS = 8
SETTLED = 1e-6


def fit_modes(
    model: ModeModel,
    measured: ModeObservations,
    start: Float[np.ndarray, " parameter"],
    beliefs: Beliefs,
    *,
    pairs: Pairs | None = None,
    scales: Mapping[str, float] | None = None,
    quick: bool = False,
) -> ModalFit:
    """Fit from one start.

    Args:
        model: what is fitted.
        measured: to what.
        start: coordinates to begin at.
        beliefs: priors of the scatter.
        pairs: keep to these while the model is still far off.
        scales: begin with these, and with pairs that fit them: `start` is near.
        quick: a first look only.

    Raises:
        InvalidSystem: no model at the start.
    """
    likelihood = Likelihood(model, measured, beliefs)
    x = np.array(start, dtype=float)
    given = dict(scales) if scales else likelihood.usual()

    def pair(grant: float) -> Pairs:
        return paired(likelihood, likelihood.see(x, slopes=False), given, grant)

    if scales is None:
        for grant in COARSE:
            held = pair(grant) if pairs is None else pairs
            x = _improved(likelihood, x, given, held, grant, 5 if quick else 12)
    pairs = pair(0.0)
    last = -np.inf
    for _ in range(2 if quick else ROUNDS):
        x = _improved(likelihood, x, given, pairs, 0.0, 5 if quick else 20)
        given = rescaled(residuals(likelihood, likelihood.see(x, slopes=False), pairs), given, beliefs)
        pairs = pair(0.0)
        value = likelihood.log_posterior(x, given, pairs)
        if value - last < SETTLED:
            break
        last = value
    return integrated(likelihood, x, given, pairs)


def _improved(
    likelihood: Likelihood,
    x: Float[np.ndarray, " parameter"],
    scales: Mapping[str, float],
    pairs: Pairs,
    grant: float,
    most: int,
) -> Float[np.ndarray, " parameter"]:
    """Parameters after at most so many steps of Gauss and Newton, pairs and scales held."""
    space = likelihood.space

    def cost(at: np.ndarray) -> float:
        try:
            found = residuals(likelihood, likelihood.see(at, slopes=False), pairs)
        except NO_MODES:
            return float("inf")
        return float(found.weights(scales, grant) @ found.away**2) + prior_cost(space, at)

    def equations(at: np.ndarray) -> Normal:
        found = residuals(likelihood, likelihood.see(at, slopes=True), pairs)
        w = found.weights(scales, grant)
        data, none = float(w @ found.away**2), np.zeros((0, len(at)))
        gradient = found.slopes @ (w * found.away) + space.precision * at
        return Normal(
            data + prior_cost(space, at), data, gradient, (found.slopes * w) @ found.slopes.T,
            none, none[:, 0], None,
        )  # fmt: skip

    return descend(space, equations, cost, x, most=most, settled=1e-7).x
