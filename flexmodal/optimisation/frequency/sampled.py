"""Where a receptance that is no rational function is least or greatest: causal hysteretic springs.

Their stiffness is a power of the frequency, so there are no fractions to bound. The slope is exact; its sign
changes are looked for between lines that crowd at poles and antiresonances, and closed in by bisection. Two
of them between neighbouring lines would be missed: nothing is proved.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.frf.receptance import dynamic_stiffness
from flexmodal.modal import SecondOrderSystem
from flexmodal.optimisation.frequency.partial_fractions import roots_at_fixed_loss

_EVEN, _ABOUT = 600, 41
"""Lines spread over the band, and about each pole and antiresonance."""
_ROUNDS = 12
"""Most times that the springs are taken anew at the frequency of a root."""


def slope_per_hertz(
    system: SecondOrderSystem, rows: Float[np.ndarray, "2 dof"], frequency: Float[np.ndarray, " line"]
) -> Float[np.ndarray, " line"]:
    """D ln|α| / df, exactly: dα/dω = −y_uᵀ (dZ/dω) y_v with Z y = jᵀ [1/Hz].

    Args:
        system: mass, damping, stiffness, hysteresis.
        rows: of response and reference.
        frequency: [Hz].
    """
    y = np.linalg.solve(dynamic_stiffness(system, frequency), rows.T.astype(complex)[None])
    omega = 2 * np.pi * frequency
    outer = y[:, :, 0, None] * y[:, None, :, 1]
    change = -2 * omega * np.einsum("lij,ij->l", outer, system.mass)
    change = change + 1j * np.einsum("lij,ij->l", outer, system.damping)
    if system.hysteresis is not None:
        lag = system.hysteresis.slope(1j * omega)
        change = change + 1j * np.einsum("li,li->l", y[:, :, 0] * y[:, :, 1], lag)
    return np.asarray(2 * np.pi * np.real(-change / (y[:, :, 1] @ rows[0])))


def stationary(
    system: SecondOrderSystem, rows: Float[np.ndarray, "2 dof"], low: float, high: float
) -> tuple[Float[np.ndarray, " place"], Bool[np.ndarray, " place"]]:
    """Frequencies inside a band where |α| is stationary, ascending [Hz], and which of them are minima.

    Args:
        system: mass, damping, stiffness, hysteresis.
        rows: of response and reference.
        low: lower end of the band [Hz].
        high: upper end [Hz].
    """
    lines = _lines(system, rows, low, high)
    slope = slope_per_hertz(system, rows, lines)
    crossed = np.flatnonzero(np.sign(slope[:-1]) * np.sign(slope[1:]) < 0)
    below, above, first = lines[crossed], lines[crossed + 1], np.sign(slope[crossed])
    while len(crossed):
        middle = (below + above) / 2
        if np.all((middle == below) | (middle == above)):
            break
        same = np.sign(slope_per_hertz(system, rows, middle)) == first
        below, above = np.where(same, middle, below), np.where(same, above, middle)
    return np.asarray((below + above) / 2), np.asarray(first < 0)


def _lines(system: SecondOrderSystem, rows: np.ndarray, low: float, high: float) -> np.ndarray:
    """Lines from the lower to the upper end of a band, close where the slope may turn fast [Hz]."""
    found = [np.geomspace(max(low, 1e-6 * high), high, _EVEN), np.array([low, high])]
    spread = np.tan(np.linspace(-1.54, 1.54, _ABOUT))
    for centre, width in _roots(system, rows, high):
        found.append((centre + width * spread) / (2 * np.pi))
    lines = np.unique(np.concatenate(found))
    return np.asarray(lines[(lines >= low) & (lines <= high)])


def _roots(system: SecondOrderSystem, rows: np.ndarray, high: float) -> list[tuple[float, float]]:
    """Im s and |Re s| of poles and antiresonances up to about a frequency, springs as they are there."""
    assert system.hysteresis is not None
    places = []
    for kind in range(2):
        start = roots_at_fixed_loss(
            system, system.hysteresis.added(np.array([2j * np.pi * high / 2]))[0], *rows
        )[kind]
        for root in start[(start.imag > 0) & (start.imag < 4 * np.pi * high)]:
            here = complex(root)
            for _ in range(_ROUNDS):
                lag = system.hysteresis.added(np.array([1j * max(here.imag, 1e-9)]))[0]
                again = roots_at_fixed_loss(system, lag, *rows)[kind]
                nearest = complex(again[int(np.argmin(np.abs(again - here)))])
                settled, here = abs(nearest - here) <= 1e-6 * abs(nearest), nearest
                if settled:
                    break
            places.append((here.imag, abs(here.real)))
    return places
