"""Poles and shapes of a structure with their derivatives.

With the shapes scaled to u_pᵀ(2λ_pM + C)u_p = 1 and Q_p = λ_p²∂M + λ_p∂C + ∂K,

    ∂λ_p = −u_pᵀ Q_p u_p,    ∂u_p = Σ_{q≠p} u_q (u_qᵀ Q_p u_p)/(λ_q − λ_p) − ½ u_p u_pᵀ(2λ_p∂M + ∂C)u_p,

the sums over all 2n poles, a real one or a conjugate alike (Adhikari, AIAA Journal 37, 1999, for damped
systems). Repeated poles have no single derivative; their mutual terms are left out, which is exact for
whatever depends on the modes through sums over the repeated ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import InvalidSystem
from flexmodal.modal import SecondOrderSystem
from flexmodal.modal.modes import solve_modes
from flexmodal.structure.structure import Structure

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


def poles(structure: Structure, names: tuple[str, ...] = (), *, active: bool = False) -> Poles:
    """Poles, shapes and their derivatives along some parameters; hysteretic stiffness is left out.

    Args:
        structure: with its derivatives.
        names: parameters to derive along; where nothing changes derivatives are 0.
        active: whether a control loop may make the mass matrix indefinite.

    Raises:
        InvalidSystem: the mass matrix is not positive definite, and no loop is to be blamed.
        LinAlgError: it is singular, or a structure with such a loop rings up or has a pole without a shape.
    """
    try:
        system = SecondOrderSystem(
            structure.mass, structure.damping, structure.stiffness, structure.coordinates
        )
    except InvalidSystem:
        if not active:
            raise
        pole, shape, count = _of_active(structure)
    else:
        modes = solve_modes(system)
        (pole, shape), count = modes.expanded(), len(modes.pole)
    matrices = {kind: slopes_of([structure], names, kind)[0] for kind in ("mass", "damping", "stiffness")}
    slope, turned = eigen_slopes(pole, shape, **matrices)
    return Poles(pole, shape, slope, turned, count)


def _of_active(
    structure: Structure,
) -> tuple[Complex[np.ndarray, " pole"], Complex[np.ndarray, "dof pole"], int]:
    """Poles, shapes and the number of modes, by the companion form: no root of the mass is taken."""
    n = structure.dof
    unit = float(np.sqrt(np.abs(np.linalg.solve(structure.mass, structure.stiffness)).max()))
    state = np.zeros((2 * n, 2 * n))
    state[:n, n:] = unit * np.eye(n)
    state[n:, :n] = -np.linalg.solve(structure.mass, structure.stiffness) / unit
    state[n:, n:] = -np.linalg.solve(structure.mass, structure.damping)
    pole, vectors = np.linalg.eig(state)
    if pole.real.max() > 0:  # masses that are indefinite by rounding alone leave no digit
        raise np.linalg.LinAlgError("rings up")
    order = np.lexsort((np.abs(pole), pole.imag < 0))  # of each pair the one above first
    pole, shape = pole[order].astype(complex), vectors[:n, order].astype(complex)
    scale = np.einsum("ip,ijp,jp->p", shape, 2 * pole * structure.mass[:, :, None], shape)
    scale += np.einsum("ip,ij,jp->p", shape, structure.damping, shape)
    if not np.all(scale):  # two poles fall on one and share their shape
        raise np.linalg.LinAlgError("a pole without a shape of its own")
    return pole, shape / np.sqrt(scale), int(np.count_nonzero(pole.imag >= 0))


def eigen_slopes(
    pole: Complex[np.ndarray, "*posture pole"],
    shape: Complex[np.ndarray, "*posture dof pole"],
    *,
    mass: Float[np.ndarray, "*posture name dof dof"],
    damping: Float[np.ndarray, "*posture name dof dof"],
    stiffness: Float[np.ndarray, "*posture name dof dof"],
) -> tuple[Complex[np.ndarray, "*posture name pole"], Complex[np.ndarray, "*posture name dof pole"]]:
    """Derivatives of poles and shapes along some parameters, of several postures at once.

    Args:
        pole: all 2n of them.
        shape: scaled as above.
        mass: ∂M.
        damping: ∂C.
        stiffness: ∂K.
    """
    each = shape[..., None, :, :]
    left = np.swapaxes(each, -1, -2)
    m, c, k = (left @ matrix @ each for matrix in (mass, damping, stiffness))
    at = pole[..., None, None, :]
    between = k + at * (c + at * m)  # u_qᵀ Q_p u_p at [q, p]
    own = np.diagonal(c + 2 * at * m, axis1=-2, axis2=-1)
    apart = pole[..., None, :] - pole[..., :, None]  # λ_q − λ_p at [p, q]
    size = np.abs(pole)
    near = np.abs(apart) <= REPEATED * np.maximum(size[..., None, :], size[..., :, None])
    factor = np.where(near, 0.0, 1 / np.where(near, 1.0, apart))
    mixed = between * np.swapaxes(factor, -1, -2)[..., None, :, :]
    turned = each @ mixed - 0.5 * each * own[..., None, :]
    return -np.diagonal(between, axis1=-2, axis2=-1), turned


def slopes_of(
    structures: Sequence[Structure], names: Sequence[str], kind: str
) -> Float[np.ndarray, "posture name dof dof"]:
    """Derivatives of one kind of matrix of some structures, zero where nothing changes.

    Args:
        structures: of one size, one in each posture.
        names: parameters to derive along.
        kind: of the matrices: mass, damping, stiffness or loss.
    """
    n = structures[0].dof
    table = np.zeros((len(structures), len(names), n, n))
    for p, one in enumerate(structures):
        for k, name in enumerate(names):
            change = one.changes.get(name)
            matrix = None if change is None else getattr(change, kind)
            if matrix is not None:
                table[p, k, : len(matrix), : len(matrix)] = matrix
    return table
