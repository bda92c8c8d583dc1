"""How alike a measured shape and a model's are, in numbers that a fit can use."""

from __future__ import annotations

import numpy as np


def mac(one: np.ndarray, other: np.ndarray) -> float:
    """Modal assurance criterion of two shapes."""
    size = float(np.sum(np.abs(one) ** 2) * np.sum(np.abs(other) ** 2))
    return float(np.abs(np.vdot(one, other)) ** 2) / size if size > 0 else 0.0


def off_shape(a: np.ndarray, model: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A − P a with a of unit length, |·|² = 1 − MAC, and its derivatives (Kaufman, BIT 15, 1975)."""
    length = max(float(np.linalg.norm(model)), 1e-300)
    unit = model / length
    factor = unit.conj() @ a
    away = a - factor * unit
    turned = slopes / length
    turned = -factor * (turned - np.outer(turned @ unit.conj(), unit))
    return np.concatenate([away.real, away.imag]), np.concatenate([turned.real, turned.imag], axis=1)
