"""How the noise of the FRFs reaches the poles and residues, to first order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.ema.methods.separable import Elimination, Separable, columns_at, solve_scaled, weighted_gram

_NEAR = 9
"""The deviations of so many lines to either side say how noisy a line is."""
_MOST = 0.9
"""Of a line's noise; what is left of more says nothing."""


@dataclass(frozen=True, eq=False)
class Covariances:
    """Of the poles, shared by the FRFs of a group, and of the linear unknowns of each FRF."""

    pole: Float[np.ndarray, "group twomode twomode"]
    """Natural frequency and damping ratio, mode by mode; zero for what was held."""
    linear: Float[np.ndarray, "group frf term term"]


def propagate(
    problem: Separable,
    omega: np.ndarray,
    damping: np.ndarray,
    state: Elimination,
    variance: Float[np.ndarray, "group line frf"],
) -> Covariances:
    """Covariances of a solved problem for noise of this variance (real and imaginary part together).

    With W the weights and V the variances of the real parts, the poles move by H⁻¹ΣⱼKⱼᵀE⊥ᵀW δy and the
    linear unknowns by G⁻¹ΦᵀW δy less what the poles' movement takes; both are linear in the noise. Where
    W = 1/V this is the inverse of the information.

    Args:
        problem: as it was solved.
        omega: natural frequencies at the minimum [rad/s].
        damping: ratios there.
        state: the elimination there.
        variance: E|noise|² of every line.
    """
    columns, count = columns_at(problem, omega, damping)
    noise = weighted_gram(columns, problem.weight**2 * variance / 2)
    inner, cross = state.gram[..., :count, :count], state.gram[..., :count, count:]
    share = solve_scaled(inner, cross)
    identity = np.broadcast_to(np.eye(share.shape[-1]), (*share.shape[:-2], share.shape[-1], share.shape[-1]))
    clear = np.concatenate([-share, identity], axis=-2)
    influence = clear @ state.turn  # [group frf all twomode]: E⊥K
    inverse = _inverse_of_free(state.information, problem.free.ravel())
    middle = np.sum(influence.swapaxes(-1, -2) @ noise @ influence, axis=1)
    pole = inverse @ middle @ inverse
    own = solve_scaled(inner, noise[..., :count, :])  # G⁻¹ΦᵀWVW[Φ E]
    plain = solve_scaled(inner, own[..., :count].swapaxes(-1, -2))
    taken = share @ state.turn
    mixed = own @ influence @ inverse[:, None] @ taken.swapaxes(-1, -2)
    linear = plain - mixed - mixed.swapaxes(-1, -2) + taken @ pole[:, None] @ taken.swapaxes(-1, -2)
    return Covariances(pole, linear)


def _inverse_of_free(information: np.ndarray, free: np.ndarray) -> np.ndarray:
    inverse = solve_scaled(information, np.broadcast_to(np.eye(len(free)), information.shape))
    return np.where(np.outer(free, free), inverse, 0.0)


def noise_of(
    problem: Separable,
    omega: np.ndarray,
    damping: np.ndarray,
    state: Elimination,
    variance: Float[np.ndarray, "group line frf"] | None,
    *,
    by_weight: bool = True,
) -> tuple[Float[np.ndarray, "group line frf"], Float[np.ndarray, " group"]]:
    """Variance of each value as the deviations confirm it, and the degrees of freedom behind it.

    A known variance is taken at its word unless the deviations near a line are larger, as they are round a
    resonance that the model misses by more than its valleys; an unknown one is s²/weight with s² from the
    deviations of each FRF, with the same exception. Deviations are smaller than the noise, the more so where
    few lines decide a mode: near a resonance each counts by what its leverage leaves of it. Those that
    neighbouring lines share (leakage, a mode that the model lacks) count for fewer lines, as their
    autocorrelation says.

    Args:
        problem: what was solved.
        omega: natural frequencies at the minimum [rad/s].
        damping: ratios there.
        state: where.
        variance: of the values, where it is known.
        by_weight: whether the weights say how the noise goes from line to line. Otherwise an unknown
            variance is that of the deviations near each line and nothing else.
    """
    _, lines, frfs = problem.value.shape
    poles = np.count_nonzero(problem.free)
    freedom = 2 * lines - state.linear.shape[-1] - poles / frfs
    weight = np.broadcast_to(problem.weight, problem.value.shape)
    square = np.abs(state.deviation) ** 2
    colour = _colour(np.sqrt(weight) * state.deviation)[:, None, None]
    left = _nearby(np.broadcast_to(1 - leverage(problem, omega, damping, state), square.shape))
    if variance is not None:
        each = variance * np.maximum(_nearby(square / variance) / left, 1.0)
    elif by_weight:
        each = np.mean(weight * square, axis=1, keepdims=True) * (2 * lines / max(freedom, 1)) / weight
        each = each * np.maximum(_nearby(square / each) / left, 1.0)
    else:
        each = _nearby(square) / left
    return each * colour, np.full(len(problem.value), max(freedom, 1) * frfs)


def leverage(
    problem: Separable, omega: np.ndarray, damping: np.ndarray, state: Elimination
) -> Float[np.ndarray, "group line frf"]:
    """Part of each line's noise that the fit takes up: half the trace of its block of the hat matrix.

    Of the linear unknowns w φᵀG⁻¹φ, and of the poles w kᵀH⁻¹k, k what their movement changes beyond these
    (Cook and Weisberg, Residuals and Influence in Regression, section 2.1). Its sum over lines and FRFs is
    half the number of unknowns. Kept below one by `_MOST`.

    Args:
        problem: what was solved.
        omega: natural frequencies at the minimum [rad/s].
        damping: ratios there.
        state: where.
    """
    columns, count = columns_at(problem, omega, damping)
    flat = np.concatenate([columns.real, columns.imag], axis=1)[:, None]  # group, 1, 2 line, term
    plain, moved = flat[..., :count], flat[..., count:]
    inner, cross = state.gram[..., :count, :count], state.gram[..., :count, count:]
    taken = np.sum(plain * solve_scaled(inner, plain.swapaxes(-1, -2)).swapaxes(-1, -2), axis=-1)
    beyond = (moved - plain @ solve_scaled(inner, cross)) @ state.turn  # group, frf, 2 line, twomode
    inverse = _inverse_of_free(state.information, problem.free.ravel())
    taken = taken + np.sum((beyond @ inverse[:, None]) * beyond, axis=-1)
    lines = len(problem.omega)
    each = (taken[..., :lines] + taken[..., lines:]) / 2
    return np.minimum(problem.weight * each.swapaxes(-1, -2), _MOST)


def _nearby(values: Float[np.ndarray, "group line frf"]) -> Float[np.ndarray, "group line frf"]:
    """Mean over `_NEAR` lines to either side, over fewer at the ends."""
    lines = values.shape[1]
    total = np.concatenate([np.zeros_like(values[:, :1]), np.cumsum(values, axis=1)], axis=1)
    first = np.maximum(np.arange(lines) - _NEAR, 0)
    last = np.minimum(np.arange(lines) + _NEAR + 1, lines)
    return (total[:, last] - total[:, first]) / (last - first)[:, None]


def _colour(deviation: np.ndarray) -> np.ndarray:
    """1 + 2Σρ over the first lags (Bartlett's weights), at least 1: lines for each independent one."""
    lines = deviation.shape[1]
    most = min(int(np.ceil(lines ** (1 / 3))), lines - 1)
    power = np.sum(np.abs(deviation) ** 2, axis=(1, 2))
    total = np.ones(len(deviation))
    for lag in range(1, most + 1):
        product = np.sum((deviation[:, lag:] * deviation[:, :-lag].conj()).real, axis=(1, 2))
        total += 2 * (1 - lag / (most + 1)) * product / np.where(power > 0, power, 1)
    return np.maximum(total, 1.0)
