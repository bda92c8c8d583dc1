"""What sensors do to a measurement: they read too much, look askew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import product

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
        values: among them how far it is off the surface, across the link's axis.
    """
    at = context.point(point)
    _, axis = along(context, at.link)
    place = np.array(at.xyz)
    for name, side in zip(("off", "off_beside"), sides(context, at.link, axis), strict=False):
        place = place + values[name] * side
    return place


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


def _gain(placement: Placement, axis: Axis) -> np.ndarray:
    """A factor of either sign, a weak power of frequency, a mount that resonates, and a high pass.

    The high pass is 1/(1 + a + p a²) with a = ω_c/s, of first order with p = 0. By the wider law a step of
    the sensitivity, (1 + g s/ω)/(1 + s/ω), besides: a lead or a lag.
    """
    gain = placement["gain"]
    s = np.where(axis.frequency > 0, axis.s, 1j * MIDDLE)
    size = np.log(max(abs(gain), LEAST_GAIN)) + (1j * np.pi if gain < 0 else 0.0)
    slope = placement["exponent"] * np.log(s / (1j * MIDDLE))
    mount = s / (2 * np.pi * placement["mount_frequency"])
    resonance = np.log(1 + 2 * placement["mount_damping_ratio"] * mount + mount**2)
    corner = 2 * np.pi * placement["high_pass"] / s
    passed = np.log1p(corner + placement["high_pass_order"] * corner**2)
    step: np.ndarray | float = 0.0
    if STEP in placement.values:
        over = s / (2 * np.pi * placement[STEP_AT])
        step = np.log1p(placement[STEP] * over) - np.log1p(over)
    return np.asarray(size + slope - resonance - passed + step, dtype=complex)


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


def _step_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    low, high = context.band
    return (
        *_gain_parameters(context, where),
        positive(STEP, "", 1.0, 0.4, 0.05, 20.0),
        positive(STEP_AT, "Hz", float(np.sqrt(low * high)), 1.0, low / 3, 3 * high),
    )


def _step_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    places = np.geomspace(2 * context.band[0], context.band[1], 4).tolist()
    alone = {"gain": float(np.copysign(1.0, values["gain"])), "exponent": 0.0}
    steps = [{STEP: size, STEP_AT: place} for size in STEPS for place in places]
    return [{**one, **step} for one in (values, alone) for step in steps]


STEPPED_GAIN = Effect(
    name="sensor_gain",
    says="a sensor reads too much or too little, or the wrong way round, or its mount resonates",
    places=lambda context: context.sensors,
    parameters=_step_parameters,
    starts=_gain_starts,
    read=_gain,
)
SENSOR_GAIN = replace(STEPPED_GAIN, parameters=_gain_parameters, next_level=Level(STEPPED_GAIN, _step_starts))


def turned(
    vector: Float[np.ndarray, "*#many 3"], way: Float[np.ndarray, "*#many 3"]
) -> Float[np.ndarray, "*many 3"]:
    """Directions turned by rotation vectors [rad], by Rodrigues' formula.

    Args:
        vector: along the axis of each turn, as long as its angle [rad].
        way: directions that are turned, in the same axes.
    """
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    k = vector / np.maximum(angle, 1e-300)
    along = np.sum(k * way, axis=-1, keepdims=True)
    return np.asarray(
        way * np.cos(angle) + np.cross(k, way) * np.sin(angle) + k * along * (1 - np.cos(angle))
    )


def _tilt(context: Context, where: str) -> tuple[Parameter, ...]:
    """Angles, what it reads over what it should besides, and how far it sits off its point."""
    more = (
        positive("sensitivity", "", 1.0, 0.1, 0.3, 3.0),
        signed("off", "m", 0.015, -0.3, 0.3),
        signed("off_along", "m", 0.015, -0.3, 0.3),
    )
    if context.normal is not None:
        return (signed("angle", "rad", 0.3, -1.4, 1.4), *more)
    angles = (signed(f"angle_{axis}", "rad", 0.2, -1.4, 1.4) for axis in "xyz")
    return (*angles, *more, signed("off_beside", "m", 0.015, -0.3, 0.3))


def _turn(assembly: Assembly, placement: Placement, point: str, way: np.ndarray) -> np.ndarray:
    """Fixed to its link, so that it turns with the posture."""
    if point != placement.where:
        return way
    context, size = placement.context, placement["sensitivity"]
    if context.normal is not None:
        return size * turned(placement["angle"] * context.normal, way)
    axes = assembly.axes(context.point(point).link)
    return size * turned(axes @ np.array([placement[f"angle_{axis}"] for axis in "xyz"]), way)


def _aside(placement: Placement, point: str) -> np.ndarray:
    if point != placement.where:
        return np.zeros(3)
    context, at = placement.context, placement.context.point(placement.where)
    _, axis = along(context, at.link)
    off = mounted(context, at.id, placement.values) - np.array(at.xyz)
    return off + placement["off_along"] * axis


def _tilt_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Channels change their sign with large turns, which a fit does not step over."""
    if context.normal is not None:
        return [{"angle": sign * angle} for angle in (0.1, 0.4, 0.9) for sign in (1, -1)]
    ways = [np.array(way) for way in product((-1, 0, 1), repeat=3) if np.count_nonzero(way) in (1, 3)]
    turns = [angle * way / np.linalg.norm(way) for angle in (0.2, 0.6, 1.0) for way in ways]
    return [dict(zip(("angle_x", "angle_y", "angle_z"), turn.tolist(), strict=True)) for turn in turns]


_ACROSS = ("across_1_2", "across_1_3", "across_2_3")
"""Transverse sensitivities: along one axis of the link for a motion along another one, either way round."""
_SIZES = ("second_sensitivity", "third_sensitivity")
"""Sensitivities along the second and the third axis, over that along the first."""
MIRRORED = "mirrored"
"""From 0, nothing, to 1: the first axis the other way round, as with a turn two exchanged channels are."""
ANY, QUARTER = 3.2, np.pi / 2
"""Angle up to which a sensor is turned by the wider law, and the turns of a cube from which fits start: what
is mounted on another of its faces, or read by other cables."""


@cache
def _turns_of_a_cube() -> list[list[float]]:
    """Rotation vectors [rad] of the 24 ways in which a cube can lie."""
    from scipy.spatial.transform import Rotation

    return list(Rotation.create_group("O").as_rotvec().tolist())


def _wide_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Besides: any turn, one axis mirrored, axes neither square nor alike, and a turn of the world.

    That is the same in every posture.
    """
    turns = (
        replace(one, lower=-ANY, upper=ANY) if one.unit == "rad" else one for one in _tilt(context, where)
    )
    planar = context.normal is not None
    across = [signed(name, "", 0.1, -0.8, 0.8) for name in (_ACROSS[:1] if planar else _ACROSS)]
    sizes = [positive(name, "", 1.0, 0.1, 0.3, 3.0) for name in (_SIZES[:1] if planar else _SIZES)]
    lean = [signed(f"lean_{axis}", "rad", 0.2, -1.4, 1.4) for axis in "xyz" if not planar]
    return (*turns, *sizes, *across, signed(MIRRORED, "", 0.15, -0.2, 1.2), *lean)


def _wide_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """Where the turn with the link ended, a turn of the world in place of it, and the turns of a cube.

    In a plane a turn of the world is one with the link.
    """
    if context.normal is not None:
        quarters = [{**values, "angle": angle} for angle in (0.0, QUARTER, -QUARTER, 2 * QUARTER)]
        return [values, *({**one, MIRRORED: side} for side in (0.0, 1.0) for one in quarters)]
    upright = {f"angle_{axis}": 0.0 for axis in "xyz"}
    leans = [{k.replace("angle", "lean"): v for k, v in one.items()} for one in _tilt_starts(context, where)]
    leaning = [{**beside, **lean} for beside in (values, upright) for lean in leans]
    cube = [dict(zip(upright, turn, strict=True)) for turn in _turns_of_a_cube()]
    return [values, *leaning, *({**values, **one, MIRRORED: side} for side in (0.0, 1.0) for one in cube)]


def _stretched(assembly: Assembly, placement: Placement, way: np.ndarray) -> np.ndarray:
    """By a symmetric matrix in the axes of the link; with the turn, any matrix of three axes in one housing.

    Its first axis may be mirrored.

    Transverse sensitivity as of ISO 16063-31. In a plane the axes are along the link and beside it.
    """
    context = placement.context
    link = context.point(placement.where).link
    frame, first = assembly.axes(link), 1 - 2 * placement[MIRRORED]
    if context.normal is None:
        (xy, xz, yz), (y, z) = (placement[name] for name in _ACROSS), (placement[name] for name in _SIZES)
        metric = np.array([[first, xy, xz], [xy, y, yz], [xz, yz, z]])
    else:
        out = frame @ along(context, link)[1]
        normal = np.broadcast_to(context.normal, out.shape)
        frame = np.stack([out, np.cross(normal, out), normal], axis=-1)
        xy, y = placement[_ACROSS[0]], placement[_SIZES[0]]
        metric = np.array([[first, xy, 0.0], [xy, y, 0.0], [0.0, 0.0, 1.0]])
    felt = np.einsum("...ji,...j->...i", frame, way)
    return np.asarray(np.einsum("...ij,jk,...k->...i", frame, metric, felt))


def _widely_turned(assembly: Assembly, placement: Placement, point: str, way: np.ndarray) -> np.ndarray:
    """Stretched and turned on its link, and set up anew in each posture, leaning alike in the world."""
    if point != placement.where:
        return way
    found = _turn(assembly, placement, point, _stretched(assembly, placement, way))
    if placement.context.normal is not None:
        return found
    return turned(np.array([placement[f"lean_{axis}"] for axis in "xyz"]), found)


SENSOR_ASKEW = Effect(
    name="sensor_misalignment",
    says="a sensor points elsewhere than recorded",
    places=lambda context: context.sensors,
    parameters=_wide_parameters,
    starts=_tilt_starts,
    turn=_widely_turned,
    aside=_aside,
)
SENSOR_MISALIGNMENT = replace(
    SENSOR_ASKEW, parameters=_tilt, turn=_turn, next_level=Level(SENSOR_ASKEW, _wide_starts)
)
