"""How sure the parameters of a fit are.

Lines of one FRF share their errors: where the hammer fell, how it was tilted, leakage. Counting lines as
independent would give intervals several times too narrow. So the covariance is the sandwich of generalised
least squares with clusters (Liang and Zeger, Biometrika 73, 1986),

    cov = A⁻¹ (Σ_c g_c g_cᵀ + P) A⁻¹,    A = Σ_c B_c + P,    B_c = J_cᵀ W J_c,

with g_c the gradient summed over one cluster — all that was measured between one sensor's place and one
hammer position in one posture, whatever the sensor's axis —, and P the prior's precision. Residuals of a fit
are smaller than errors, the more so the more one cluster decides: each gradient is enlarged to

    g_c = (1 − B_c A⁻¹)^(−1/2) J_cᵀ W r_c,

which makes the estimate unbiased where lines are independent, and Student's t gets the degrees of freedom
that match its spread (Bell and McCaffrey, Survey Methodology 28, 2002; Pustejovsky and Tipton, Journal of
Business and Economic Statistics 36, 2018). With the prior as one more, exactly known measurement.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.descent import Normal
from flexmodal.identification.observations import Observations
from flexmodal.structure.parameter import ParameterSpace

KNOWN = 0.5
"""A coordinate is identified if the data leave less than this part of its prior's standard deviation."""
TIED = 0.9
"""Correlation from which two parameters are reported as a pair."""
SPENT = 1e-6
"""Smallest part of a direction that other clusters must tell for a residual to say something about it."""


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariance of the coordinates of a fit."""

    space: ParameterSpace
    covariance: Float[np.ndarray, "parameter parameter"]
    freedom: Float[np.ndarray, " parameter"]
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
        """Confidence interval of each coordinate.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            level: probability that it covers the truth.
        """
        from scipy.special import stdtrit

        reach = stdtrit(np.minimum(self.freedom, 1e9), (1 + level) / 2) * self.deviation
        return np.array([x - reach, x + reach])


def clusters(observations: Observations) -> Int[np.ndarray, " observation"]:
    """Which observations share their errors: those of one posture, sensor place and hammer position."""
    key = np.column_stack([observations.posture, observations.response[:, 0], observations.reference])
    _, cluster = np.unique(key, axis=0, return_inverse=True)
    return cluster.ravel()


def uncertainty(space: ParameterSpace, normal: Normal, observations: Observations) -> Uncertainty:
    """Covariance at the end of a fit of FRFs.

    Args:
        space: the parameters.
        normal: equations at the end of the fit, with what each observation adds.
        observations: that were fitted.

    Raises:
        InvalidRequest: normal equations that do not say what each observation adds.
    """
    return clustered(space, normal, clusters(observations))


def clustered(space: ParameterSpace, normal: Normal, cluster: Int[np.ndarray, " observation"]) -> Uncertainty:
    """Covariance at the end of a fit whose observations share their errors within clusters.

    Args:
        space: with priors.
        normal: at the end of the fit, observations apart.
        cluster: number of each observation's.

    Raises:
        InvalidRequest: normal equations that do not say what each observation adds.
    """
    if normal.blocks is None:
        allowed = "normal equations with the observations apart"
        raise InvalidRequest(Fault("call", "normal", "a sum over observations", allowed))
    count, size = int(cluster.max()) + 1, len(space)
    score, block = np.zeros((count, size)), np.zeros((count, size, size))
    np.add.at(score, cluster, normal.scores)
    np.add.at(block, cluster, normal.blocks)
    return sandwich(space, score, block)


def sandwich(
    space: ParameterSpace,
    score: Float[np.ndarray, "cluster parameter"],
    block: Float[np.ndarray, "cluster parameter parameter"],
) -> Uncertainty:
    """Covariance from the gradient and the curvature that each cluster adds.

    Args:
        space: the parameters.
        score: gradient that each cluster of observations adds.
        block: curvature that it adds.
    """
    prior = np.diag(space.precision)
    information = block.sum(axis=0)
    root = _root(information + prior)  # A = root rootᵀ
    inverse_root = np.linalg.inv(root)
    inner = inverse_root @ block @ inverse_root.T
    values, vectors = np.linalg.eigh((inner + np.swapaxes(inner, 1, 2)) / 2)
    grown = np.where(values < 1 - SPENT, 1 / np.sqrt(np.maximum(1 - values, SPENT)), 0.0)
    enlarge = (vectors * grown[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    gradient = (enlarge @ (score @ inverse_root.T)[:, :, None])[:, :, 0]  # root⁻¹ g_c
    prior_part = inverse_root @ prior @ inverse_root.T
    covariance = inverse_root.T @ (gradient.T @ gradient + prior_part) @ inverse_root
    return Uncertainty(space, covariance, _freedom(inverse_root, inner, enlarge, prior_part), information)


def _freedom(
    inverse_root: np.ndarray, inner: np.ndarray, enlarge: np.ndarray, prior_part: np.ndarray
) -> Float[np.ndarray, " parameter"]:
    """Satterthwaite's degrees of freedom of each variance, lines taken as independent.

    The terms of the variance are z_c² with cov(z_c, z_d) = δ w_cᵀS_cw_c − w_cᵀS_cS_dw_d, S = root⁻¹ B root⁻ᵀ.
    """
    found = np.zeros(inverse_root.shape[1])
    for k in range(len(found)):
        a = inverse_root[:, k]  # rootᵀ A⁻¹ e_k
        w = enlarge @ a
        seen = np.einsum("cij,cj->ci", inner, w)
        omega = np.diag(np.einsum("ci,ci->c", w, seen)) - seen @ seen.T
        data, known = float(np.trace(omega)), float(a @ prior_part @ a)
        spread = float(np.sum(omega**2))
        found[k] = (data + known) ** 2 / spread if spread > 0 else np.inf
    return np.maximum(found, 1.0)


def _root(matrix: np.ndarray) -> np.ndarray:
    """R with R Rᵀ = matrix, directions that nothing tells given next to nothing."""
    values, vectors = np.linalg.eigh(matrix)
    return vectors * np.sqrt(np.maximum(values, 1e-14 * max(float(values[-1]), 1e-300)))


def laplace(space: ParameterSpace, normal: Normal, count: int) -> Uncertainty:
    """Covariance of the curvature, for data whose errors are independent and known.

    Where χ² is larger than its degrees of freedom, the errors were too small or the model leaves something
    out, and the part of the data is widened by √(χ²/ν), as is usual for averages (Birge, Phys. Rev. 40,
    1932).

    Args:
        space: with priors.
        normal: at the end of the fit.
        count: how many numbers were fitted.
    """
    prior = np.diag(space.precision)
    inverse = np.linalg.pinv(normal.curvature + prior, hermitian=True)
    spent = float(np.trace(inverse @ normal.curvature))
    freedom = max(count - spent, 1.0)
    wider = max(1.0, float(normal.squared.sum()) / freedom)
    covariance = inverse @ (wider * normal.curvature + prior) @ inverse
    return Uncertainty(space, covariance, np.full(len(space), freedom), normal.curvature)
