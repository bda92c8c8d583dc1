"""How sure the parameters of a fit are.

Lines of one FRF share their errors: where the hammer fell, how it was tilted, leakage. Counting lines as
independent would give intervals several times too narrow. So the covariance is the sandwich of generalised
least squares with clusters (Liang and Zeger, Biometrika 73, 1986),

    cov = A⁻¹ (Σ_c g_c g_cᵀ · G/(G − 1) + P) A⁻¹,    A = Σ JᵀWJ + P,

with g_c the gradient summed over one cluster — all that was measured between one response and one hammer
point in one posture —, G their number and P the prior's precision. Where there are few clusters for the
parameters, the interval is widened to Student's t.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.identification.frf_fit import Normal
from flexmodal.identification.observations import Observations
from flexmodal.identification.parameter import ParameterSpace

KNOWN = 0.5
"""A coordinate is identified if the data leave less than this part of its prior's standard deviation."""
TIED = 0.9
"""Correlation from which two parameters are reported as a pair."""


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariance of the coordinates of a fit."""

    space: ParameterSpace
    covariance: Float[np.ndarray, "parameter parameter"]
    freedom: float
    """Degrees of freedom of Student's t."""
    information: Float[np.ndarray, "parameter parameter"]
    """Of the data alone: JᵀWJ."""

    @cached_property
    def deviation(self) -> Float[np.ndarray, " parameter"]:
        """Standard errors of the coordinates."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @cached_property
    def identified(self) -> tuple[str, ...]:
        """Parameters that the data tell: their error is well below the prior's."""
        return tuple(
            p.name
            for p, d in zip(self.space, self.deviation, strict=True)
            if d < KNOWN * min(p.deviation, 2.0)
        )

    @cached_property
    def correlated(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of parameters with a correlation beyond `TIED`, the closest first."""
        size = np.where(self.deviation > 0, self.deviation, 1.0)
        r = self.covariance / np.outer(size, size)
        names = self.space.names
        found = [
            (names[i], names[j], float(r[i, j]))
            for i in range(len(names))
            for j in range(i + 1, len(names))
            if abs(r[i, j]) >= TIED
        ]
        return tuple(sorted(found, key=lambda pair: -abs(pair[2])))

    def interval(
        self, x: Float[np.ndarray, " parameter"], level: float = 0.95
    ) -> Float[np.ndarray, "2 parameter"]:
        """Confidence interval of each coordinate."""
        from scipy.stats import t

        reach = float(t.ppf((1 + level) / 2, self.freedom)) * self.deviation
        return np.array([x - reach, x + reach])


def clusters(observations: Observations) -> Int[np.ndarray, " observation"]:
    """Which observations share their errors: those of one posture, response and hammer point."""
    key = np.column_stack([observations.posture, observations.response, observations.reference])
    _, cluster = np.unique(key, axis=0, return_inverse=True)
    return cluster.ravel()


def uncertainty(space: ParameterSpace, normal: Normal, observations: Observations) -> Uncertainty:
    """Covariance at the end of a fit."""
    cluster = clusters(observations)
    count = int(cluster.max()) + 1
    summed = np.zeros((count, len(space)))
    np.add.at(summed, cluster, normal.scores)
    prior = np.diag(space.precision)
    inverse = np.linalg.pinv(normal.curvature + prior, hermitian=True)
    small = count / max(count - 1, 1)
    meat = small * summed.T @ summed + prior
    return Uncertainty(space, inverse @ meat @ inverse, float(max(count - 1, 1)), normal.curvature)
