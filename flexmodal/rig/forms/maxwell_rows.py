"""Laws of loss as rows of Maxwell elements, hence causal and passive.

Each is scaled so that the real part is 1 at the middle of the band, on a logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

_BEYOND = 30.0
"""How far the rates of a fractional derivative go beyond the band, as a factor."""
MOST = 1e6
"""Stiffness that relaxes over the one that stays."""


@dataclass(frozen=True, eq=False)
class Series:
    """A spring, a damper and Maxwell elements side by side, over the stiffness at the middle of the band."""

    static: float
    strengths: np.ndarray
    times: np.ndarray
    """Relaxation times [s]."""
    damper: float = 0.0
    """[s]"""

    def modulus(self, omega: np.ndarray) -> np.ndarray:
        """Complex stiffness at angular frequencies [rad/s]."""
        lag = 1j * omega[:, None] * self.times
        return self.static + (lag / (1 + lag)) @ self.strengths + 1j * omega * self.damper

    def scaled_at(self, omega: float) -> Series:
        """The same with a real part of 1 at an angular frequency [rad/s]."""
        size = float(self.modulus(np.array([omega]))[0].real)
        return Series(self.static / size, self.strengths / size, self.times, self.damper / size)


def middle(band: tuple[float, float]) -> float:
    """Middle of a band on a logarithmic scale, as an angular frequency [rad/s]."""
    return float(2 * np.pi * np.sqrt(band[0] * band[1]))


def fitted(
    loss: Callable[[np.ndarray], np.ndarray], band: tuple[float, float], count: int, beyond: float
) -> Series:
    """Maxwell elements whose loss factor comes nearest to a given one over the band.

    Args:
        loss: loss factor by angular frequency [rad/s].
        band: where it is to hold [Hz].
        count: of the elements.
        beyond: by what factor their times go beyond the band on both sides.
    """
    from scipy.optimize import nnls

    low, high = 2 * np.pi * band[0], 2 * np.pi * band[1]
    times = 1 / np.geomspace(low / beyond, high * beyond, count)
    omega = np.geomspace(low, high, 120)
    lag, wanted = omega[:, None] * times, loss(omega)
    real, imaginary = lag**2 / (1 + lag**2), lag / (1 + lag**2)
    strengths, _ = nnls(imaginary - wanted[:, None] * real, wanted)
    return Series(1.0, strengths, times).scaled_at(middle(band))


def power_law(loss: float, exponent: float, band: tuple[float, float]) -> Series:
    """η (ω/ω₀)ⁿ with ω₀ at the middle of the band.

    Args:
        loss: η at the middle.
        exponent: n.
        band: where it holds [Hz].
    """
    return fitted(lambda omega: loss * (omega / middle(band)) ** exponent, band, 11, 6.0)


def zener(loss: float, frequency: float, band: tuple[float, float]) -> Series:
    """The standard linear solid: one element, the largest loss factor at one frequency.

    With strength g over the static spring: η_max = g / (2 √(1 + g)) at ω τ = 1/√(1 + g).

    Args:
        loss: η_max.
        frequency: where it peaks [Hz].
        band: of the campaign [Hz].
    """
    strength = 2 * loss * (loss + np.sqrt(1 + loss**2))
    time = 1 / (2 * np.pi * frequency * np.sqrt(1 + strength))
    return Series(1.0, np.array([strength]), np.array([time])).scaled_at(middle(band))


def two_peaks(loss: float, low: float, apart: float, second: float, band: tuple[float, float]) -> Series:
    """Two Maxwell elements beside the spring, whose loss factor at its largest is given.

    Args:
        loss: the largest in the band.
        low: where the first relaxes, as a part of the way through the band on a logarithmic scale.
        apart: how much further the second does.
        second: its strength over the first.
        band: of the campaign [Hz].
    """
    start, wide = np.log(2 * np.pi * band[0]), np.log(band[1] / band[0])
    times = np.exp(-(start + wide * np.array([low, low + apart])))
    omega = 2 * np.pi * np.geomspace(*band, 60)

    def made(size: float) -> Series:
        return Series(1.0, size * np.array([1.0, second]), times)

    def over(size: float) -> float:
        value = made(size).modulus(omega)
        return float((value.imag / value.real).max()) - abs(loss)

    from scipy.optimize import brentq

    size = float(np.sign(loss)) * float(brentq(over, 0.0, 1e3))
    return made(size).scaled_at(middle(band))


def cole_cole(loss: float, frequency: float, order: float, band: tuple[float, float]) -> Series:
    """A relaxation of a spread of times: 1 + g (iωτ)^α/(1 + (iωτ)^α), the largest loss factor given.

    Args:
        loss: the largest, as far as α allows: tan(απ/2) at most.
        frequency: 1/(2πτ) [Hz].
        order: α, between 0 and 1.
        band: of the campaign [Hz].
    """
    from scipy.optimize import brentq

    def lost(omega: np.ndarray, size: float) -> np.ndarray:
        turned = (1j * omega / (2 * np.pi * frequency)) ** order
        value = 1 + size * turned / (1 + turned)
        return np.asarray(value.imag / value.real)

    every = 2 * np.pi * frequency * np.geomspace(1e-4, 1e4, 400)
    size = MOST
    if lost(every, MOST).max() > abs(loss):
        size = float(brentq(lambda size: lost(every, size).max() - abs(loss), 0.0, MOST))
    return fitted(lambda omega: np.sign(loss) * lost(omega, size), band, 11, 6.0)


def biot(loss: float, frequency: float, band: tuple[float, float]) -> Series:
    """Relaxations that are spread evenly over all faster ones: 1 + (2 η/π) ln(1 + iω/ε).

    The loss sets in about ε, from where on it is nearly the same; below it the material is elastic.

    Args:
        loss: η.
        frequency: ε/(2π) [Hz].
        band: of the campaign [Hz].
    """

    def lost(omega: np.ndarray) -> np.ndarray:
        value = 1 + 2 * loss / np.pi * np.log(1 + 1j * omega / (2 * np.pi * frequency))
        return np.asarray(value.imag / value.real)

    return fitted(lost, band, 11, 6.0)


def fractional(loss: float, order: float, band: tuple[float, float]) -> Series:
    """Kelvin and Voigt with a derivative of order α: 1 + c (iω)^α.

    (iω)^α = sin(απ)/π ∫ x^{α−1} iω/(iω + x) dx over x from 0: Maxwell elements of every rate x, here two a
    decade over a decade and a half more than the band on both sides; what is slower is a spring, what is
    faster a damper.

    Args:
        loss: loss factor at the middle of the band.
        order: α, between 0 and 1.
        band: of the campaign [Hz].
    """
    step, part = np.log(10) / 2, np.sin(order * np.pi) / np.pi
    low, high = 2 * np.pi * band[0] / _BEYOND, 2 * np.pi * band[1] * _BEYOND
    rates = np.exp(np.arange(np.log(low), np.log(high) + step / 2, step))
    slow, fast = rates[0] * np.exp(-step / 2), rates[-1] * np.exp(step / 2)
    static, damper = part / order * slow**order, part / (1 - order) * fast ** (order - 1)
    unit = Series(float(static), part * rates**order * step, 1 / rates, float(damper))
    value = unit.modulus(np.array([middle(band)]))[0]
    size = loss / (value.imag - loss * value.real)
    return Series(1.0 + size * static, size * unit.strengths, unit.times, size * unit.damper).scaled_at(
        middle(band)
    )
