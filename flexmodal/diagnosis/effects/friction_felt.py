"""What a swing feels of friction: describing functions, and the mean of what grows with a load."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.swing import PHASE

_STEPS, _CLOSED = 50, 1e-15
"""Most steps to where a loop closes, and what it may miss by."""
_STICKS = 1e-6
"""Of the elongation at which friction slides, up to which it is a spring."""


def dahl(
    amplitude: Float[np.ndarray, "*many"],
    torque: float | Float[np.ndarray, "*many"],
    presliding: float,
    exponent: float = 1.0,
) -> tuple[Float[np.ndarray, "*many"], Float[np.ndarray, "*many"]]:
    """Stiffness and loss (torque a radian, in and out of phase) of Dahl's friction at an amplitude.

    On the way up from −A the part of the way to sliding that is left, r = 1 − F/F_c, falls as
    dr/dq = −(σ/F_c) rⁱ; where it starts follows from that loops close. One that hardly swings
    sticks: what it does there stands for all smaller amplitudes.

    Args:
        amplitude: of the swing [rad].
        torque: F_c, at which the joint slides [N·m].
        presliding: σ, stiffness while it sticks [N·m/rad].
        exponent: i; 1 approaches sliding exponentially.
    """
    amplitude = np.maximum(amplitude, _STICKS * np.asarray(torque) / presliding)
    size = np.minimum(presliding * amplitude / torque, 300.0)
    power = 1 - exponent

    def left(start: np.ndarray, way: np.ndarray) -> np.ndarray:
        if abs(power) < 1e-9:
            return np.asarray(start * np.exp(-way))
        return np.asarray(np.maximum(start**power - power * way, 0.0) ** (1 / power))

    start = _closing(left, size, exponent)
    q = -np.cos(PHASE)  # from −A to A
    most = np.asarray(torque)[..., None]
    force = most * (1 - left(start[..., None], size[..., None] * (q + 1)))
    stiffness = 2 / len(PHASE) * np.sum(force * q, axis=-1) / amplitude
    loss = 2 / len(PHASE) * np.sum(force * np.sin(PHASE), axis=-1) / amplitude
    return stiffness, loss


def _closing(
    left: Callable[[np.ndarray, np.ndarray], np.ndarray], size: Float[np.ndarray, "*many"], exponent: float
) -> Float[np.ndarray, "*many"]:
    """Where r starts so that it ends at 2 − r: at 1 + F₀/F_c and 1 − F₀/F_c, by Newton's method in a bracket.

    With r′ = −rⁱ the derivative of the end along the start is (end / start)ⁱ.
    """
    low, high = np.ones_like(size), np.full_like(size, 2.0)
    start = np.full_like(size, 1.5)
    for _ in range(_STEPS):
        end = left(start, 2 * size)
        missed = start + end - 2
        low, high = np.where(missed < 0, start, low), np.where(missed < 0, high, start)
        nearer = start - missed / (1 + (end / start) ** exponent)
        inside = (nearer >= low) & (nearer <= high)
        start = np.where(inside, nearer, (low + high) / 2)
        if np.all(np.abs(missed) <= _CLOSED):
            break
    return start


def mean_load(amplitude: Float[np.ndarray, "*many"], wound: float) -> Float[np.ndarray, "*many"]:
    """Of |q + u₀| over the way from −A to A, so that what is lost in a turn is right.

    Args:
        amplitude: A [rad].
        wound: u₀ [rad].
    """
    within = np.maximum(np.maximum(amplitude, abs(wound)), 1e-300)  # else it is |u₀| all the way
    return np.asarray(np.where(amplitude > abs(wound), (within**2 + wound**2) / (2 * within), abs(wound)))


def levelling(speed: Float[np.ndarray, "*many"], torque: float, slow: float) -> Float[np.ndarray, "*many"]:
    """Damping that a swing feels of T tanh(v/v_t).

    Args:
        speed: largest in the swing [rad/s].
        torque: T [N·m].
        slow: v_t [rad/s].
    """
    wave, most = np.sin(PHASE), np.maximum(speed, 1e-12 * slow)
    felt = np.tanh(most[..., None] * wave / slow)
    return np.asarray(2 / len(PHASE) * torque * np.sum(felt * wave, axis=-1) / most)
