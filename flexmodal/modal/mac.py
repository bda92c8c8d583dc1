"""How alike mode shapes are: MAC, auto-MAC, COMAC, and how near a shape is to a real one."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Shaped

from flexmodal.errors import Fault, InvalidRequest


def mac(
    first: Shaped[np.ndarray, "dof mode"], second: Shaped[np.ndarray, "dof other"]
) -> Float[np.ndarray, "mode other"]:
    """Modal assurance criterion |φᴴψ|²/(φᴴφ ψᴴψ): 1 for the same shape up to a factor, 0 for orthogonal ones.

    Args:
        first: shapes as columns, real or complex.
        second: shapes with the same rows.

    Raises:
        InvalidRequest: different rows, or a shape that is zero or not finite.
    """
    one, other = _shapes(first, "first"), _shapes(second, "second")
    if one.shape[0] != other.shape[0]:
        found = f"{one.shape[0]} and {other.shape[0]} rows"
        raise InvalidRequest(Fault("call", "shapes", found, "the same points in both"))
    one, other = one / np.linalg.norm(one, axis=0), other / np.linalg.norm(other, axis=0)
    return np.clip(np.abs(one.conj().T @ other) ** 2, 0.0, 1.0)


def mac_with(shape: Shaped[np.ndarray, " dof"], others: Shaped[np.ndarray, "dof *mode"]) -> Any:
    """MAC of one shape with others, unchecked: 0 where one of the two rests.

    Args:
        shape: real or complex.
        others: one shape, which gives a number, or several as columns.
    """
    size = np.sum(np.abs(shape) ** 2) * np.sum(np.abs(others) ** 2, axis=0)
    return np.abs(shape.conj() @ others) ** 2 / np.maximum(size, 1e-300)


def shape_residual(
    measured: Complex[np.ndarray, " dof"],
    model: Complex[np.ndarray, " dof"],
    slopes: Complex[np.ndarray, "parameter dof"],
) -> tuple[Float[np.ndarray, " twice"], Float[np.ndarray, "parameter twice"]]:
    """A − P a, P the projection onto a model's shape: |·|² = 1 − MAC; and its derivatives.

    By variable projection (Kaufman, BIT 15, 1975), real parts first.

    Args:
        measured: a, of unit length.
        model: of any length.
        slopes: derivatives of the model's shape.
    """
    length = max(float(np.linalg.norm(model)), 1e-300)
    unit = model / length
    factor = unit.conj() @ measured
    away = measured - factor * unit
    turned = slopes / length
    turned = -factor * (turned - np.outer(turned @ unit.conj(), unit))
    return np.concatenate([away.real, away.imag]), np.concatenate([turned.real, turned.imag], axis=1)


def auto_mac(shapes: Shaped[np.ndarray, "dof mode"]) -> Float[np.ndarray, "mode mode"]:
    """MAC of shapes with one another: off the diagonal, what the points chosen cannot tell apart.

    Raises:
        InvalidRequest: a shape that is all zeros.
    """
    return mac(shapes, shapes)


def comac(
    first: Shaped[np.ndarray, "dof mode"], second: Shaped[np.ndarray, "dof mode"]
) -> Float[np.ndarray, " dof"]:
    """Coordinate MAC: how well each point agrees over pairs of modes, (Σ|φψ|)²/(Σ|φ|² Σ|ψ|²).

    The shapes must be paired, column by column (see `track`); each is scaled to unit length first, since
    the sum weighs the modes by their size. A point that rests in every mode of both sets agrees.

    Args:
        first: shapes as columns.
        second: the shapes paired with them.

    Raises:
        InvalidRequest: different shapes of the arrays, or a mode shape that is zero or not finite.
    """
    one, other = _shapes(first, "first"), _shapes(second, "second")
    if one.shape != other.shape:
        found = f"{one.shape} and {other.shape}"
        raise InvalidRequest(Fault("call", "shapes", found, "as many points and modes in both"))
    one, other = np.abs(one / np.linalg.norm(one, axis=0)), np.abs(other / np.linalg.norm(other, axis=0))
    size = np.sum(one**2, axis=1) * np.sum(other**2, axis=1)
    still = np.all(one == 0, axis=1) & np.all(other == 0, axis=1)
    together = np.sum(one * other, axis=1) ** 2
    return np.where(still, 1.0, np.divide(together, size, out=np.zeros_like(size), where=size > 0))


def phase_collinearity(shapes: Shaped[np.ndarray, "dof mode"]) -> Float[np.ndarray, " mode"]:
    """Modal phase collinearity: 1 where all points move in phase or against it, 0 where phases are spread.

    |φᵀφ|²/(φᴴφ)², which is the squared difference over the squared sum of the two eigenvalues of the
    scatter of (Re φ, Im φ), and does not change when the shape is turned by a phase.

    Raises:
        InvalidRequest: a shape that is zero or not finite.
    """
    given = _shapes(shapes, "shapes")
    return np.abs(np.sum(given**2, axis=0)) ** 2 / np.sum(np.abs(given) ** 2, axis=0) ** 2


def _shapes(given: np.ndarray, key: str) -> np.ndarray:
    array = np.asarray(given)
    if array.ndim != 2 or array.shape[0] == 0:
        raise InvalidRequest(Fault("call", key, f"an array of shape {array.shape}", "shapes as columns"))
    if not np.all(np.isfinite(array)):
        raise InvalidRequest(Fault("call", key, "an entry that is not finite", "finite numbers"))
    size = np.max(np.abs(array), axis=0)
    if np.any(size == 0):
        raise InvalidRequest(
            Fault("call", key, f"mode {int(np.argmin(size)) + 1} is zero", "shapes that move")
        )
    return array / size  # squares of very small shapes would underflow
