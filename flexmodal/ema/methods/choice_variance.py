"""How far a fit moves under choices that another analyst would have made as well.

Noise is not all that makes a number uncertain: on real data the residual terms, the weights and the ends of
the band move damping ratios by more than noise does. So the fit is solved again from where it ended, with one
of these changed at a time. Of two estimates of one thing from the same data, one of which makes the best use
of them, the difference d has the variance |V₁ − V₂| where noise alone parts them (Hausman, Econometrica 46,
1978). What d has beyond z = 2.58 such standard deviations, which noise exceeds once in a hundred times, is
put down to the choice. With either estimate as likely to be right as the other, the one that is stated is off
by nothing or by d, so that its variance grows by half the square,

    σ² = max(d² − z² |V₁ − V₂|, 0) / 2,

and those of several choices are added up, as independent contributions are (GUM, 5.1.2). A choice counts only
as far as an analyst would stand by it: its fit has settled and leaves no more than twice the squared
deviations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.ema.methods.basis import TERMS
from flexmodal.ema.methods.covariance import Covariances, propagate
from flexmodal.ema.methods.separable import Elimination, Separable, minimise
from flexmodal.ema.methods.weights import Weighting, by_deviation, weights_of
from flexmodal.ema.mode import ModeEstimate

SURE = 2.575829
"""Standard deviations within which 99 % of a normal variable lie."""

_ENDS = 0.1
"""Part of the band that is left out at each end to see whether it matters."""

_CLEAR = 10
"""So many lines, and a half-power bandwidth, stay between any mode and an end of the band."""

_WORSE = 2.0
"""A choice that leaves so many times the squared deviations is none that an analyst would stand by."""


@dataclass(frozen=True, eq=False)
class Solved:
    """Some fits at their minimum, in the kernel's units."""

    problem: Separable
    omega: Float[np.ndarray, "group mode"]
    damping: Float[np.ndarray, "group mode"]
    state: Elimination
    noise: Float[np.ndarray, "group line frf"]
    covariances: Covariances

    def numbers(self) -> tuple[np.ndarray, np.ndarray]:
        """Natural frequency, damping ratio and |A| of each FRF, and their variances [group mode 2+frf]."""
        groups, modes = self.omega.shape
        linear = self.state.linear[..., : 2 * modes].reshape(groups, -1, modes, 2)
        size = np.linalg.norm(linear, axis=-1)
        towards = linear / np.where(size > 0, size, 1.0)[..., None]
        whole = self.covariances.linear
        blocks = np.stack([whole[..., 2 * m : 2 * m + 2, 2 * m : 2 * m + 2] for m in range(modes)], axis=2)
        along = np.einsum("gfmi,gfmij,gfmj->gmf", towards, blocks, towards)
        pole = np.diagonal(self.covariances.pole, axis1=1, axis2=2).reshape(groups, modes, 2)
        values = np.concatenate([self.omega[..., None], self.damping[..., None], size.swapaxes(1, 2)], axis=2)
        return values, np.concatenate([pole, along], axis=2)

    def sane(self, settled: Bool[np.ndarray, " group"]) -> Bool[np.ndarray, "group mode"]:
        """Modes that are where an analyst would still take them for modes of these lines."""
        inside = (self.omega >= self.problem.omega[0]) & (self.omega <= self.problem.omega[-1])
        return settled[:, None] & inside & (self.damping > -0.4) & (self.damping < 0.95)


def moves_of(
    solved: Solved, weighting: Weighting, variance: Float[np.ndarray, "group line frf"] | None
) -> Float[np.ndarray, "group mode number"]:
    """Variances that stand for the choices, of natural frequency, damping ratio and |A| of each FRF.

    Args:
        solved: the fits as they were asked for.
        weighting: how they weigh.
        variance: of the values, where it is known.
    """
    values, spread = solved.numbers()
    total = np.zeros_like(values)
    for problem, lines in _others(solved, weighting, variance):
        found, settled = _again(problem, solved, lines)
        other, other_spread = found.numbers()
        fits = found.sane(settled & _as_well(found, solved, lines))
        total += np.where(fits[..., None], _beyond(other - values, other_spread - spread), 0.0)
    free = np.concatenate(
        [solved.problem.free, np.ones((len(solved.problem.free), values.shape[2] - 2))], axis=1
    )
    return np.where(free, total, 0.0)


def moved(mode: ModeEstimate, other: ModeEstimate) -> ModeEstimate:
    """A mode of one FRF whose uncertainty also holds how far another estimate of it, there, parts from it.

    Args:
        mode: which mode.
        other: another estimate of it.
    """
    values, others = (
        np.concatenate([[one.frequency, one.damping_ratio], np.abs(one.residue)]) for one in (mode, other)
    )
    total = _beyond(others - values, other.by_noise**2 - mode.by_noise**2)
    total[:2] = np.where(np.diag(mode.covariance) > 0, total[:2], 0.0)  # what was forced stays
    return replace(mode, choices=np.diag(total[:2]), residue_choices=total[2:])


def _beyond(
    difference: Float[np.ndarray, "*shape"], spread: Float[np.ndarray, "*shape"]
) -> Float[np.ndarray, "*shape"]:
    """The variance that stands for a choice: of two estimates and the difference of their variances."""
    return np.maximum(difference**2 - SURE**2 * np.abs(spread), 0.0) / 2


def _others(
    solved: Solved, weighting: Weighting, variance: np.ndarray | None
) -> Iterator[tuple[Separable, np.ndarray]]:
    """The problems with one choice changed, and the lines that each uses."""
    problem = solved.problem
    everything = np.ones(len(problem.omega), dtype=bool)
    unknowns = 2 * solved.omega.shape[1] + solved.state.linear.shape[-1]
    yield replace(problem, residuals="real" if problem.residuals == "complex" else "complex"), everything
    terms = TERMS[problem.residuals]
    if terms and unknowns + terms < 2 * len(everything):
        yield replace(problem, further=problem.further + 1), everything
    yield replace(problem, weight=_other_weights(solved, weighting, variance)), everything
    lines = _narrower(solved)
    if unknowns < 2 * np.count_nonzero(lines) < 2 * len(lines):
        weight = problem.weight[:, lines]
        yield (
            replace(problem, omega=problem.omega[lines], value=problem.value[:, lines], weight=weight),
            lines,
        )


def _other_weights(solved: Solved, weighting: Weighting, variance: np.ndarray | None) -> np.ndarray:
    if weighting != "logarithmic":
        return weights_of("logarithmic", solved.problem.value, variance)
    if variance is not None:
        return weights_of("variance", solved.problem.value, variance)
    return by_deviation(solved.state.deviation)


def _as_well(found: Solved, solved: Solved, lines: np.ndarray) -> Bool[np.ndarray, " group"]:
    """Whether a fit leaves at most twice the squared deviations of the first one on the same lines."""
    weight = np.broadcast_to(solved.problem.weight, solved.problem.value.shape)[:, lines]
    left, before = (
        np.sum(weight * np.abs(deviation) ** 2, axis=(1, 2))
        for deviation in (found.state.deviation, solved.state.deviation[:, lines])
    )
    well: Bool[np.ndarray, " group"] = left <= _WORSE * before
    return well


def _narrower(solved: Solved) -> Bool[np.ndarray, " line"]:
    """The lines without the ends of the band, as far as these are clear of every mode."""
    axis = solved.problem.omega
    span = _ENDS * (axis[-1] - axis[0])
    reach = np.maximum(2 * np.abs(solved.damping) * solved.omega, _CLEAR * float(np.median(np.diff(axis))))
    low = min(axis[0] + span, float(np.min(solved.omega - reach)))
    high = max(axis[-1] - span, float(np.max(solved.omega + reach)))
    lines: Bool[np.ndarray, " line"] = (axis >= low) & (axis <= high)
    return lines


def _again(problem: Separable, solved: Solved, lines: np.ndarray) -> tuple[Solved, np.ndarray]:
    """Solve from where the fit ended; its noise is that of the same data."""
    omega, damping, state, settled = minimise(problem, solved.omega, solved.damping, rounds=30)
    noise = solved.noise[:, lines]
    return Solved(
        problem, omega, damping, state, noise, propagate(problem, omega, damping, state, noise)
    ), settled
