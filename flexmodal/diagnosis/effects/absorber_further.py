"""What an absorber has besides at the next level: more modes, and what does not swing.

A further part of it swings faster along its directions, on a foot that does not: a clamped beam has modes
beyond its first ones, and what holds a spring is fixed to the link. And something turns at the place of the
first mass, about the directions across the one in which that gives least: a line that is held at both ends
swings where one half goes to and the other fro.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import positive, signed
from flexmodal.diagnosis.improved.draft import DUST, Draft
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly

FURTHER, FASTER, FOOT, BELOW = "further", "further_ratio", "foot", "below"
"""A mass over the first, its frequency over that of the first, a mass that does not swing, over the first,
and how far the first stands off from them where it gives least."""
GYRATION, TURNS, STILL = "turning", "turning_ratio", "still"
"""Radius of gyration, with the first mass, of what turns, its frequency over that of the first, and the
radius of what turns with the link."""
NO_TURN = 1e-3
"""Radius of gyration [m] that does not count."""
LINE_GYRATIONS = (0.05, 0.15)
"""Of lines that fits start from [m]."""
COORDINATES = (" further", " further across")
TURNING_COORDINATES = (" turning", " turning across")
NOTHING = 0.01
"""Mass over that of the first which is left out of files."""
THIN = 1e-6
"""Moment of inertia of a thin line about itself, over that across it, in files."""

Springs = Sequence[tuple[float, float]]
"""Stiffness and damping of each."""
Values = Mapping[str, float]
Vectors = Float[np.ndarray, "*posture 3"]
Places = tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]


def parameters_beyond() -> tuple[Parameter, ...]:
    """Of what is there besides."""
    return (
        positive(FURTHER, "of the mass", 0.1, 1.5, 1e-4, 5.0),
        positive(FASTER, "of the frequency", 10.0, 1.0, 1.2, 300.0),
        positive(FOOT, "of the mass", 0.03, 1.5, 1e-5, 5.0),
        signed(BELOW, "m", 0.1, -0.5, 0.5),
        positive(GYRATION, "m", 0.01, 1.5, 1e-4, 1.0),
        positive(TURNS, "of the frequency", 2.0, 0.6, 0.2, 10.0),
        positive(STILL, "m", 0.01, 1.5, 1e-4, 1.0),
    )


def starts_beyond() -> list[dict[str, float]]:
    """Where a fit may set out: as beams that are clamped and as lines that are held at both ends."""
    beams = [
        {FURTHER: part, FASTER: ratio, GYRATION: NO_TURN} for part in (0.1, 0.4, 1.0) for ratio in (6.0, 30.0)
    ]
    return [*beams, *({FURTHER: 0.1, FASTER: 3.0, **line} for line in lines())]


def lines() -> list[dict[str, float]]:
    """How lines turn that are held at both ends, whose second mode is twice as fast as the first."""
    return [{GYRATION: size, TURNS: 2.0} for size in LINE_GYRATIONS]


def coordinates(where: str, *, planar: bool) -> list[str]:
    """Names of the coordinates.

    Args:
        where: the link.
        planar: whether the chain is planar, so that whatever turns does so about one direction.
    """
    turning = TURNING_COORDINATES[: 1 if planar else 2]
    return [f"{where} absorber{name}" for name in (*COORDINATES, *turning)]


def add_beyond(
    assembly: Assembly, where: str, ways: Sequence[Vectors], places: Places, values: Values, springs: Springs
) -> None:
    """Add it.

    Args:
        assembly: with the coordinates.
        where: the link.
        ways: the two directions of the first mass and one across both, in the world.
        places: of the first mass and of the further one, in the frame of the link [m].
        values: of the effect.
        springs: of the first mass along its two directions.
    """
    turning = _axes(ways, planar=assembly.normal is not None)
    rows = [assembly.row(name) for name in coordinates(where, planar=assembly.normal is not None)]
    low = assembly.motion(where, places[1])[..., :3, :]
    turned = assembly.motion(where, places[0])[..., 3:, :]
    mass, still = values["mass"], np.zeros_like(rows[0])
    for way, row in zip(ways, (*rows[:2], still), strict=True):
        stands = np.sum(way[..., :, None] * low, axis=-2)
        assembly.add_inertia(stands + row, values[FURTHER] * mass)
        assembly.add_inertia(stands, values[FOOT] * mass)
    for axis, row in zip(turning, rows[2:], strict=True):
        stands = np.sum(axis[..., :, None] * turned, axis=-2)
        assembly.add_inertia(stands + row, values[GYRATION] ** 2 * mass)
        assembly.add_inertia(stands, values[STILL] ** 2 * mass)
    every = [*_further_springs(values, springs), *_turning_springs(values, springs)[: len(turning)]]
    for row, (spring, damper) in zip(rows, every, strict=True):
        assembly.add_spring(row, spring)
        assembly.add_damper(row, damper)


def _axes(ways: Sequence[Vectors], *, planar: bool) -> tuple[Vectors, ...]:
    """What is turned about: each across one of the two directions, in which its end goes to and fro."""
    return (ways[2],) if planar else (ways[1], ways[0])


def _further_springs(values: Values, springs: Springs) -> list[tuple[float, float]]:
    """Of the further mass; its second spring is as many times as stiff as that of the first mass."""
    return _faster(springs, values[FASTER], values[FURTHER])


def _turning_springs(values: Values, springs: Springs) -> list[tuple[float, float]]:
    """Against turning [N·m/rad, N·m·s/rad], likewise."""
    return _faster(springs, values[TURNS], values[GYRATION] ** 2)


def _faster(springs: Springs, times: float, share: float) -> list[tuple[float, float]]:
    """Of so large a share of the mass, or of its inertia, so many times as fast and as damped."""
    return [(share * times**2 * k, share * times * b) for k, b in springs]


def extend_beyond(
    draft: Draft, where: str, ways: Sequence[Vectors], places: Places, values: Values, springs: Springs,
    *, planar: bool,
) -> None:  # fmt: skip
    """Put it into files.

    Args:
        draft: of the robot.
        where: the link.
        ways: the two directions of the first mass and one across both, in the frame of the link.
        places: see `add_beyond`.
        values: of the effect.
        springs: of the first mass along its two directions.
        planar: whether the chain is.
    """
    name, mass, nothing = f"{where}_absorber", values["mass"], np.zeros((3, 3))
    if values[FURTHER] > NOTHING:
        part = Body(values[FURTHER] * mass, places[1], nothing)
        joints = draft.attach(where, part, name=f"{name}_further", slides=tuple(ways[:2]))
        for joint, spring in zip(joints, _further_springs(values, springs), strict=True):
            draft.flexible(joint, *spring)
    if values[FOOT] > NOTHING:
        draft.attach(where, Body(values[FOOT] * mass, places[1], nothing), name=f"{name}_foot")
    thin = np.eye(3) - (1 - THIN) * np.outer(ways[1 if planar else 2], ways[1 if planar else 2])
    dust = DUST * draft.arm_mass
    if values[GYRATION] > NO_TURN:
        axes = _axes(ways, planar=planar)
        part = Body(dust, places[0], values[GYRATION] ** 2 * mass * thin)
        joints = draft.attach(where, part, name=f"{name}_turning", hinges=axes)
        for joint, spring in zip(joints, _turning_springs(values, springs), strict=False):
            draft.flexible(joint, *spring)
    if values[STILL] > NO_TURN:
        draft.attach(where, Body(dust, places[0], values[STILL] ** 2 * mass * thin), name=f"{name}_still")
