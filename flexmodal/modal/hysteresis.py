"""Springs that lose energy by hysteresis: a loss factor that does not depend on the frequency.

K (1 + iη) at every frequency is the usual form, and answers before it is pushed. The causal spring of
constant loss factor is a power law (Bagley and Torvik, J. Rheology 27, 1983),

    K(s) = K (s/ω₀)^β / cos(βπ/2),   β = (2/π) arctan η,

whose real part is K at ω₀. Below a thousandth of ω₀ it is held, so that there is a static stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidSystem

HELD = 1e-3
"""Part of ω₀ below which stiffness and loss no longer fall."""


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """Hysteretic springs of a system, one on each of its coordinates."""

    stiffness: Float[np.ndarray, " dof"]
    """K [N·m/rad, N/m], in the stiffness matrix too."""
    loss_factor: Float[np.ndarray, " dof"]
    """η; 0 for a spring without loss."""
    frequency: float | None = None
    """ω₀/2π [Hz]; None for K (1 + iη) whatever the frequency."""

    def __post_init__(self) -> None:
        faults = []
        for name in ("stiffness", "loss_factor"):
            given = np.array(getattr(self, name), dtype=float)
            given.flags.writeable = False
            object.__setattr__(self, name, given)
            if not np.all(np.isfinite(given) & (given >= 0)):
                faults.append(Fault("system", f"hysteresis: {name}", f"{given}", "finite numbers ≥ 0"))
        if self.frequency is not None and not 0 < self.frequency < np.inf:
            faults.append(Fault("system", "hysteresis: frequency", f"{self.frequency:g}", "a number above 0"))
        if faults:
            raise InvalidSystem(faults)

    def added(self, s: Complex[np.ndarray, " line"]) -> Complex[np.ndarray, "line dof"]:
        """K(s) − K on the diagonal, at complex frequencies of the upper half plane [rad/s]."""
        if self.frequency is None:
            return np.broadcast_to(1j * self.loss_factor * self.stiffness, (len(s), len(self.stiffness)))
        return self.stiffness * (self._power(s) - 1)

    def slope(self, s: Complex[np.ndarray, " line"]) -> Complex[np.ndarray, "line dof"]:
        """Its derivative along s."""
        if self.frequency is None:
            return np.zeros((len(s), len(self.stiffness)), dtype=complex)
        size = np.abs(s)[:, None]
        held = size <= HELD * 2 * np.pi * self.frequency
        beta = self._exponent
        found = self.stiffness * self._power(s) * beta / np.where(held, 1.0, s[:, None])
        return np.where(held, 0.0, found)

    @property
    def _exponent(self) -> Float[np.ndarray, " dof"]:
        return 2 / np.pi * np.arctan(self.loss_factor)

    def _power(self, s: Complex[np.ndarray, " line"]) -> Complex[np.ndarray, "line dof"]:
        assert self.frequency is not None
        omega = 2 * np.pi * self.frequency
        size = np.maximum(np.abs(s), HELD * omega)
        phase = np.where(s == 0, np.pi / 2, np.angle(s))
        log = (np.log(size / omega) + 1j * phase)[:, None]
        return np.exp(self._exponent * log) / np.cos(self._exponent * np.pi / 2)
