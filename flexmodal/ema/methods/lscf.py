"""Least squares complex frequency: poles of a common denominator, at every order up to the highest.

The FRFs are fitted as B_j(z)/A(z) with z = exp(−iτ(ω − ω₀)), both polynomials with complex coefficients
and the band mapped onto the whole circle, which keeps the normal equations well conditioned at any
order. Minimising Σ|A(z)H_j − B_j(z)|² is linear; eliminating the B_j leaves one small matrix, and what is
needed for the highest order holds that of every lower one (Guillaume, Verboven, Vanlanduit and others,
1998–2003). The
highest coefficient of A is held at 1, which pushes the poles that only follow the noise to negative
damping, where they are recognised. Each FRF counts by its noise: one that shows little else, as that of a
point which a posture keeps from moving, says little.
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
    total: Complex[np.ndarray, "power power"]
    """ZᴴΣ|H|²Z."""
    halves: Complex[np.ndarray, "frf power power"]
    """L⁻¹ZᴴHZ with LLᴴ = ZᴴZ: numerators take halfᴴ half; the leading rows serve each lower order."""

    def coefficients(self, order: int) -> Complex[np.ndarray, " coefficient"]:
        """A's coefficients from the lowest power to the highest, which is 1."""
        taken = self.halves[:, : order + 1, : order + 1].reshape(-1, order + 1)
        matrix = self.total[: order + 1, : order + 1] - taken.conj().T @ taken
        return np.append(np.linalg.lstsq(matrix[:order, :order], -matrix[:order, order], rcond=1e-14)[0], 1.0)

    def poles(self, order: int) -> Complex[np.ndarray, " pole"]:
        """λ of every root, those of negative damping included [rad/s]."""
        roots = np.roots(self.coefficients(order)[::-1])
        roots = roots[(np.abs(roots) > 1e-12) & np.isfinite(roots)]
        # z = exp(−τ(iω − iω₀)) at ω = λ/i
        angle = -np.angle(roots) % (2 * np.pi)
        return 1j * self.omega[0] + (-np.log(np.abs(roots)) + 1j * angle) / self.delay


def form_lscf(measured: Measured, highest: int) -> Lscf:
    """Gather the normal equations of every order up to `highest`.

    Args:
        measured: FRFs of one posture.
        highest: order of the denominator.
    """
    omega = measured.omega
    delay = 2 * np.pi * (1 - _GAP) / (omega[-1] - omega[0])
    value = measured.value / noise_levels(measured)
    value = value / np.sqrt(np.mean(np.abs(value) ** 2))
    # Every block is Toeplitz: its entries are the sums Σ x z^(m−k), so one sum for each difference serves.
    lags = np.arange(-highest, highest + 1)
    powers = np.exp(-1j * delay * np.outer(lags, omega - omega[0]))
    inner = _toeplitz(np.sum(powers, axis=1))
    total = _toeplitz(powers @ np.sum(np.abs(value) ** 2, axis=1))
    factor = np.linalg.cholesky(inner + 1e-13 * len(omega) * np.eye(highest + 1))
    halves = np.linalg.solve(factor, np.stack([_toeplitz(sums) for sums in (powers @ value).T]))
    return Lscf(omega, float(delay), total, halves)


def _toeplitz(sums: np.ndarray) -> np.ndarray:
    """Entry (k, m) is the sum of lag m − k; lags run from −order to order."""
    order = len(sums) // 2
    place = np.arange(order + 1)
    return sums[order + place[None, :] - place[:, None]]
