"""How much a measurement is expected to tell of which explanation is right.

Fitted models predict ln α with what is unsure of their parameters, to first order. If one of two is right,
their difference Δ is measured under the errors of both and the noise σ,

    I = ½ Δᵀ (J₁C₁J₁ᵀ + J₂C₂J₂ᵀ + σ²)⁻¹ Δ  [nat],

over real and imaginary parts of all lines: the expected logarithm of the odds between them (Kullback and
Leibler's divergence of two normal densities of one covariance). A point that hardly moves has a noisier FRF:
σ² grows with the square of what points move typically over what it moves.

Of several explanations with weights w what is learnt is at least

    −Σᵢ wᵢ ln Σⱼ wⱼ exp(−Iᵢⱼ/4)  [nat]

(Kolchinsky and Tracey, Entropy 19, 361, 2017, with Bhattacharyya's distance, I/4 here). What holds that back
is the doubt Σᵢ wᵢ Σ_{j≠i} wⱼ exp(−Iᵢⱼ/4), whose logarithm goes on telling measurements apart where each would
tell the explanations apart: the pair that is hardest to tell rules it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.identification.frf_fit import residual


@dataclass(frozen=True, eq=False)
class Predicted:
    """What a fitted model predicts for several measurements."""

    value: Complex[np.ndarray, "row line"]
    slopes: Complex[np.ndarray, "parameter row line"]
    """Of ln(value)."""
    covariance: Float[np.ndarray, "parameter parameter"]

    def keeping(self, some: Bool[np.ndarray, " row"]) -> Predicted:
        """For some of the measurements."""
        return replace(self, value=self.value[some], slopes=self.slopes[:, some])


def information(one: Predicted, other: Predicted, noise: float) -> Float[np.ndarray, " row"]:
    """Expected logarithm of the odds between two models by each measurement [nat]; 0 where nothing moves.

    Args:
        one: predictions of a model.
        other: of another.
        noise: relative, of a line at a point that moves as points typically do.
    """
    size = np.minimum(np.abs(one.value), np.abs(other.value))
    moves = size.min(axis=1) > 0
    found = np.zeros(len(size))
    if not moves.any():
        return found
    away, size = residual(one.value, other.value)[moves], size[moves]
    delta = np.concatenate([away.real, away.imag], axis=1)
    spread = np.zeros((len(size), delta.shape[1], delta.shape[1]))
    diagonal = np.arange(delta.shape[1])
    ratio = np.median(size, axis=0) / size
    spread[:, diagonal, diagonal] = np.tile(noise**2 / 2 * (1 + ratio**2), 2)
    for model in (one, other):
        slopes = model.slopes[:, moves]
        j = np.concatenate([slopes.real, slopes.imag], axis=2).transpose(1, 2, 0)
        spread += j @ model.covariance @ j.transpose(0, 2, 1)
    found[moves] = 0.5 * np.sum(delta * np.linalg.solve(spread, delta[..., None])[..., 0], axis=1)
    return found


def doubt_left(
    models: Sequence[Predicted], weights: Sequence[float], noise: float
) -> tuple[Float[np.ndarray, " row"], Float[np.ndarray, " row"]]:
    """Ln of the doubt that each measurement leaves, and the information between the first two [nat].

    Args:
        models: predictions of two models or more.
        weights: their probabilities, together 1.
        noise: see `information`.
    """
    pairs = list(combinations(range(len(models)), 2))
    each = np.array([information(models[i], models[j], noise) for i, j in pairs])
    share = np.log([2 * weights[i] * weights[j] for i, j in pairs])
    return np.logaddexp.reduce(share[:, None] - each / 4, axis=0), each[0]
