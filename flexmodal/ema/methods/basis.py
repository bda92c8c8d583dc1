"""What a fit of the modal sum is linear in, and how it changes with the poles.

The receptance is α(ω) = Σ [A/(iω − λ) + Ā/(iω − λ̄)] + U − L/ω² [Hearne 2.19, with the residual terms U
and L of 2.20], and each other form is that times a power of iω. With A = a + ib a mode is linear in a
and b; its change with the pole is that of the same two functions squared.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest

Residuals = Literal["none", "real", "complex"]
"""Terms for the modes outside the band: none, in phase with the force, or of any phase."""
TERMS = {"none": 0, "real": 2, "complex": 4}
"""Real unknowns of U and L in each FRF, and of each further pair."""


def check_residuals(residuals: str) -> Residuals:
    """Return the choice, or raise InvalidRequest that lists the three."""
    if residuals not in get_args(Residuals):
        raise InvalidRequest(Fault("call", "residuals", repr(residuals), ", ".join(get_args(Residuals))))
    return residuals  # type: ignore[return-value]


def pole_of(
    omega: Float[np.ndarray, "*shape"], damping: Float[np.ndarray, "*shape"]
) -> Complex[np.ndarray, "*shape"]:
    """λ = −ζω_n + iω_n√(1 − ζ²), of the natural frequency [rad/s] and damping ratio below 1.

    Args:
        omega: natural frequency [rad/s].
        damping: ratio, below 1.
    """
    return omega * (-damping + 1j * np.sqrt(1 - damping**2))


def pole_slopes(
    omega: Float[np.ndarray, "*shape"], damping: Float[np.ndarray, "*shape"]
) -> tuple[Complex[np.ndarray, "*shape"], Complex[np.ndarray, "*shape"]]:
    """∂λ/∂ω_n and ∂λ/∂ζ.

    Args:
        omega: natural frequency [rad/s].
        damping: ratio, below 1.
    """
    root = np.sqrt(1 - damping**2)
    return -damping + 1j * root, omega * (-1 - 1j * damping / root)


def mode_columns(
    omega: Float[np.ndarray, " line"],
    pole: Complex[np.ndarray, "*group mode"],
    power: int,
    order: Literal[1, 2] = 1,
) -> Complex[np.ndarray, "*group line twomode"]:
    """The factors of Re A and Im A, mode by mode: (iω)^power (s + s̃) and (iω)^power i(s − s̃).

    `s = (iω − λ)^−order` and `s̃` the same with λ̄; order 2 gives the change with the pole.

    Args:
        omega: of the lines [rad/s].
        pole: λ [rad/s].
        power: of iω: 0 for a receptance, 1 for a mobility, 2 for an inertance.
        order: 1, or 2 for the change with the pole.
    """
    s = 1 / (1j * omega[:, None] - pole[..., None, :])
    conjugate = 1 / (1j * omega[:, None] - pole.conj()[..., None, :])
    if order == 2:
        s, conjugate = s * s, conjugate * conjugate
    pair = np.stack([s + conjugate, 1j * (s - conjugate)], axis=-1)
    columns = pair * ((1j * omega) ** power)[:, None, None]
    return columns.reshape(*columns.shape[:-2], -1)


def residual_columns(
    omega: Float[np.ndarray, " line"], power: int, residuals: Residuals, further: int = 0
) -> Complex[np.ndarray, "line term"]:
    """The factors of U and L: stiffness line and mass line, real parts before imaginary ones.

    A mode above the lines is a power series in ω that begins with U, one below them a series in 1/ω to which
    L belongs: Σ_k −2 Re(A/λᵏ⁺¹) (iω)ᵏ and Σ_k 2 Re(A λᵏ) (iω)⁻ᵏ⁻¹, geometric series of A/(iω − λ) and its
    conjugate. `further` takes so many terms more of both, ω in units of the lines' geometric mean; they come
    behind the others.

    Args:
        omega: of the lines [rad/s].
        power: of iω, see `mode_columns`.
        residuals: none, real or complex.
        further: how many terms more of each series.
    """
    if residuals == "none":
        return np.empty((len(omega), 0), dtype=complex)
    relative = omega / np.exp(np.mean(np.log(omega)))
    pairs = [np.stack([np.ones_like(omega), -1 / omega**2], axis=1)]
    pairs += [np.stack([relative**k, relative ** (-2 - k)], axis=1) for k in range(1, further + 1)]
    form = ((1j * omega) ** power)[:, None]
    parts = [pair * form for pair in pairs]
    if residuals == "complex":
        parts = [np.concatenate([lines, 1j * lines], axis=1) for lines in parts]
    return np.concatenate(parts, axis=1)
