"""A joint with its torques, swung steadily to and fro: what it feels like, amplitude by amplitude.

The first harmonic of the torque over that of the deflection is a complex stiffness, its real part a spring
and its imaginary part a loss (Gelb and Vander Velde, Multiple-Input Describing Functions, 1968).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.time_domain.law import FRICTION, SLOW, Law
from flexmodal.diagnosis.time_domain.numpy_form import law

STEPS, TURNS = 400, 4
"""Steps of a turn, and how many turns are gone through: a loop of friction closes after the first."""
ROUNDING = 1e-12
"""Loss factor below which there is none."""


@dataclass(frozen=True, eq=False)
class Swung:
    """Spring and torques of a joint in steady swings."""

    amplitude: Float[np.ndarray, " amplitude"]
    """[rad, m]"""
    deflection: Float[np.ndarray, "amplitude time"]
    """In the last turn; the first value comes again at the end [rad, m]."""
    torque: Float[np.ndarray, "amplitude time"]
    """[N·m, N]"""
    stiffness: Float[np.ndarray, " amplitude"]
    """Of the first harmonic [N·m/rad, N/m]."""
    loss_factor: Float[np.ndarray, " amplitude"]
    straight: float
    """Stiffness of the spring without the torques [N·m/rad, N/m]."""


def swung(
    laws: Sequence[Law], stiffness: float, amplitude: Float[np.ndarray, " amplitude"], omega: float
) -> Swung:
    """Go to and fro.

    Args:
        laws: torques of the joint, beside a straight spring.
        stiffness: of that spring [N·m/rad, N/m].
        amplitude: of the swings [rad, m].
        omega: their angular frequency [rad/s].
    """
    phase = 2 * np.pi * np.arange(TURNS * STEPS + 1) / STEPS
    step = 2 * np.pi / STEPS / omega
    q = amplitude[:, None] * np.sin(phase)
    speed = omega * amplitude[:, None] * np.cos(phase)
    torque = stiffness * q
    for one in laws:
        torque += _torque(one, q, speed, step)
    last = slice(-STEPS - 1, None)
    wave = torque[:, -STEPS:] @ np.exp(-1j * phase[-STEPS:]) * 2j / STEPS  # over the sine
    felt = wave / amplitude
    loss = felt.imag / felt.real
    loss = np.where(np.abs(loss) < ROUNDING, 0.0, loss)
    return Swung(amplitude, q[:, last], torque[:, last], felt.real, loss, stiffness)


def _torque(one: Law, q: np.ndarray, speed: np.ndarray, step: float) -> np.ndarray:
    p = np.tile(np.array(one.parameters, dtype=float), (len(q), 1))
    if one.kind == FRICTION:
        p[:, 4] *= step
    found, held = np.zeros_like(q), np.zeros(len(q))
    for n in range(1, q.shape[1]):
        now = speed[:, n] if one.kind == SLOW else q[:, n]
        new, _ = law(one.kind, p, q[:, n - 1], now, held)
        lag = one.parameters[5] / step if one.kind == FRICTION else 0.0
        found[:, n], held = new + lag * (new - held), new
    return found
