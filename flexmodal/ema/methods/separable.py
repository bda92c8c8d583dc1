"""Least squares that is linear in the residues and not in the poles, many fits at once.

Variable projection in its Gauss–Newton form: at each set of poles the linear unknowns are solved for
exactly and eliminated from the normal equations (a Schur complement), so that the step is one in the
poles alone and its matrix is their information. Everything carries a leading axis of groups: fits that
share the frequency axis and the number of modes and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.ema.methods.basis import Residuals, mode_columns, pole_of, pole_slopes, residual_columns

_DAMPING = (-0.5, 0.98)
"""Where a damping ratio may wander; outside, the pair of poles has no such form."""

_LEAST = 1e-12
"""A damping ratio of 0 on a line would be a pole of the columns."""


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
    further: int = 0
    """Terms more of the residual terms' series, see `residual_columns`."""


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


def columns_at(problem: Separable, omega: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, int]:
    """All columns [group line term] at some poles, and how many of them are linear unknowns.

    Args:
        problem: lines, weights and what is free.
        omega: natural frequencies [rad/s].
        damping: ratios.
    """
    pole = pole_of(omega, damping)
    tail = residual_columns(problem.omega, problem.power, problem.residuals, problem.further)
    first = mode_columns(problem.omega, pole, problem.power)
    second = mode_columns(problem.omega, pole, problem.power, order=2)
    tail = np.broadcast_to(tail, (*first.shape[:-1], tail.shape[1]))
    return np.concatenate([first, tail, second], axis=-1), first.shape[-1] + tail.shape[-1]


def weighted_gram(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Re ΦᴴWΦ for every group and every set of weights: [group frf_or_1 term term].

    Args:
        columns: what the fit is linear in.
        weight: of every line.
    """
    flat = np.concatenate([columns.real, columns.imag], axis=1)  # group, 2 line, term
    doubled = np.concatenate([weight, weight], axis=1).transpose(0, 2, 1)[..., None]
    return flat.transpose(0, 2, 1)[:, None] @ (doubled * flat[:, None])


def eliminate(problem: Separable, omega: np.ndarray, damping: np.ndarray) -> Elimination:
    """Solve for residues and residual terms at these poles; slopes of the cost along the poles.

    Args:
        problem: lines, weights and what is free.
        omega: natural frequencies [rad/s].
        damping: ratios.
    """
    columns, count = columns_at(problem, omega, damping)
    gram = weighted_gram(columns, problem.weight)
    right = _products(columns[..., :count], problem.weight * problem.value)
    linear = solve_scaled(gram[..., :count, :count], right[..., None])[..., 0]
    deviation = problem.value - columns[..., :count] @ linear.swapaxes(-1, -2)
    cost = np.sum(problem.weight * np.abs(deviation) ** 2, axis=(1, 2))
    turn = _turn(linear, omega, damping)
    slope = _products(columns[..., count:], problem.weight * deviation)
    gradient = np.einsum("gjsp,gjs->gp", turn, slope)
    cross = gram[..., :count, count:]
    schur = gram[..., count:, count:] - cross.swapaxes(-1, -2) @ solve_scaled(
        gram[..., :count, :count], cross
    )
    information = np.sum(turn.swapaxes(-1, -2) @ schur @ turn, axis=1)
    free = problem.free.ravel()
    information = np.where(np.outer(free, free), information, np.eye(len(free)))
    return Elimination(linear, deviation, cost, gram, turn, information, np.where(free, gradient, 0.0))


def _products(columns: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Re ΦᴴX: [group frf term]."""
    real, imaginary = value.real.swapaxes(-1, -2), value.imag.swapaxes(-1, -2)
    return real @ columns.real + imaginary @ columns.imag


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
    """Solve a stack of symmetric systems, scaled to a unit diagonal and kept off singularity.

    Args:
        matrix: symmetric, positive semidefinite.
        right: right-hand sides.
    """
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

    Args:
        problem: lines, weights and what is free.
        omega: natural frequencies to begin with [rad/s].
        damping: ratios to begin with.
        rounds: most steps.

    Returns:
        Natural frequencies, damping ratios [group mode], the state there, and which groups converged.
    """
    state = eliminate(problem, omega, damping)
    omega, damping = omega.copy(), damping.copy()
    force = np.full(len(omega), 1e-3)
    settled = np.zeros(len(omega), dtype=bool)
    reach = (0.5 * float(problem.omega[0]), 2 * float(problem.omega[-1]))
    for _ in range(rounds):
        left = np.flatnonzero(~settled)  # those that are done cost nothing more
        here = _take(state, left)
        new_omega, new_damping, step, promised = _step(here, omega[left], damping[left], force[left], reach)
        trial = eliminate(_part(problem, left), new_omega, new_damping)
        better = (trial.cost <= here.cost) & np.isfinite(trial.cost)
        # Done where a step promises less than a ten-thousandth of a standard error, or has no length.
        little = promised <= 1e-8 * here.cost / problem.value[0].size
        settled[left] = little | (np.max(np.abs(step), axis=1) < 1e-10) | (force[left] > 1e12)
        won = left[better]
        omega[won], damping[won] = new_omega[better], new_damping[better]
        state = _put(state, won, _take(trial, np.flatnonzero(better)))
        force[left] = np.where(better, np.maximum(force[left] / 5, 1e-12), force[left] * 4)
        if settled.all():
            break
    return omega, damping, state, settled


def _part(problem: Separable, groups: np.ndarray) -> Separable:
    return replace(problem, value=problem.value[groups], weight=problem.weight[groups])


def _take(state: Elimination, groups: np.ndarray) -> Elimination:
    return Elimination(*(getattr(state, name)[groups] for name in Elimination.__dataclass_fields__))


def _put(state: Elimination, groups: np.ndarray, new: Elimination) -> Elimination:
    for name in Elimination.__dataclass_fields__:
        getattr(state, name)[groups] = getattr(new, name)
    return state


def _step(
    state: Elimination, omega: np.ndarray, damping: np.ndarray, force: np.ndarray, reach: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """One damped Gauss–Newton step, no longer than the resonance is wide.

    Returns:
        The new natural frequencies and damping ratios, the step relative to the widths, and by how much
        the step promises to lower the cost.
    """
    diagonal = np.diagonal(state.information, axis1=-2, axis2=-1)
    matrix = state.information + force[:, None, None] * diagonal[..., None] * np.eye(diagonal.shape[1])
    step = solve_scaled(matrix, state.gradient[..., None])[..., 0].reshape(*omega.shape, 2)
    width = np.maximum(np.abs(damping), 1e-4)
    relative = np.stack([step[..., 0] / (omega * width), step[..., 1] / width], axis=-1)
    longest = np.max(np.abs(relative), axis=(1, 2))
    cut = np.where(longest > 1, 1 / np.maximum(longest, 1), 1.0)[:, None]
    new_damping = np.clip(damping + cut * step[..., 1], *_DAMPING)
    new_damping = np.where(np.abs(new_damping) < _LEAST, _LEAST, new_damping)
    promised = np.sum(state.gradient * step.reshape(len(omega), -1), axis=1)
    new_omega = np.clip(omega + cut * step[..., 0], *reach)
    return new_omega, new_damping, relative.reshape(len(omega), -1), promised
