"""A sensor that looks elsewhere than recorded: turned on its link or in the world, askew, axes exchanged.

One that is set anew in each posture along axes of the world may follow its link by a part of the turn that it
has made since the first posture. One that sits on something soft may sag: its weight turns it the farther,
the more level it stands out of its link. And one whose stud comes loose turns from posture to posture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.sensors import SIZES, axes_of, mounted, sizes
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly


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
        return size * turned(placement["angle"] * _loosened(placement, context.normal), way)
    axes = assembly.axes(context.point(point).link)
    vector = axes @ np.array([placement[f"angle_{axis}"] for axis in "xyz"])
    return size * turned(_loosened(placement, vector), way)


def _loosened(placement: Placement, vector: np.ndarray) -> np.ndarray:
    """What of a turn is there in each system, if it came little by little or at once."""
    part, since = placement.values.get(LOOSENS, 0.0), placement.values.get(KNOCKED, ALWAYS)
    if part:
        vector = vector * (1 - part * (1 - placement.progress))[:, None]
    return vector if since == ALWAYS else vector * (placement.progress >= since)[:, None]


def _aside(placement: Placement, point: str) -> np.ndarray:
    if point != placement.where:
        return np.zeros(3)
    at = placement.context.point(placement.where)
    return np.asarray(mounted(placement.context, at.id, placement.values) - np.array(at.xyz))


def _tilt_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    """Channels change their sign with large turns, which a fit does not step over."""
    if context.normal is not None:
        return [{"angle": sign * angle} for angle in (0.1, 0.4, 0.9) for sign in (1, -1)]
    ways = [np.array(way) for way in product((-1, 0, 1), repeat=3) if np.count_nonzero(way) in (1, 3)]
    turns = [angle * way / np.linalg.norm(way) for angle in (0.2, 0.6, 1.0) for way in ways]
    return [dict(zip(("angle_x", "angle_y", "angle_z"), turn.tolist(), strict=True)) for turn in turns]


_ACROSS = ("across_1_2", "across_1_3", "across_2_3")
"""Transverse sensitivities: along one axis of the link for a motion along another one, either way round."""
MIRRORED = "mirrored"
"""From 0, nothing, to 1: the first axis the other way round, as with a turn two exchanged channels are."""
FOLLOWING = "following"
"""Part of the turn of its link since the first posture that it has made too: 0 where it is as recorded."""
FOLLOWED = (-1.0, -0.8, -0.5, -0.25, 0.25, 0.5, 0.8, 1.0)
"""Of it, from which fits start; 0.8 is too far from 1 where links turn by a right angle."""
LOOSENS = "loosens"
"""Part of its turn in the last posture that it has made since the first, as where its stud comes loose."""
LOOSE = (0.8, -1.0)
"""Such parts from which fits start."""
KNOCKED, ALWAYS = "knocked", -0.1
"""How far through the campaign it was when it was turned; before the beginning if it was so always."""
SAGS = 0.3
"""Turn of one that stands out level, from which fits of one that sags start [rad]."""
ANY, QUARTER = 3.2, np.pi / 2
"""Angle up to which a sensor is turned by the wider law, and the turns of a cube from which fits start: what
is mounted on another of its faces, or read by other cables."""


@cache
def _turns_of_a_cube() -> list[list[float]]:
    """Rotation vectors [rad] of the 24 ways in which a cube can lie."""
    from scipy.spatial.transform import Rotation

    return list(Rotation.create_group("O").as_rotvec().tolist())


def _wide_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Besides: any turn, one axis mirrored, axes neither square nor alike, and turns of the world.

    One of these is the same in every posture, one a part of that of the link.
    """
    turns = (
        replace(one, lower=-ANY, upper=ANY) if one.unit == "rad" else one for one in _tilt(context, where)
    )
    planar = context.normal is not None
    across = [signed(name, "", 0.1, -0.8, 0.8) for name in (_ACROSS[:1] if planar else _ACROSS)]
    lean = [signed(f"lean_{axis}", "rad", 0.2, -1.4, 1.4) for axis in "xyz" if not planar]
    return (
        *turns,
        *sizes(context),
        *across,
        signed(MIRRORED, "", 0.15, -0.2, 1.2),
        *lean,
        signed(FOLLOWING, "", 0.2, -1.5, 1.5),
        signed(LOOSENS, "of the turn", 0.3, -3.0, 1.2),
        signed(KNOCKED, "of the campaign", 1.0, ALWAYS, 1.0, centre=ALWAYS),
        *(signed(name, "rad", 0.15, -1.3, 1.3) for name in _sags(context)),
    )


def _sags(context: Context) -> tuple[str, ...]:
    """How far it sags where it stands out level, along axes of its link; in a plane along it and beside."""
    return ("sag_1", "sag_2") if context.normal is not None else ("sag_1", "sag_2", "sag_3")


def _sagged(assembly: Assembly, placement: Placement, way: np.ndarray) -> np.ndarray:
    """Turned about the level axis across how it stands out, as by a weight on a spring that turns."""
    context = placement.context
    size = np.zeros(3)
    for k, name in enumerate(_sags(context)):
        size[k] = placement.values.get(name, 0.0)
    if not size.any():
        return way
    frame = axes_of(assembly, context, context.point(placement.where).link)
    return turned(np.cross(frame @ size, [0.0, 0.0, -1.0]), way)


def _wide_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """Where the turn with the link ended, parts of the link's own turn, turns of the world, those of a cube.

    In a plane a turn of the world is one with the link.
    """
    sags = [{**values, name: way * SAGS} for name in _sags(context) for way in (1, -1)]
    loose = [{**values, **_turned_by(values, 1.5), LOOSENS: part} for part in LOOSE]
    steps = max(len(context.postures) - 1, 1)
    knocks = [
        {**values, **_turned_by(values, size), KNOCKED: (k - 0.5) / steps}
        for k in range(1, steps + 1)
        for size in (1.0, 2.0)
    ]
    follows = [start for part in FOLLOWED for start in ({**values, FOLLOWING: part}, {FOLLOWING: part})]
    if context.normal is not None:
        quarters = [{**values, "angle": angle} for angle in (0.0, QUARTER, -QUARTER, 2 * QUARTER)]
        return [
            values,
            *sags,
            *loose,
            *knocks,
            *follows,
            *({**one, MIRRORED: side} for side in (0.0, 1.0) for one in quarters),
        ]
    upright = {f"angle_{axis}": 0.0 for axis in "xyz"}
    leans = [{k.replace("angle", "lean"): v for k, v in one.items()} for one in _tilt_starts(context, where)]
    leaning = [{**beside, **lean} for beside in (values, upright) for lean in leans]
    cube = [dict(zip(upright, turn, strict=True)) for turn in _turns_of_a_cube()]
    return [
        values,
        *sags,
        *loose,
        *knocks,
        *follows,
        *leaning,
        *({**values, **one, MIRRORED: side} for side in (0.0, 1.0) for one in cube),
    ]


def _turned_by(values: Mapping[str, float], factor: float) -> Mapping[str, float]:
    """Its turn on the link, larger by a factor."""
    return {name: factor * value for name, value in values.items() if name.startswith("angle")}


def _stretched(assembly: Assembly, placement: Placement, way: np.ndarray) -> np.ndarray:
    """By a symmetric matrix in the axes of the link; with the turn, any matrix of three axes in one housing.

    Its first axis may be mirrored.

    Transverse sensitivity as of ISO 16063-31. In a plane the axes are along the link and beside it.
    """
    context = placement.context
    first, y = 1 - 2 * placement[MIRRORED], placement[SIZES[0]]
    if context.normal is None:
        (xy, xz, yz), z = (placement[name] for name in _ACROSS), placement[SIZES[1]]
        metric = np.array([[first, xy, xz], [xy, y, yz], [xz, yz, z]])
    else:
        xy = placement[_ACROSS[0]]
        metric = np.array([[first, xy, 0.0], [xy, y, 0.0], [0.0, 0.0, 1.0]])
    frame = axes_of(assembly, context, context.point(placement.where).link)
    felt = np.einsum("...ji,...j->...i", frame, way)
    return np.asarray(np.einsum("...ij,jk,...k->...i", frame, metric, felt))


def _followed(assembly: Assembly, placement: Placement, way: np.ndarray) -> np.ndarray:
    """By a part of the turn that the link has made since the first posture, about the axis of that."""
    from scipy.spatial.transform import Rotation

    part, link = placement[FOLLOWING], placement.context.point(placement.where).link
    if part == 0.0:
        return way
    now = assembly.axes(link)
    made = Rotation.from_matrix((now @ placement.context.axes(link).T).reshape(-1, 3, 3)).as_rotvec()
    return turned(part * made.reshape(*now.shape[:-2], 3), way)


def _widely_turned(assembly: Assembly, placement: Placement, point: str, way: np.ndarray) -> np.ndarray:
    """Stretched, turned on its link, sagging, and set up anew in each posture, leaning alike in the world."""
    if point != placement.where:
        return way
    followed = _followed(assembly, placement, way)
    found = _turn(assembly, placement, point, _stretched(assembly, placement, followed))
    found = _sagged(assembly, placement, found)
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
