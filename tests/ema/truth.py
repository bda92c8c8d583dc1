"""FRFs with known poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.ema import Measured

POWER = {"receptance": 0, "mobility": 1, "inertance": 2}


@dataclass(frozen=True)
class Truth:
    """Poles and residues, and FRFs from them by a formula of the test's own."""

    frequency: np.ndarray
    damping: np.ndarray
    residue: np.ndarray
    upper: complex = 0.0

    @property
    def pole(self) -> np.ndarray:
        omega = 2 * np.pi * self.frequency
        return -self.damping * omega + 1j * omega * np.sqrt(1 - self.damping**2)

    def frf(self, axis: np.ndarray, form: str = "mobility") -> np.ndarray:
        """[line, frf]."""
        s = 2j * np.pi * axis[:, None, None]
        sum_ = self.residue / (s - self.pole) + self.residue.conj() / (s - self.pole.conj())
        return (sum_.sum(-1) + self.upper) * s[:, :, 0] ** POWER[form]


def noisy(value: np.ndarray, level: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Values with circular noise of `level` times each FRF's maximum, and the variance of it."""
    sigma = level * np.max(np.abs(value), axis=0)
    draw = rng.normal(size=(2, *value.shape)) / np.sqrt(2)
    variance = np.broadcast_to(np.maximum(sigma, 1e-300) ** 2, value.shape).copy()
    return value + sigma * (draw[0] + 1j * draw[1]), variance


def real_modes(frequency: list[float], damping: list[float], amplitude: np.ndarray) -> Truth:
    """Modes with a real multiplier A′ [frf, mode], so that A = A′/(2iω_d)."""
    f, z = np.array(frequency), np.array(damping)
    return Truth(f, z, amplitude / (2j * 2 * np.pi * f * np.sqrt(1 - z**2)))


def measured(
    truth: Truth, axis: np.ndarray, form: str = "mobility", level: float = 0.0, seed: int = 0
) -> Measured:
    value = truth.frf(axis, form)
    if level == 0:
        return Measured(axis, value, form)
    value, variance = noisy(value, level, np.random.default_rng(seed))
    return Measured(axis, value, form, variance)
