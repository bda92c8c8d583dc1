"""What sensors do to a measurement: they weigh, read too much, lag, look askew."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Axis


def _weigh(assembly: Assembly, placement: Placement) -> None:
    for number in np.unique(placement.response[:, 0]).tolist():
        point = placement.context.point(number)
        here = placement["mass"] * (placement.response[:, 0] == number)
        motion = assembly.motion(point.link, np.array(point.xyz))
        for k in range(3):
            assembly.add_inertia(motion[..., k, :], here)


SENSOR_MASS = Effect(
    name="sensor_mass",
    says="the accelerometer weighs on the structure and moves with the measurement from point to point",
    looks_like="resonances that shift from one response point to the next",
    places=lambda context: ("sensor",),
    parameters=lambda context, where: (
        positive("mass", "kg", 0.01 * context.arm_mass, 1.2, 1e-6 * context.arm_mass, context.arm_mass),
    ),
    starts=lambda context, where: [{"mass": 0.005 * context.arm_mass}, {"mass": 0.03 * context.arm_mass}],
    act=_weigh,
    variants=("response",),
    untestable=lambda context: (
        "one response point only: the sensor never moved" if len(context.sensors) < 2 else None
    ),
)


def _gain(placement: Placement, axis: Axis) -> np.ndarray:
    return np.full(len(axis), np.log(placement["gain"]), dtype=complex)


SENSOR_GAIN = Effect(
    name="sensor_gain",
    says="a sensor reads too much or too little",
    looks_like="one point's FRFs off by the same factor at every frequency",
    places=lambda context: context.sensors,
    parameters=lambda context, where: (positive("gain", "", 1.0, 0.3, 0.05, 20.0),),
    starts=lambda context, where: [{"gain": 1.1}],
    read=_gain,
)


DELAYS = (1e-4, 1e-3, 2e-3, 4e-3, 7e-3, 0.011, 0.016)
"""Where fits start [s]: phases beyond half a turn are told apart by these only."""


def _lag(placement: Placement, axis: Axis) -> np.ndarray:
    return -axis.s * placement["delay"]


SENSOR_DELAY = Effect(
    name="time_delay",
    says="a sensor lags",
    looks_like="a phase that falls in proportion to frequency at one point",
    places=lambda context: context.sensors,
    parameters=lambda context, where: (signed("delay", "s", 5e-3, -0.03, 0.03),),
    starts=lambda context, where: [{"delay": delay} for delay in DELAYS],
    read=_lag,
)


def turned(vector: Float[np.ndarray, "*many 3"], way: Float[np.ndarray, "3"]) -> Float[np.ndarray, "*many 3"]:
    """A direction turned by rotation vectors [rad], by Rodrigues' formula."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    k = vector / np.maximum(angle, 1e-300)
    along = (k @ way)[..., None]
    return np.asarray(
        way * np.cos(angle) + np.cross(k, way) * np.sin(angle) + k * along * (1 - np.cos(angle))
    )


def _tilt(context: Context, where: str) -> tuple[Parameter, ...]:
    if context.normal is not None:
        return (signed("angle", "rad", 0.3, -1.4, 1.4),)
    return tuple(signed(f"angle_{axis}", "rad", 0.2, -1.4, 1.4) for axis in "xyz")


def _turn(assembly: Assembly, placement: Placement, point: str, way: np.ndarray) -> np.ndarray:
    """Fixed to its link, so that it turns with the posture."""
    if point != placement.where:
        return way
    context = placement.context
    if context.normal is not None:
        return turned(placement["angle"] * context.normal, way)
    axes = assembly.axes(context.point(point).link)
    return turned(axes @ np.array([placement[f"angle_{axis}"] for axis in "xyz"]), way)


def _tilt_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Channels change their sign with large turns, which a fit does not step over."""
    if context.normal is not None:
        return [{"angle": sign * angle} for angle in (0.1, 0.4, 0.9) for sign in (1, -1)]
    ways = [np.array(way) for way in product((-1, 0, 1), repeat=3) if np.count_nonzero(way) in (1, 3)]
    turns = [angle * way / np.linalg.norm(way) for angle in (0.2, 0.6, 1.0) for way in ways]
    return [dict(zip(("angle_x", "angle_y", "angle_z"), turn.tolist(), strict=True)) for turn in turns]


SENSOR_MISALIGNMENT = Effect(
    name="sensor_misalignment",
    says="a sensor points elsewhere than recorded",
    looks_like="one point's FRFs take in motion of another direction, posture for posture differently",
    places=lambda context: context.sensors,
    parameters=_tilt,
    starts=_tilt_starts,
    turn=_turn,
)
