"""Torques of the non-linear elements over one step, in numpy; `kernel` has the same in compiled loops.

A law takes its numbers, the elongation before and after the step, the rate of elongation after it and what it
remembers; it gives the torque that resists the elongation, and what it remembers next. Those that remember
are worked out over the distance moved, exactly where the direction holds, so that they stay bounded at any
step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from flexmodal.rig.plant.plant import (
    BACKLASH,
    BOUC_WEN,
    DRAGGED,
    FRICTION,
    HARDENING,
    HERTZ,
    LOADED,
    LUGRE,
    PIECEWISE,
    POLYNOMIAL,
    SATURATING,
    SINH,
    SLIDER,
    STRIBECK,
    WOUND,
)

Law = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def _hardening(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    ratio = (new / p[1]) ** 2
    return p[0] * new * ratio / (1 + ratio), memory


def _friction(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    limit = np.where(new >= old, p[0], -p[0])
    torque = limit + (memory - limit) * np.exp(-p[1] * np.abs(new - old) / p[0])
    return torque, torque


def _backlash(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    pressed, gap = p[0] * new + p[2], p[0] * p[1]
    held = np.where(pressed > 0, pressed, np.where(pressed < -gap, pressed + gap, 0.0))
    return held - p[2] - p[0] * new, memory


def _polynomial(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """p₀ u² + p₁ u³."""
    return (p[0] + p[1] * new) * new**2, memory


def _piecewise(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Stiffer by p₀ beyond ±p₁, by p₂ more beyond ±p₃."""
    size = np.abs(new)
    return np.sign(new) * (p[0] * np.maximum(size - p[1], 0) + p[2] * np.maximum(size - p[3], 0)), memory


def _saturating(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """p₀ tanh(u/p₁) + p₂ u."""
    return p[0] * np.tanh(new / p[1]) + p[2] * new, memory


def _sinh(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """p₀ (p₁ sinh(u/p₁) − u), along its tangent beyond ±p₂ p₁."""
    size = np.abs(new) / p[1]
    inner = np.minimum(size, p[2])
    return np.sign(new) * p[0] * p[1] * (np.sinh(inner) + np.cosh(inner) * (size - inner) - size), memory


def _stribeck(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(p₀ + (p₁ − p₀) exp(−(v/p₂)²)) tanh(v/p₃)."""
    return (p[0] + (p[1] - p[0]) * np.exp(-((speed / p[2]) ** 2))) * np.tanh(speed / p[3]), memory


def _lugre(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bristles: p = σ₀, σ₁, F_c, F_s, v_s. The bristle follows the distance moved, its rate the speed."""
    limit = p[2] + (p[3] - p[2]) * np.exp(-((speed / p[4]) ** 2))
    end = np.where(new >= old, limit, -limit) / p[0]
    bristle = end + (memory - end) * np.exp(-p[0] * np.abs(new - old) / limit)
    rate = speed - p[0] * np.abs(speed) * bristle / limit
    return p[0] * bristle + p[1] * rate, bristle


def _slider(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A spring p₀ that slips at p₁ (Jenkins)."""
    torque = np.clip(memory + p[0] * (new - old), -p[1], p[1])
    return torque, torque


def _bouc_wen(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bouc and Wen with n = 2 and β = γ = ½: elastic p₀ on the way back, z → ±p₁ as tanh on the way out."""
    way = np.where(new >= old, 1.0, -1.0)
    far, part = p[0] / p[1] * np.abs(new - old), way * memory / p[1]
    back = np.minimum(far, np.maximum(-part, 0.0))
    part, gone = part + back, np.tanh(far - back)
    torque = way * p[1] * (part + gone) / (1 + part * gone)
    return torque, torque


def _loaded(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A spring p₀ that slips at p₁ + p₂ |u + p₃|: the more is carried, the later."""
    limit = p[1] + p[2] * np.abs(new + p[3])
    torque = np.clip(memory + p[0] * (new - old), -limit, limit)
    return torque, torque


def _dragged(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A body that slips at p₁, pushed by a spring p₀ beyond a play ±p₂; it remembers where it is."""
    far = p[2] + p[1] / p[0]
    place = np.clip(memory, new - far, new + far)
    off = new - place
    return np.sign(off) * p[0] * np.maximum(np.abs(off) - p[2], 0.0), place


def _hertz(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """p₀ (p₁/3 ((1 + x)^1.5 − (1 − x)^1.5) − u), x = u/p₁: one of two contacts opens beyond ±1."""
    ratio = new / p[1]
    pressed = np.maximum(1 + ratio, 0.0) ** 1.5 - np.maximum(1 - ratio, 0.0) ** 1.5
    return p[0] * (p[1] / 3 * pressed - new), memory


def _wound(
    p: np.ndarray, old: np.ndarray, new: np.ndarray, speed: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The torque of `_hardening` from p₂ on, where it is wound up already."""
    there, rest = ((new + p[2]) / p[1]) ** 2, (p[2] / p[1]) ** 2
    return p[0] * ((new + p[2]) * there / (1 + there) - p[2] * rest / (1 + rest)), memory


LAWS: Mapping[int, Law] = {
    HARDENING: _hardening, FRICTION: _friction, BACKLASH: _backlash, POLYNOMIAL: _polynomial,
    PIECEWISE: _piecewise, SATURATING: _saturating, SINH: _sinh, STRIBECK: _stribeck, LUGRE: _lugre,
    SLIDER: _slider, BOUC_WEN: _bouc_wen, LOADED: _loaded, HERTZ: _hertz, DRAGGED: _dragged,
    WOUND: _wound,
}  # fmt: skip


def steepest(kind: int, p: np.ndarray) -> float:
    """The most that a torque grows with the rate of elongation [N·m·s/rad]; 0 for laws that know no rate.

    Args:
        kind: of the law.
        p: its numbers.
    """
    if kind == STRIBECK:
        return float(max(p[0], p[1]) / p[3])
    return float(p[1]) if kind == LUGRE else 0.0
