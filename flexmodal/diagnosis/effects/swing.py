"""How far a joint swings under a blow, by the believed robot: what a describing function asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context, Place
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.time_domain.pulse import haversine
from flexmodal.identification.spot import in_world, spot_of
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.robot_terms import put_together
from flexmodal.structure.structure import Axis

PHASE = (np.arange(32) + 0.5) * np.pi / 32
"""Of a half turn of a swing."""
_LINES = 1024


@dataclass(frozen=True)
class Swing:
    """Deflection of a joint after a blow."""

    amplitude: float
    """Of the steady vibration that a cubic spring would find as stiff: A² = 4/3 ∫q⁴/∫q² [rad]."""
    omega: float
    """Root of ∫q̇²/∫q² [rad/s]; in the middle of the band of a joint that stands still."""


@lru_cache(maxsize=4096)
def swings(context: Context, posture: int, reference: Place, level: int) -> Mapping[str, Swing]:
    """Swing of every joint under a blow.

    Args:
        context: the believed robot and the test.
        posture: number in the context.
        reference: hammer point and direction.
        level: number of the kind of blow.
    """
    arm, pulse = context.arms[posture], context.pulses[level]
    assembly = Assembly(arm)
    put_together(assembly, {}, arm.bodies)
    rows = assembly.rows(in_world([spot_of(context.point(reference[0]), reference[1])], assembly))
    structure = assembly.close(np.eye(len(assembly.coordinates)), rows)
    high = 2 * context.band[1]
    frequency = np.arange(1, _LINES) * high / _LINES
    y = structure.solve(Axis(frequency, 1.0))[1][:, :, 0]
    spectrum = pulse.peak * haversine(frequency, pulse.length)
    q = np.fft.irfft(np.vstack([np.zeros((1, y.shape[1])), y * spectrum[:, None]]), axis=0)
    speed = np.fft.irfft(
        np.vstack([np.zeros((1, y.shape[1])), y * (2j * np.pi * frequency * spectrum)[:, None]]), axis=0
    )
    q, speed = q * 2 * high, speed * 2 * high  # irfft is a sum over lines; the integral has df = 1/(N dt)
    square, fourth, fast = (q**2).sum(axis=0), (q**4).sum(axis=0), (speed**2).sum(axis=0)
    still = 2 * np.pi * float(np.sqrt(context.band[0] * context.band[1]))
    return {
        name: Swing(float(np.sqrt(4 / 3 * fourth[k] / square[k])), float(np.sqrt(fast[k] / square[k])))
        if square[k] > 0
        else Swing(0.0, still)
        for k, name in enumerate(arm.robot.joints)
    }


def swing_of(placement: Placement) -> tuple[Float[np.ndarray, " system"], Float[np.ndarray, " system"]]:
    """Amplitude and frequency of the joint's swing in each system, see `Swing`.

    Args:
        placement: of an effect in a joint; its `reach` is a factor on the amplitude.
    """
    found = [
        swings(placement.context, posture, (struck[0], struck[1]), level)[placement.where]
        for posture, struck, level in zip(
            placement.posture.tolist(), placement.reference.tolist(), placement.level.tolist(), strict=True
        )
    ]
    amplitude, omega = np.array([(one.amplitude, one.omega) for one in found]).T
    return amplitude * placement.values.get("reach", 1.0), omega


def bent(
    amplitude: Float[np.ndarray, "*many"], softness: float, wound: float | Float[np.ndarray, "*many"]
) -> Float[np.ndarray, "*many"]:
    """Part of what a knee adds that an amplitude sees.

    Args:
        amplitude: over the deflection of the knee.
        softness: over how many deflections it is rounded.
        wound: elongation about which it swings, over the deflection.
    """
    a, wave = np.maximum(amplitude, 1e-4), np.cos(PHASE)
    u = np.asarray(wound)[..., None] + a[..., None] * wave
    torque = u * (1 - 2 / (np.hypot(u - 1, softness) + np.hypot(u + 1, softness)))
    return np.asarray(2 / len(PHASE) * np.sum(torque * wave, axis=-1) / a)


def joint_stiffness(placement: Placement) -> float:
    """Of the joint's own spring, as it is fitted [N·m/rad].

    Args:
        placement: at a joint.
    """
    where = placement.where
    return placement.values.get(f"stiffness.{where}", float(placement.context.robot.joints[where].stiffness))


def typical(context: Context, where: str) -> tuple[float, float]:
    """Swing of a joint under the blows of the campaign [rad], and its speed [rad/s], geometric means.

    Args:
        context: the believed robot and the test.
        where: the joint.
    """
    every = [
        swings(context, 0, reference, level)[where]
        for level in context.levels
        for reference in context.references
    ]
    found = [(one.amplitude, one.amplitude * one.omega) for one in every]
    size, speed = np.exp(np.mean(np.log(np.maximum(found, 1e-300)), axis=0)).tolist()
    return size, speed


def largest(context: Context, where: str) -> float:
    """The largest swing of a joint under any blow of the campaign [rad].

    Args:
        context: the believed robot and the test.
        where: the joint.
    """
    postures = range(len(context.arms))
    return max(
        swings(context, posture, reference, level)[where].amplitude
        for posture, level, reference in product(postures, context.levels, context.references)
    )


def one_level(context: Context) -> str | None:
    """Why what depends on force cannot be told, if it cannot."""
    return "one level of force only: what depends on it cannot be told" if context.level_count < 2 else None
