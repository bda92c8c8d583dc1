"""Least squares that is linear in the residues and not in the poles, many fits at once.

Variable projection in its Gauss–Newton form: at each set of poles the linear unknowns are solved for
exactly and eliminated from the normal equations (a Schur complement), so that the step is one in the
poles alone and its matrix is their information. Everything carries a leading axis of groups: fits that
share the frequency axis and the number of modes and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.ema.basis import Residuals, mode_columns, pole_of, pole_slopes, residual_columns

_DAMPING = (-0.5, 0.98)
"""Where a damping ratio may wander; outside, the pair of poles has no such form."""


@dataclass(frozen=True, eq=False)
class Separable:
    """The data of some fits, in units that make them of order one."""

    omega: Float[np.ndarray, " line"]
    value: Complex[np.ndarray, "group line frf"]
    weight: Float[np.ndarray, "group line frf_or_1"]
    """Each squared deviation counts so much; 1/variance makes the estimate the most probable one."""
    power: int
    residuals: Residuals
    free: Bool[np.ndarray, "mode 2"]
    """Which natural frequencies and damping ratios are sought; the others stay as they start."""


@dataclass(frozen=True, eq=False)
class Elimination:
    """The state of the fits at some poles, the linear unknowns solved for."""

    linear: Float[np.ndarray, "group frf term"]
    deviation: Complex[np.ndarray, "group line frf"]
    cost: Float[np.ndarray, " group"]
    gram: Float[np.ndarray, "group frf_or_1 all all"]
    """Weighted products of the linear columns, then of their changes with the poles."""
    turn: Float[np.ndarray, "group frf twomode twomode"]
    """From the natural frequencies and damping ratios to the columns of change."""
    information: Float[np.ndarray, "group twomode twomode"]
    gradient: Float[np.ndarray, "group twomode"]


def columns_at(
    problem: Separable, omega: np.ndarray, damping: np.ndarray
) -> tuple[np.ndarray, int]:
    """All columns [group line term] at some poles, and how many of them are linear unknowns."""
    pole = pole_of(omega, damping)
    tail = residual_columns(problem.omega, problem.power, problem.residuals)
    first = mode_columns(problem.omega, pole, problem.power)
    second = mode_columns(problem.omega, pole, problem.power, order=2)
    tail = np.broadcast_to(tail, (*first.shape[:-1], tail.shape[1]))
    return np.concatenate([first, tail, second], axis=-1), first.shape[-1] + tail.shape[-1]


def weighted_gram(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Re ΦᴴWΦ for every group and every set of weights: [group frf_or_1 term term]."""
    flat = np.concatenate([columns.real, columns.imag], axis=1)  # group, 2 line, term
    doubled = np.concatenate([weight, weight], axis=1).transpose(0, 2, 1)[..., None]
    return flat.transpose(0, 2, 1)[:, None] @ (doubled * flat[:, None])


def eliminate(problem: Separable, omega: np.ndarray, damping: np.ndarray) -> Elimination:
    """Solve for residues and residual terms at these poles; slopes of the cost along the poles."""
    columns, count = columns_at(problem, omega, damping)
    gram = weighted_gram(columns, problem.weight)
    weighted = problem.weight * problem.value
    right = np.einsum("glt,glj->gjt", columns[..., :count].conj(), weighted).real
    linear = solve_scaled(gram[..., :count, :count], right[..., None])[..., 0]
    deviation = problem.value - np.einsum("glt,gjt->glj", columns[..., :count], linear)
    cost = np.sum(problem.weight * np.abs(deviation) ** 2, axis=(1, 2))
    turn = _turn(linear, omega, damping)
    slope = np.einsum("glt,glj->gjt", columns[..., count:].conj(), problem.weight * deviation).real
    gradient = np.einsum("gjsp,gjs->gp", turn, slope)
    cross = gram[..., :count, count:]
    schur = gram[..., count:, count:] - cross.swapaxes(-1, -2) @ solve_scaled(gram[..., :count, :count], cross)
    information = np.sum(turn.swapaxes(-1, -2) @ schur @ turn, axis=1)
    free = problem.free.ravel()
    information = np.where(np.outer(free, free), information, np.eye(len(free)))
    return Elimination(linear, deviation, cost, gram, turn, information, np.where(free, gradient, 0.0))


def _turn(linear: np.ndarray, omega: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """∂α = A ∂λ/(iω − λ)² + conjugate: blocks of Re, Im of A ∂λ/∂ω_n and of A ∂λ/∂ζ."""
    modes = omega.shape[1]
    residue = linear[..., 0 : 2 * modes : 2] + 1j * linear[..., 1 : 2 * modes : 2]
    turn = np.zeros((*linear.shape[:2], 2 * modes, 2 * modes))
    for which, slope in enumerate(pole_slopes(omega, damping)):
        moved = residue * slope[:, None]
        for mode in range(modes):
            turn[..., 2 * mode, 2 * mode + which] = moved[..., mode].real
            turn[..., 2 * mode + 1, 2 * mode + which] = moved[..., mode].imag
    return turn


def solve_scaled(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve a stack of symmetric systems, scaled to a unit diagonal and kept off singularity."""
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = matrix * scale[..., :, None] * scale[..., None, :]
    # Columns that say the same thing share the answer instead of failing the whole stack.
    scaled = scaled + 1e-14 * np.eye(matrix.shape[-1])
    return scale[..., None] * np.linalg.solve(scaled, scale[..., None] * right)


def minimise(
    problem: Separable, omega: np.ndarray, damping: np.ndarray, *, rounds: int = 60
) -> tuple[np.ndarray, np.ndarray, Elimination, np.ndarray]:
    """Levenberg–Marquardt on all groups at once.

    Returns:
        Natural frequencies, damping ratios [group mode], the state there, and which groups converged.
    """
    state = eliminate(problem, omega, damping)
    force = np.full(len(omega), 1e-3)
    settled = np.zeros(len(omega), dtype=bool)
    for _ in range(rounds):
        new_omega, new_damping, step = _step(state, omega, damping, force)
        trial = eliminate(problem, new_omega, new_damping)
        better = (trial.cost <= state.cost) & np.isfinite(trial.cost) & ~settled
        gained = state.cost - trial.cost
        small = np.max(np.abs(step), axis=1) < 1e-7
        settled |= (better & (gained <= 1e-9 * state.cost) & small) | (~better & small) | (force > 1e12)
        omega = np.where(better[:, None], new_omega, omega)
        damping = np.where(better[:, None], new_damping, damping)
        state = _choose(better, trial, state)
        force = np.where(better, np.maximum(force / 5, 1e-12), force * 4)
        if settled.all():
            break
    return omega, damping, state, settled


def _step(
    state: Elimination, omega: np.ndarray, damping: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One damped Gauss–Newton step, no longer than the resonance is wide; relative length for stopping."""
    diagonal = np.diagonal(state.information, axis1=-2, axis2=-1)
    matrix = state.information + force[:, None, None] * diagonal[..., None] * np.eye(diagonal.shape[1])
    step = solve_scaled(matrix, state.gradient[..., None])[..., 0].reshape(*omega.shape, 2)
    width = np.maximum(np.abs(damping), 1e-4)
    relative = np.stack([step[..., 0] / (omega * width), step[..., 1] / width], axis=-1)
    longest = np.max(np.abs(relative), axis=(1, 2))
    cut = np.where(longest > 1, 1 / np.maximum(longest, 1), 1.0)[:, None]
    new_damping = np.clip(damping + cut * step[..., 1], *_DAMPING)
    return omega + cut * step[..., 0], new_damping, relative.reshape(len(omega), -1)


def _choose(better: np.ndarray, new: Elimination, old: Elimination) -> Elimination:
    def pick(name: str) -> np.ndarray:
        one, other = getattr(new, name), getattr(old, name)
        return np.where(better.reshape((-1,) + (1,) * (one.ndim - 1)), one, other)

    return Elimination(*(pick(name) for name in Elimination.__dataclass_fields__))
