"""Which explanation do the data prefer, and how surely.

The score of a hypothesis is the logarithm of its evidence by Laplace's method on the postures it was fitted
to, plus the log-likelihood of the postures held out:

    S = −κ/2s² (C_fitted + C_held out) − ½ xᵀPx + ½ Δ − ½ ln det(I + P⁻¹A κ/s²),

C the robust sums of squares, x the parameters from the middle of their prior, P its precision, A the
curvature. Naive sums would give probabilities of 0 or 1 even where they are wrong: residuals of neighbouring
lines are alike as soon as a model is a little off. So κ = 1/(1 + 2Σρ) discounts them by the autocorrelation ρ
of the best hypothesis' residuals, and s² ≥ 1 is its reduced sum of squares. Where C counts for so little,
x lies nearer to belief than where the fit ended, in which n of the N lines count in full: of t C + xᵀPx,
t = κ/s², the least is below that by

    Δ = (1 − t N/n)² xᵀP (P + tA)⁻¹ Px,

as the slope of the sum of squares is that of the prior, reversed, where the fit ended. Probabilities come
from these scores under the Bayesian bootstrap (Rubin, Ann. Statist. 9, 1981) over clusters — everything
between one response and one hammer point in one posture —, as pseudo-BMA+ does (Yao, Vehtari, Simpson and
Gelman, Bayesian Analysis 13, 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.identification import Observations, predict
from flexmodal.identification.descent import prior_cost, robust
from flexmodal.identification.frf_fit import FrfFit, Weighting, residual
from flexmodal.identification.shared import independence
from flexmodal.identification.uncertainty import clusters

DRAWS = 400
"""Of the bootstrap."""
MISSED = 0.05
"""Part of them in which an effect may gain less than it has to."""
_MOST_LAG = 60


@dataclass(frozen=True, eq=False)
class FittedFrfs:
    """A fitted hypothesis with what it leaves."""

    key: tuple[str, str]
    """The effect it adds last; ("none", "") for the robot re-tuned."""
    hypothesis: Hypothesis
    fitted: FrfFit
    """On the postures that are not held out."""
    costs: Float[np.ndarray, " cluster"]
    """Robust sum of squares of each cluster, fitted and held out."""
    occam: float
    """½ ln det(I + P⁻¹A), untempered."""
    strong: int
    """Parameters that the data know better than the prior."""
    parameters: int
    """All of them."""
    predicted: Complex[np.ndarray, "observation line"]
    """For every observation, on all lines."""
    prior: float
    """What the prior adds to the sum of squares."""

    @property
    def x(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates of the hypothesis."""
        return self.fitted.x

    @property
    def cost(self) -> float:
        """Sum of squares of the fit, the prior's among them."""
        return self.fitted.cost

    def nearer(self, temper: float) -> float:
        """Δ: by how much a part of the sum of squares and the prior together are less at their own least.

        Args:
            temper: the part, of all lines.
        """
        if not np.isfinite(self.occam):  # there is no such model
            return 0.0
        share = _share(self.fitted, self.predicted.shape[1])
        root = np.sqrt(_precision(self.hypothesis))
        off = np.where(self.x == 0, 0.0, root) * self.x
        curvature = self.fitted.normal.curvature * share / np.outer(root, root)
        back = np.linalg.solve(np.eye(len(off)) + temper * curvature, off)
        return float((1 - temper * share) ** 2 * off @ back)


def _share(fitted: FrfFit, lines: int) -> float:
    """All lines over those that were fitted, N/n."""
    return lines / max(len(fitted.weighing.lines), 1)


def _precision(hypothesis: Hypothesis) -> Float[np.ndarray, " parameter"]:
    """Of the prior, and a little where there is none."""
    return np.maximum(hypothesis.space.precision, 1e-12)


def fitted_model(
    hypothesis: Hypothesis,
    fitted: FrfFit,
    observations: Observations,
    predicted: Complex[np.ndarray, "observation line"] | None = None,
) -> FittedFrfs:
    """Look at a fit on all observations, the held out ones included.

    Args:
        hypothesis: with its parameters.
        fitted: to some of the observations.
        observations: all of them.
        predicted: its receptances, if they are known better than the hypothesis gives them.
    """
    value = predict(hypothesis, fitted.x, observations) if predicted is None else predicted
    costs = cluster_costs(observations, value, fitted.weighing.floor)
    root = np.sqrt(_precision(hypothesis))
    share = _share(fitted, len(observations.axis))
    curvature = fitted.normal.curvature * share / np.outer(root, root)
    occam = np.inf  # of a model that does not exist there
    if np.isfinite(curvature).all():
        sign, log = np.linalg.slogdet(np.eye(len(root)) + curvature)
        occam = 0.5 * float(log) if sign > 0 else np.inf
    return FittedFrfs(
        key=hypothesis.keys[-1] if hypothesis.placed else (NONE, ""),
        hypothesis=hypothesis,
        fitted=fitted,
        costs=costs,
        occam=occam,
        strong=int(np.sum(np.diag(fitted.normal.curvature) > hypothesis.space.precision)),
        parameters=len(hypothesis.space),
        predicted=value,
        prior=prior_cost(hypothesis.space, fitted.x),
    )


def cluster_costs(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"], floor: float
) -> Float[np.ndarray, " cluster"]:
    """Robust sum of squares of each cluster, at a model error.

    Args:
        observations: what was measured, with its noise.
        predicted: the same by a model.
        floor: model error ε of a residual.
    """
    every = Weighting(floor, np.arange(len(observations.axis)))
    squared = every.weight(observations) * np.abs(residual(predicted, observations.value)) ** 2
    return np.bincount(clusters(observations), weights=robust(squared).sum(axis=1))


def _independent(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"], floor: float
) -> float:
    """κ of a model's residuals."""
    weight = np.sqrt(Weighting(floor, np.arange(len(observations.axis))).weight(observations))
    return independence(weight * residual(predicted, observations.value), _MOST_LAG)


def compare_models(
    models: Sequence[FittedFrfs], observations: Observations, seed: int = 0
) -> Comparison[FittedFrfs]:
    """Compare fitted hypotheses, the first being the one without the new effect.

    Args:
        models: on all observations.
        observations: fitted and held out.
        seed: of the bootstrap.
    """
    totals = np.array([one.costs.sum() for one in models])
    best = int(np.argmin(totals))
    kept = _independent(observations, models[best].predicted, models[0].fitted.weighing.floor)
    lines = max(int(observations.used.sum()), 1)
    temper = kept / max(1.0, totals[best] / lines)
    costs = np.array([one.costs for one in models]) * temper / 2
    occam = np.array([_tempered(one, temper) + (one.prior - one.nearer(temper)) / 2 for one in models])
    draws = np.random.default_rng(seed).dirichlet(np.ones(costs.shape[1]), DRAWS) * costs.shape[1]
    drawn = -costs @ draws.T - occam[:, None]
    return Comparison(models, -costs.sum(axis=1) - occam, drawn, MISSED)


def _tempered(one: FittedFrfs, temper: float) -> float:
    """The Occam factor at the tempered curvature: each well measured parameter loses ½ ln(1/temper)."""
    return one.occam + 0.5 * one.strong * np.log(temper)
