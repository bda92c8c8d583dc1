"""Poly-reference least squares complex frequency: poles and participation factors at every order.

The FRFs from references to responses are fitted as the matrix fraction B(z)A(z)⁻¹ with z = exp(−iτ(ω − ω₀)),
all coefficients complex and the band mapped onto the whole circle, which keeps the normal equations well
conditioned at any order. A has as many rows and columns as there are references: of one it is a common
denominator, of several it tells modes apart that share a frequency but not a shape, and a left null vector of
A at a pole is how far each reference takes part in that mode. Minimising Σ‖HA − B‖² is linear; eliminating B
leaves one small matrix, and what is needed for the highest order holds that of every lower one (Guillaume,
Verboven, Vanlanduit and others, 1998–2003; Peeters, Van der Auweraer, Guillaume and Leuridan 2004). The
highest coefficient of A is held at the identity, which pushes the poles that only follow the noise to
negative damping, where they are recognised. Each FRF counts by its noise: one that shows little else, as that
of a point which a posture keeps from moving, says little; between several references by the factors of
response and reference that come nearest to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.noise import noise_levels

_GAP = 0.05
"""Part of the circle left free between the last line and the first, which are no neighbours."""


@dataclass(frozen=True, eq=False)
class Lscf:
    """The normal equations of all orders, formed once."""

    omega: Float[np.ndarray, " line"]
    """[rad/s]."""
    delay: float
    """τ [s]."""
    scale: Float[np.ndarray, " reference"]
    """What the FRFs of each reference were divided by."""
    total: Complex[np.ndarray, "power power"]
    """Σ(z^k H)ᴴ(z^m H), power by power and within each reference by reference."""
    halves: Complex[np.ndarray, "response order power"]
    """L⁻¹ZᴴHZ with LLᴴ = ZᴴZ: numerators take halfᴴ half; the leading parts serve each lower order."""

    @property
    def references(self) -> int:
        """Rows of the denominator."""
        return len(self.scale)

    def coefficients(self, order: int) -> Complex[np.ndarray, "coefficient reference reference"]:
        """A's coefficients from the lowest power to the highest, which is the identity."""
        size = self.references
        last = order * size
        taken = self.halves[:, : order + 1, : last + size].reshape(-1, last + size)
        matrix = self.total[: last + size, : last + size] - taken.conj().T @ taken
        free = np.linalg.lstsq(matrix[:last, :last], -matrix[:last, last:], rcond=1e-14)[0]
        return np.concatenate([free.reshape(order, size, size), np.eye(size)[None]])

    def poles(self, order: int) -> Complex[np.ndarray, " pole"]:
        """λ of every root, those of negative damping included [rad/s]."""
        return self.modes(order)[0]

    def modes(self, order: int) -> tuple[Complex[np.ndarray, " pole"], Complex[np.ndarray, "reference pole"]]:
        """λ of every root [rad/s], and the participation factors, the largest of each pole 1."""
        coefficients = self.coefficients(order)
        size = self.references
        if size == 1:
            roots, left = np.roots(coefficients[::-1, 0, 0]), None
        else:
            companion = np.eye(order * size, k=size, dtype=complex)
            companion[-size:] = -np.concatenate([part.T for part in coefficients[:-1]], axis=1)
            roots, vectors = np.linalg.eig(companion)
            left = vectors[:size]
        keep = (np.abs(roots) > 1e-12) & np.isfinite(roots)
        roots = roots[keep]
        # z = exp(−τ(iω − iω₀)) at ω = λ/i
        angle = -np.angle(roots) % (2 * np.pi)
        pole = 1j * self.omega[0] + (-np.log(np.abs(roots)) + 1j * angle) / self.delay
        if left is None:
            return pole, np.ones((1, len(pole)), dtype=complex)
        factors = left[:, keep] * self.scale[:, None]
        place = np.argmax(np.abs(factors), axis=0)
        return pole, factors / factors[place, np.arange(len(pole))]


def form_lscf(measured: Measured, highest: int) -> Lscf:
    """Gather the normal equations of every order up to `highest`.

    Args:
        measured: FRFs of one posture.
        highest: order of the denominator.
    """
    omega = measured.omega
    delay = 2 * np.pi * (1 - _GAP) / (omega[-1] - omega[0])
    value, scale = _weighed(measured)
    # Every block is Toeplitz: its entries are the sums Σ x z^(m−k), so one sum for each difference serves.
    lags = np.arange(-highest, highest + 1)
    powers = np.exp(-1j * delay * np.outer(lags, omega - omega[0]))
    inner = _toeplitz(np.sum(powers, axis=1))
    squares = np.einsum("lra,lrb->lab", value.conj(), value)
    size = value.shape[2]
    blocks = _toeplitz(np.tensordot(powers, squares, axes=1))  # [power power reference reference]
    total = blocks.transpose(0, 2, 1, 3).reshape((highest + 1) * size, -1)
    factor = np.linalg.cholesky(inner + 1e-13 * len(omega) * np.eye(highest + 1))
    products = _toeplitz(np.tensordot(powers, value, axes=1))  # [power power response reference]
    flat = products.transpose(2, 0, 1, 3).reshape(value.shape[1], highest + 1, -1)
    return Lscf(omega, float(delay), scale, total, np.linalg.solve(factor, flat))


def _weighed(measured: Measured) -> tuple[Complex[np.ndarray, "line response reference"], np.ndarray]:
    """FRFs in units of their noise, as matrices where they fill one, and the factor of each reference."""
    noise = noise_levels(measured)
    matrix = measured.matrix
    if matrix is None:
        value = measured.value / noise
        return value[..., None] / np.sqrt(np.mean(np.abs(value) ** 2)), np.ones(1)
    levels = np.log(noise)[matrix]
    middle = levels.mean()
    rows, columns = np.exp(levels.mean(axis=1) - middle / 2), np.exp(levels.mean(axis=0) - middle / 2)
    value = measured.value[:, matrix] / rows[:, None] / columns
    return value / np.sqrt(np.mean(np.abs(value) ** 2)), columns


def _toeplitz(sums: np.ndarray) -> np.ndarray:
    """Entry (k, m) is the sum of lag m − k; lags run from −order to order."""
    order = len(sums) // 2
    place = np.arange(order + 1)
    return sums[order + place[None, :] - place[:, None]]
