"""A sensor that reads too much or too little, alike in all directions; at its next level by each axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, along, positive, sides, signed
from flexmodal.diagnosis.effects.sensor_delay import BUTTERWORTH
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Axis


def mounted(context: Context, point: int, values: Mapping[str, float]) -> np.ndarray:
    """Where the mass centre of a sensor on a point is, in the frame of its link [m].

    Args:
        context: of the campaign.
        point: its id.
        values: among them how far it is off the surface, across the link's axis, and perhaps along it.
    """
    at = context.point(point)
    _, axis = along(context, at.link)
    place = np.array(at.xyz) + values.get("off_along", 0.0) * axis
    for name, side in zip(("off", "off_beside"), sides(context, at.link, axis), strict=False):
        place = place + values[name] * side
    return place


NEAR_NULL = 0.98
"""Of where nothing is left, up to which a droop is followed."""
LEAST_GAIN = 0.02
"""Size of a gain at least, of either sign."""
MIDDLE = 2 * np.pi * 50.0
"""Where a gain that changes with frequency is what its parameter says [rad/s]."""


MOUNTS = 8
"""Frequencies of a mount from which fits start, over the band and somewhat beyond."""
CORNERS = (0.3, 1.0, 4.0)
"""Corners of a high pass from which fits start, over the lowest line."""


STEP, STEP_AT = "step", "step_frequency"
"""What the wider law has besides: the sensitivity far above a frequency over that far below it."""
STEPS = (0.7, 1.4)
"""From which fits start, at some frequencies in the band."""
NOTCH = ("notch_depth", "notch_frequency", "notch_width")
"""Of a notch: the part it takes away in its middle, or adds if that is below 0, where that is, and its ζ."""
DEEP = (0.5, -0.5)
"""Its depths from which fits start, at some frequencies in the band."""
BEYOND = "notch_beyond"
"""The part of what is read that is gone far above it, as of what rocks on an adapter; added if below 0."""
ROCKS = (0.3, -0.3)
"""Such parts from which fits start, at some frequencies in the band."""
DRIFT = "drift"
"""By how much ln of what it reads grows from the first posture to the last, as the sensor warms."""
DRIFTS = (-0.3, 0.3)
"""From which fits start."""
BEND, BENDS = "drift_bend", (0.4, 1.0, 3.0)
"""Power of how much of the campaign is over by which it does so: above 1 ever faster, as on a battery that
runs down; where fits start."""
DROOP, NULL = "droop", "droop_null"
"""What ln of the readings lacks at the band's end without a lag, as behind running means that nobody
equalised, their delay taken out; and where these let nothing through, over the band's end."""
DROOPS = (0.5, -0.3)
"""Such losses from which fits start."""
ORDER = "mount_order"
"""Of the mount's resonance: 1, or -1 where one was taken out of what is read that is not there."""
TAKEN_OUT = (1.1, 2.0, 4.0)
"""Frequencies of such a one from which fits start, over the end of the band."""


def _gain(placement: Placement, axis: Axis) -> np.ndarray:
    """A factor of either sign, a weak power of frequency, a mount that resonates, and a high pass.

    The high pass is 1/(1 + a + p a²) with a = ω_c/s, of first order with p = 0. By the wider law a step of
    the sensitivity besides, (1 + g s/ω)/(1 + s/ω), a lead or a lag; and a notch, as of a hum filter, or peak,
    1 − (d 2ζ a + e a²)/(1 + 2ζ a + a²) with a = s/ω (Horowitz and Hill, The Art of Electronics, 3rd ed.,
    section 6.3), e where something between swings on its own, such as an adapter that rocks on its glue.
    The mount's resonance may have been taken out of readings in which it is not, as by an inverse filter; and
    what it reads may grow or shrink from posture to posture.
    """
    gain = placement["gain"]
    s = np.where(axis.frequency > 0, axis.s, 1j * MIDDLE)
    size = np.log(max(abs(gain), LEAST_GAIN)) + (1j * np.pi if gain < 0 else 0.0)
    slope = placement["exponent"] * np.log(s / (1j * MIDDLE))
    mount = s / (2 * np.pi * placement["mount_frequency"])
    resonance = np.log(1 + 2 * placement["mount_damping_ratio"] * mount + mount**2)
    corner = 2 * np.pi * placement["high_pass"] / s
    passed = np.log1p(corner + placement["high_pass_order"] * corner**2)
    drift = placement.values.get(DRIFT, 0.0)
    if drift:
        size = size + (drift * placement.progress ** placement[BEND])[:, None]
    step: np.ndarray | float = 0.0
    if STEP in placement.values:
        over = s / (2 * np.pi * placement[STEP_AT])
        step = np.log1p(placement[STEP] * over) - np.log1p(over)
        depth, middle, width = (placement[name] for name in NOTCH)
        a = s / (2 * np.pi * middle)
        taken = depth * 2 * width * a + placement[BEYOND] * a**2
        step = step + np.log(1 - taken / (1 + 2 * width * a + a**2)) - _droop(placement, axis)
    order = placement.values.get(ORDER, 1.0)
    return np.asarray(size + slope - order * resonance - passed + step, dtype=complex)


def _droop(placement: Placement, axis: Axis) -> np.ndarray:
    """As ln sinc(f/f₀), which is −(π f/f₀)²/6 at first (Hogenauer, IEEE Trans. ASSP 29, 1981, 155)."""
    high, null = placement.context.band[1], placement[NULL]
    grown = -np.log(np.sinc(np.minimum(axis.frequency / (null * high), NEAR_NULL)))
    return np.asarray(placement[DROOP] * grown / ((np.pi / null) ** 2 / 6))


def _gain_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """A mount and a high pass that do nothing in the band, unless the data ask for them.

    A damping ratio of more than a third is a filter's: that sensor lags.
    """
    low, high = context.band
    return (
        signed("gain", "", 0.3, -20.0, 20.0, centre=1.0),
        signed("exponent", "of frequency", 0.05, -0.6, 0.6),
        positive("mount_frequency", "Hz", 30 * high, 1.5, low, 1e3 * high),
        positive("mount_damping_ratio", "", 0.05, 0.8, 1e-3, 0.35),
        positive("high_pass", "Hz", 1e-3 * low, 2.0, 1e-5 * low, 10 * high),
        signed("high_pass_order", "", 0.3, 0.0, 2.25),
    )


def _gain_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """A mount's resonance is not found from where it does nothing."""
    low, high = context.band
    mounts = np.geomspace(max(2 * low, 0.1 * high), 1.6 * high, MOUNTS).tolist()
    return [
        {"gain": 1.1},
        {"gain": -1.0},
        *({"gain": 1.0, "mount_frequency": one} for one in mounts),
        *({"gain": 1.0, "high_pass": share * low} for share in CORNERS),
        {"gain": 1.0, "high_pass": high},
        *({"gain": 1.0, "high_pass": share * low, "high_pass_order": BUTTERWORTH} for share in CORNERS[:2]),
    ]


SIZES = ("second_sensitivity", "third_sensitivity")
"""Sensitivities along the second and the third axis of a sensor, over that along the first."""
UNLIKE = (0.7, 0.85, 1.15, 1.4)
"""Of one of them, from which fits start."""


def sizes(context: Context) -> list[Parameter]:
    """Sensitivities along the axes but the first: in a plane there is one other.

    Args:
        context: of the diagnosis.
    """
    names = SIZES[:1] if context.normal is not None else SIZES
    return [positive(name, "", 1.0, 0.1, 0.3, 3.0) for name in names]


def axes_of(assembly: Assembly, context: Context, link: str) -> Float[np.ndarray, "*posture 3 3"]:
    """Axes of a sensor on a link, in the world: those of the link; in a plane along it, beside it and out.

    Args:
        assembly: with all coordinates.
        context: of the diagnosis.
        link: its name.
    """
    frame = assembly.axes(link)
    if context.normal is None:
        return frame
    out = frame @ along(context, link)[1]
    normal = np.broadcast_to(context.normal, out.shape)
    return np.stack([out, np.cross(normal, out), normal], axis=-1)


def _by_axis(assembly: Assembly, placement: Placement, point: str, way: np.ndarray) -> np.ndarray:
    """What is read along a direction, from three axes that are not alike."""
    if point != placement.where:
        return way
    frame = axes_of(assembly, placement.context, placement.context.point(point).link)
    size = np.array([1.0, *(placement.values.get(name, 1.0) for name in SIZES)])
    return np.asarray(np.einsum("...ij,j,...kj,...k->...i", frame, size, frame, way))


def _step_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    low, high = context.band
    return (
        *sizes(context),
        *_gain_parameters(context, where),
        positive(STEP, "", 1.0, 0.4, 0.05, 20.0),
        positive(STEP_AT, "Hz", float(np.sqrt(low * high)), 1.0, low / 3, 3 * high),
        signed(NOTCH[0], "", 0.1, -20.0, 0.995),
        positive(NOTCH[1], "Hz", float(np.sqrt(low * high)), 1.0, low / 2, 2 * high),
        positive(NOTCH[2], "", 0.2, 1.0, 0.005, 5.0),
        signed(BEYOND, "", 0.05, -10.0, 10.0),
        signed(ORDER, "", 0.3, -1.2, 1.2, centre=1.0),
        signed(DRIFT, "", 0.1, -3.0, 3.0),
        positive(BEND, "", 1.0, 0.7, 0.1, 10.0),
        signed(DROOP, "", 0.1, -2.0, 3.0),
        positive(NULL, "of the band's end", 4.0, 0.7, 1.1, 50.0),
    )


def _step_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    places = np.geomspace(2 * context.band[0], context.band[1], 4).tolist()
    alone = {"gain": float(np.copysign(1.0, values["gain"])), "exponent": 0.0}
    steps = [{STEP: size, STEP_AT: place} for size in STEPS for place in places]
    names = [one.name for one in sizes(context)]
    by_axis = [
        {**values, **dict.fromkeys(some, size)}
        for count in (1, len(names))
        for some in combinations(names, count)
        for size in UNLIKE
    ]
    middles = np.geomspace(2 * context.band[0], context.band[1], 6).tolist()
    steps += [{NOTCH[0]: depth, NOTCH[1]: middle} for depth in DEEP for middle in middles]
    steps += [{BEYOND: part, NOTCH[1]: middle, NOTCH[2]: 0.04} for part in ROCKS for middle in middles]
    steps += [{ORDER: -1.0, "mount_frequency": share * context.band[1]} for share in TAKEN_OUT]
    drifts = [{**values, DRIFT: drift, BEND: bend} for drift in DRIFTS for bend in BENDS]
    droops = [{**alone, DROOP: droop} for droop in DROOPS]
    return [*by_axis, *drifts, *droops, *({**one, **step} for one in (values, alone) for step in steps)]


STEPPED_GAIN = Effect(
    name="sensor_gain",
    says="a sensor reads too much or too little, or the wrong way round, or its mount resonates",
    places=lambda context: context.sensors,
    parameters=_step_parameters,
    starts=_gain_starts,
    read=_gain,
    turn=_by_axis,
)
SENSOR_GAIN = replace(
    STEPPED_GAIN, parameters=_gain_parameters, turn=None, next_level=Level(STEPPED_GAIN, _step_starts)
)
