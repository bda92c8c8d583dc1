"""Poles and shapes of a structure with their derivatives.

With the shapes scaled to u_pᵀ(2λ_pM + C)u_p = 1 and Q_p = λ_p²∂M + λ_p∂C + ∂K,

    ∂λ_p = −u_pᵀ Q_p u_p,    ∂u_p = Σ_{q≠p} u_q (u_qᵀ Q_p u_p)/(λ_q − λ_p) − ½ u_p u_pᵀ(2λ_p∂M + ∂C)u_p,

the sums over all 2n poles, a real one or a conjugate alike (Adhikari, AIAA Journal 37, 1999, for damped
systems). Repeated poles have no single derivative; their mutual terms are left out, which is exact for
whatever depends on the modes through sums over the repeated ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.modal import SecondOrderSystem
from flexmodal.modal.modes import solve_modes
from flexmodal.structure.structure import Change, Structure

REPEATED = 1e-7
"""Distance of poles, relative to the larger, below which they count as one."""


@dataclass(frozen=True, eq=False)
class Poles:
    """All 2n poles, in no particular order but first those of `Modes`, with derivatives."""

    pole: Complex[np.ndarray, " pole"]
    """λ [rad/s]"""
    shape: Complex[np.ndarray, "dof pole"]
    pole_slope: Complex[np.ndarray, "name pole"]
    shape_slope: Complex[np.ndarray, "name dof pole"]
    count: int
    """How many of them are modes: real poles, and of each pair the one with positive imaginary part."""

    @property
    def frequency(self) -> Float[np.ndarray, " mode"]:
        """Natural frequencies of the modes [Hz]."""
        return np.abs(self.pole[: self.count]) / (2 * np.pi)

    @property
    def damping_ratio(self) -> Float[np.ndarray, " mode"]:
        """−Re λ/|λ| of the modes."""
        pole = self.pole[: self.count]
        return -pole.real / np.maximum(np.abs(pole), 1e-300)

    @property
    def log_frequency_slope(self) -> Float[np.ndarray, "name mode"]:
        """Derivatives of ln |λ|."""
        return (self.pole_slope / self.pole)[:, : self.count].real

    @property
    def damping_slope(self) -> Float[np.ndarray, "name mode"]:
        """Derivatives of the damping ratio −Re λ/|λ|: √(1 − ζ²) Im(∂λ/λ), signed by Im λ."""
        turned = (self.pole_slope / self.pole)[:, : self.count].imag
        pole = self.pole[: self.count]
        return turned * pole.imag / np.maximum(np.abs(pole), 1e-300)


def poles(structure: Structure, names: tuple[str, ...] = ()) -> Poles:
    """Poles, shapes and their derivatives along some parameters; hysteretic stiffness is left out.

    Raises:
        InvalidSystem: the mass matrix is not positive definite.
    """
    system = SecondOrderSystem(structure.mass, structure.damping, structure.stiffness, structure.coordinates)
    modes = solve_modes(system)
    pole, shape = modes.expanded()
    slope = np.zeros((len(names), len(pole)), dtype=complex)
    turned = np.zeros((len(names), *shape.shape), dtype=complex)
    apart = pole[None, :] - pole[:, None]  # λ_q − λ_p at [p, q]
    near = np.abs(apart) <= REPEATED * np.maximum(np.abs(pole)[None, :], np.abs(pole)[:, None])
    factor = np.where(near, 0.0, 1 / np.where(near, 1.0, apart))
    for number, name in enumerate(names):
        if name in structure.changes:
            _differentiate(structure.changes[name], pole, shape, factor, slope[number], turned[number])
    return Poles(pole, shape, slope, turned, len(modes.pole))


def _differentiate(
    change: Change,
    pole: np.ndarray,
    shape: np.ndarray,
    factor: np.ndarray,
    slope: np.ndarray,
    turned: np.ndarray,
) -> None:
    """Fill in the derivatives along one parameter."""
    seen = np.zeros((len(pole), len(pole)), dtype=complex)  # u_qᵀ Q_p u_p at [q, p]
    own = np.zeros(len(pole), dtype=complex)
    for matrix, power in ((change.stiffness, 0), (change.damping, 1), (change.mass, 2)):
        if matrix is None:
            continue
        size = len(matrix)
        part = shape[:size].T @ matrix @ shape[:size]
        seen += part * pole**power
        if power:
            own += power * pole ** (power - 1) * np.diag(part)
    slope[:] = -np.diag(seen)
    turned[:] = shape @ (seen * factor.T) - 0.5 * shape * own
