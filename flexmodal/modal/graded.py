"""Modes of systems whose springs range over many decades, to all their digits.

The eigenvalues of M⁻¹K found by an ordinary symmetric solver are right to rounding of the largest: beside a
joint of 1e18 N·m/rad one of 100 has none left. With K = GGᵀ they are the squares of the singular values of
L⁻¹G, M = LLᵀ, and one-sided Jacobi rotations find each of those to its own digits (Demmel and Veselić, SIAM
J. Matrix Anal. 13, 1992; LAPACK's GEJSV). A damped pole is judged by its own residual, and mended by
Newton's method.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import InaccurateModes
from flexmodal.modal.system import SecondOrderSystem

RANGE = 1e-8
"""Ratio of the smallest to the largest eigenvalue below which Jacobi's rotations take over."""
CLOSE, WRONG = 1e-11, 1e-6
"""Residual of a pole, relative to the terms it is made of, that is mended, and that is refused."""
_STEPS = 5


def graded_squares(
    stiffness: Float[np.ndarray, "dof dof"], root: Float[np.ndarray, "dof dof"]
) -> tuple[Float[np.ndarray, " dof"], Float[np.ndarray, "dof dof"]] | None:
    """Squared natural frequencies ascending [rad²/s²], and their vectors in the coordinates of M = I.

    Args:
        stiffness: K, its diagonal of any range.
        root: L⁻¹ of M = LLᵀ.

    Returns:
        None where K is not positive definite.
    """
    from scipy.linalg import lapack

    size = np.sqrt(np.maximum(np.diag(stiffness), 0.0))
    safe = np.where(size > 0, size, 1.0)
    try:
        factor = np.linalg.cholesky(stiffness / safe[:, None] / safe)
    except np.linalg.LinAlgError:
        return None
    values, left, _, scale, _, info = lapack.dgejsv(root @ (safe[:, None] * factor), joba=2, jobu=0, jobv=0)
    if info != 0:
        return None
    order = np.argsort(values)
    return (values[order] * (scale[0] / scale[1])) ** 2, left[:, order]


def mended(
    poles: Complex[np.ndarray, " pole"],
    shapes: Complex[np.ndarray, "dof pole"],
    square: Float[np.ndarray, " dof"],
    damping: Float[np.ndarray, "dof dof"],
) -> tuple[Complex[np.ndarray, " pole"], Complex[np.ndarray, "dof pole"]]:
    """Poles of (λ² + λC + diag(square)) u = 0 with those mended whose own residual is no rounding.

    Args:
        poles: as an eigensolver has them.
        shapes: their displacement shapes.
        square: squared natural frequencies without damping.
        damping: C in the same coordinates.
    """
    matrices = np.eye(len(square)), damping, np.diag(square)
    for place in np.flatnonzero(_residuals(poles, shapes, *matrices) > CLOSE):
        poles[place], shapes[:, place] = _newton(complex(poles[place]), shapes[:, place], *matrices)
    return poles, shapes


def check_digits(
    system: SecondOrderSystem, poles: Complex[np.ndarray, " pole"], shapes: Complex[np.ndarray, "dof pole"]
) -> None:
    """Judge each pole by what it leaves of its own equation.

    Args:
        system: without its hysteresis.
        poles: λ [rad/s].
        shapes: their displacement shapes.

    Raises:
        InaccurateModes: one of them does not solve it.
    """
    worst = _residuals(poles, shapes, system.mass, system.damping, system.stiffness)
    if np.any(worst > WRONG):
        raise InaccurateModes(
            f"{np.sum(worst > WRONG)} of {len(worst)} poles have no digits left: stiffness and damping range"
            " over too many decades; the receptance, which needs no modes, stays right"
        )


def _residuals(
    poles: np.ndarray, shapes: np.ndarray, mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray
) -> Float[np.ndarray, " pole"]:
    """Largest of |(λ²M + λC + K) u| over the rows, each relative to the size of its own terms."""
    left = (mass @ shapes) * poles**2 + (damping @ shapes) * poles + stiffness @ shapes
    rows = [np.abs(one).sum(axis=1)[:, None] for one in (mass, damping, stiffness)]
    size = rows[0] * np.abs(poles) ** 2 + rows[1] * np.abs(poles) + rows[2]
    size = size * np.linalg.norm(shapes, axis=0)
    return np.max(np.abs(left) / np.where(size > 0, size, 1.0), axis=0, initial=0.0)


def _newton(
    pole: complex, shape: np.ndarray, mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray
) -> tuple[complex, np.ndarray]:
    """A pole with its shape, by Newton's method on both; the better of what it had and what it found."""
    best, count = (np.inf, pole, shape), len(mass)
    for _ in range(_STEPS):
        shape = shape / np.linalg.norm(shape)
        worst = float(_residuals(np.array([pole]), shape[:, None], mass, damping, stiffness)[0])
        if worst < best[0]:
            best = worst, pole, shape
        if worst <= CLOSE / 100:
            break
        matrix = pole**2 * mass + pole * damping + stiffness
        bordered = np.zeros((count + 1, count + 1), dtype=complex)
        bordered[:count, :count], bordered[count, :count] = matrix, shape.conj()
        bordered[:count, count] = (2 * pole * mass + damping) @ shape
        scale = np.maximum(np.abs(bordered).max(axis=1), np.finfo(float).tiny)
        try:
            step = np.linalg.solve(bordered / scale[:, None], np.append(-matrix @ shape, 0.0) / scale)
        except np.linalg.LinAlgError:
            break
        shape, pole = shape + step[:count], pole + complex(step[count])
    return best[1], best[2]
