"""The thesis's piecewise model [Hearne 2.6.4, 3.9–3.10]: measured amplitude below a switch, one above.

    α(ω) = Σ_p A_p/(iω − λ_p)  below,    c Σ_p 1/(iω − λ_p)  above,

over all 2n poles of the model, each conjugate with the conjugate multiplier. Poles come from identified
parameters, multipliers A_p from a measurement at one point, since eigenvalues alone do not give
any. The thesis types the switch in (46 Hz); here it is where the model with multipliers is least between its
first two modes. With c = 1 the two halves differ by decades, as in the thesis; `joined` makes them meet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest

GRID = 2001
"""Lines between the first two modes on which the minimum is looked for."""


@dataclass(frozen=True, eq=False)
class PiecewiseModel:
    """Poles, multipliers and where they stop to count."""

    pole: Complex[np.ndarray, " mode"]
    """One of each conjugate pair [rad/s]."""
    multiplier: Complex[np.ndarray, " mode"]
    """A_p [m/(s·N)]."""
    switch: float
    """[Hz]"""
    joined: bool = False
    """Whether the upper half is scaled to meet the lower one at the switch."""

    def receptance(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, " line"]:
        """α; [m/N] below the switch, above it only if `joined`."""
        below = _sum(self.pole, self.multiplier, frequency)
        above = _sum(self.pole, np.ones_like(self.pole), frequency)
        if self.joined:
            at = np.array([self.switch])
            above = above * np.abs(
                _sum(self.pole, self.multiplier, at) / _sum(self.pole, np.ones_like(self.pole), at)
            )
        return np.where(frequency < self.switch, below, above)


def piecewise(
    pole: Complex[np.ndarray, " mode"], multiplier: Complex[np.ndarray, " mode"], *, joined: bool = False
) -> PiecewiseModel:
    """Build the model; the switch is its own minimum between the first two modes.

    Args:
        pole: oscillating modes in the order of frequency, two or more [rad/s].
        multiplier: one for each.
        joined: let the halves meet.

    Raises:
        InvalidRequest: fewer than two modes, or as many multipliers as modes are not given.
    """
    if len(pole) < 2 or len(multiplier) != len(pole):
        found = f"{len(pole)} poles and {len(multiplier)} multipliers"
        raise InvalidRequest(Fault("call", "pole", found, "two oscillating modes or more, a multiplier each"))
    low, high = np.abs(pole[:2]) / (2 * np.pi)
    grid = np.linspace(low, high, GRID)
    size = np.abs(_sum(pole, multiplier, grid))
    return PiecewiseModel(pole, multiplier, float(grid[np.argmin(size)]), joined)


def _sum(
    pole: Complex[np.ndarray, " mode"],
    multiplier: Complex[np.ndarray, " mode"],
    frequency: Float[np.ndarray, " line"],
) -> Complex[np.ndarray, " line"]:
    s = 2j * np.pi * frequency[:, None]
    return (multiplier / (s - pole) + multiplier.conj() / (s - pole.conj())).sum(axis=1)
