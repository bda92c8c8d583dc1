"""Mode coupling: chatter without regeneration, the low-frequency kind that robots know.

The cutting force follows the deflection itself, `F = a W₀ r`, as on ground that no tooth has cut before, or
where the waves of one tooth are gone before the next comes. W₀ is not symmetric, so two modes of nearly the
same frequency that lie askew to the force can feed each other (Tlusty; for robots Pan, Zhang, Zhu and Wang,
Journal of Materials Processing Technology 173 (2006) 301). With one mode there is no such chatter, only
divergence.

The limit follows from the receptance: `1 = a μ(ω)` for an eigenvalue μ of Φ W₀, so wherever an eigenvalue
crosses the positive real axis, at 0 Hz too. The tests hold it against the first depth at which
`M q̈ + C q̇ + (K − a Rᵀ W₀ R) q = 0` has a root on the right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.errors import InvalidFrequencies
from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.branches import branches, eigenvalues
from flexmodal.machining.stability.directional import average, chip_axes
from flexmodal.machining.tip_receptance import TipReceptance

_POLISH = 60


@dataclass(frozen=True)
class ModeCoupling:
    """The first depth of cut at which deflection and force feed each other."""

    depth: float
    """[m]; infinite where no depth does."""
    frequency: float
    """Of the vibration that sets in [Hz]; 0 for divergence, not a number where there is no limit."""


def mode_coupling(tip: TipReceptance, cut: Cut) -> ModeCoupling:
    """The limit from the receptance of the tip.

    Args:
        tip: how the tip gives way.
        cut: the cut.

    Raises:
        SingularResponse: a mode that the tip sees has no damping.
    """
    found = branches(tip, cut)
    crossing = np.flatnonzero((found.at_low.imag <= 0) != (found.at_high.imag <= 0))
    crossing = crossing[(found.at_low.real[crossing] > 0) | (found.at_high.real[crossing] > 0)]
    low, high = found.low[crossing].copy(), found.high[crossing].copy()
    sign = found.at_low.imag[crossing] <= 0
    for _ in range(_POLISH if len(crossing) else 0):
        middle = (low + high) / 2
        before = (found.follow(crossing, middle).imag <= 0) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    frequency = (low + high) / 2
    value = found.follow(crossing, frequency).real if len(crossing) else np.zeros(0)
    still = _static(tip, cut)
    frequency, value = np.append(frequency, np.zeros(len(still))), np.append(value, still)
    if not np.any(value > 0):
        return ModeCoupling(np.inf, np.nan)
    first = int(np.argmax(value))
    return ModeCoupling(float(1 / value[first]), float(frequency[first]))


def _static(tip: TipReceptance, cut: Cut) -> np.ndarray:
    """Real eigenvalues at 0 Hz, none where a measurement says nothing of 0 Hz."""
    try:
        value = eigenvalues(tip, average(cut)[:, : chip_axes(cut)], np.array([0.0]))[0]
    except InvalidFrequencies:
        return np.zeros(0)
    return value.real[np.abs(value.imag) <= 1e-9 * np.max(np.abs(value), initial=0.0)]
