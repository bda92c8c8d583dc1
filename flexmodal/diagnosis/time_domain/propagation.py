"""The linear part of an integration: exact over a step, in coordinates in which nothing is coupled but pairs.

With A V = V Λ the state is s = T y, where T has the real and the imaginary part of each pair of conjugate
eigenvectors in two columns. A function of A is then a block of 2 × 2 for each pair, [[Re f, Im f], [−Im f,
Re f]] at f(λ), and f(λ) for a real λ. Inputs are straight lines within a step (first-order hold).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.structure.structure import Axis, Structure

CONDITION = 1e8
"""Of T, beyond which eigenvectors are as good as parallel: two poles meet where a mode is just overdamped."""
APART = 1e-10
"""How much, relatively, entries of such an A are changed."""
_SMALL = 0.1
"""|λ h| below which the weights come from their series."""


@dataclass(frozen=True, eq=False)
class Propagation:
    """Of some systems, over one step."""

    back: Float[np.ndarray, "system state state"]
    """T."""
    inputs: Float[np.ndarray, "system state input"]
    """T⁻¹ B."""
    poles: Complex[np.ndarray, "system state"]
    """λ, conjugates side by side, real ones last."""
    step: float
    """h [s]."""

    def once(self) -> tuple[Float[np.ndarray, "system state"], Float[np.ndarray, "system state"]]:
        """exp(A h): what of each coordinate comes of itself, and what of the other one of its pair."""
        grown = np.exp(self.poles * self.step)
        return grown.real, grown.imag

    def weights(
        self,
    ) -> tuple[Float[np.ndarray, "system state input"], Float[np.ndarray, "system state input"]]:
        """What inputs at the beginning and at the end of a step do to the state at its end."""
        z = self.poles * self.step
        small = np.abs(z) < _SMALL
        apart = np.where(small, 1.0, z)
        first, second = np.expm1(apart) / apart, (np.expm1(apart) - apart) / apart**2
        near, term = np.where(small, z, 0.0), np.ones_like(z)
        even, slanted = np.zeros_like(z), np.zeros_like(z)
        for k in range(1, 13):  # 0.1¹² / 13! is far beyond the last digit
            even, slanted = even + term / k, slanted + term / (k * (k + 1))
            term = term * near / k
        first, second = np.where(small, even, first), np.where(small, slanted, second)
        h = self.step
        return self._applied(h * (first - second)), self._applied(h * second)

    def _applied(
        self, factor: Complex[np.ndarray, "system state"]
    ) -> Float[np.ndarray, "system state input"]:
        """A function of A, by its values at the poles, times the inputs."""
        other = np.arange(self.inputs.shape[1]) ^ 1
        return factor.real[..., None] * self.inputs + factor.imag[..., None] * self.inputs[:, other]


def propagated(
    a: Float[np.ndarray, "system state state"], columns: Float[np.ndarray, "system state input"], step: float
) -> Propagation:
    """Take systems apart into pairs.

    Args:
        a: A of each, with an even number of states.
        columns: B of each, what the inputs do to ṡ.
        step: h [s].
    """
    poles, back = _apart(a)
    inverse = _inverse(back)
    close = np.linalg.norm(back, 1, (1, 2)) * np.linalg.norm(inverse, 1, (1, 2)) > CONDITION
    if close.any():
        place = np.arange(a.shape[1])
        pattern = np.cos(1.0 + np.add.outer(place, np.sqrt(2.0) * place) ** 2)
        poles[close], back[close] = _apart(a[close] * (1.0 + APART * pattern))
        inverse[close] = _inverse(back[close])
    return Propagation(back, inverse @ columns, poles, step)


def _apart(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poles, conjugates side by side and real ones last, and T."""
    poles, shapes = np.linalg.eig(a)
    order = np.argsort(np.imag(poles) == 0, axis=1, kind="stable")
    poles = np.take_along_axis(poles, order, axis=1).astype(complex)
    shapes = np.take_along_axis(shapes, order[:, None], axis=2)
    return poles, np.where(np.imag(poles)[:, None] < 0, -np.imag(shapes), np.real(shapes))


def _inverse(back: np.ndarray) -> np.ndarray:
    """Of T; what is as good as one where eigenvectors are the same to the last digit."""
    try:
        return np.linalg.inv(back)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(back)


def state_matrix(structure: Structure, axis: Axis) -> Float[np.ndarray, "state state"]:
    """A of ṡ = A s with s = coordinates, velocities.

    Hysteretic springs stand in it, between each two modes, as springs and dampers that are right at the
    geometric mean of their frequencies. Only the torques feel the difference: the linear part of a receptance
    is computed with the springs themselves.

    Args:
        structure: with hysteretic springs or without.
        axis: whose first line and middle count for these springs.
    """
    n, k, c = structure.dof, structure.stiffness, structure.damping
    if structure.loss_factor and structure.loss.any():
        from scipy.linalg import eigh

        square, shapes = eigh(k, structure.mass)
        each = np.sqrt(np.sqrt(np.maximum(square, 0.0)))
        omega = np.maximum(np.outer(each, each), 2 * np.pi * axis.frequency[0] / 10)
        grown, _ = Axis(omega.ravel() / (2 * np.pi), axis.middle).hysteresis(structure.loss_factor)
        between = shapes.T @ structure.loss @ shapes * grown.reshape(n, n)
        back = structure.mass @ shapes
        k = k + back @ between.real @ back.T
        c = c + back @ (between.imag / omega) @ back.T
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:] = -np.linalg.solve(structure.mass, np.hstack([k, c]))
    return a
