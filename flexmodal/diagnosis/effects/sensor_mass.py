"""The sensor that goes from point to point weighs on what it measures.

It sits off the surface, and a part of its cable is taped to the link. At the next level it sits on a mount
that gives, equally each way, while what is measured moves with the surface, or a part of it does, as of a
sensor that a hand presses on, or as of one whose cable stands out along the link and whips, which gives
across that alone; and its cable hangs in the air and holds it, as a spring and a damper to the
surroundings, or is laid along the arm down to the base, a line of mass on each link. Pads for it may stay
on every point. Beyond that several may
move on together, see `sensor_sets`. ISO 5348 (mounting of
accelerometers); McConnell and Varoto, Vibration Testing, 2nd ed., Wiley 2008, chapter 4 (cables).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, along, positive, signed
from flexmodal.diagnosis.effects.sensor_sets import SIZES, weigh
from flexmodal.diagnosis.effects.sensors import mounted
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

HELD = (0.02, 0.1, 0.4)
"""Frequencies from which fits start of a sensor on its cable, over the end of the band."""
MOUNTS = (0.5, 0.8, 1.2, 2.0, 4.0)
"""The same of a sensor on its mount."""
RIGID = 50.0
"""The same of a mount that does not give."""
LAID = (0.3, 1.5)
"""Mass of a cable that is laid down the whole arm, over the sensor's, from which fits start."""
LEAST = 0.05
"""Length of an arm at least, for what a cable weighs a metre [m]."""
HANDS = (12.0, 30.0)
"""Frequencies of a hand that presses a sensor on, from which fits start [Hz] (ISO 10068)."""
WHIPS, STANDS_OUT = (0.1, 0.2, 0.4), 0.1
"""Frequencies of a cable that whips, from which fits start, over the end of the band, and how far out [m]."""
STIFFER = 30.0
"""Frequency along the link over that across it of what whips."""
PADS, PADDED, SMALLER = "pads", (0.1, 0.4), (0.5, 1.0)
"""Mass of a pad that stays on every point where a sensor has been or will be, over the sensor's, from which
fits start; and the sensor's, over that of one without pads."""
COORDINATES = tuple(f"sensor mount {axis}" for axis in "xyz")
"""Of the mass against the surface."""


def _weigh(assembly: Assembly, placement: Placement) -> None:
    """The sensor off the surface, and a part of its cable that is taped down at the link's origin."""
    motion, foot = carried_along(assembly, placement)
    for k in range(3):
        assembly.add_inertia(motion[:, k], placement["mass"])
        _weigh_besides(assembly, placement, motion[:, k + 3], foot[:, k])


def _weigh_besides(assembly: Assembly, placement: Placement, turn: np.ndarray, foot: np.ndarray) -> None:
    """What turns with the surface about an axis, and the taped part of the cable along it."""
    assembly.add_inertia(turn, placement["mass"] * placement["gyration"] ** 2)
    assembly.add_inertia(foot, placement["mass"] * placement["cable"])


def carried_along(assembly: Assembly, placement: Placement) -> Float[np.ndarray, "2 system 6 dof"]:
    """How the sensor that each system is seen by moves, and the origin of the link it is on.

    Args:
        assembly: with all motions.
        placement: with how far off the surface it sits.
    """
    found = np.zeros((2, len(placement.posture), 6, len(assembly.coordinates)))
    for number in np.unique(placement.response[:, 0]).tolist():
        point, here = placement.context.point(number), placement.response[:, 0] == number
        place = mounted(placement.context, number, placement.values)
        found[0, here] = assembly.motion(point.link, place)[here]
        found[1, here] = assembly.motion(point.link, np.zeros(3))[here]
    return found


def _sensor_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    mass = context.arm_mass
    found = [
        positive("mass", "kg", 0.01 * mass, 1.2, 1e-6 * mass, mass),
        signed("off", "m", 0.03, -0.3, 0.3),
        positive("gyration", "m", 0.01, 1.0, 1e-4, 0.3),
        positive("cable", "", 0.01, 2.0, 1e-4, 3.0),
    ]
    if context.normal is None:
        found.append(signed("off_beside", "m", 0.03, -0.3, 0.3))
    return tuple(found)


def _held_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """A mount and a cable that do nothing in the band, unless the data ask for them."""
    (low, high), mass = context.band, context.arm_mass / _whole_length(context)
    return (
        *_sensor_parameters(context, where),
        positive("mount_frequency", "Hz", RIGID * high, 1.5, low, 500 * high),
        positive("mount_damping_ratio", "", 0.05, 0.8, 1e-3, 2.0),
        positive("cable_frequency", "Hz", 1e-2 * low, 2.0, 1e-5 * low, 2 * high),
        positive("cable_damping_ratio", "", 0.2, 1.0, 1e-3, 20.0),
        positive("firm", "", 1e-3, 2.0, 1e-5, 50.0),
        positive("line_mass", "kg/m", 1e-4 * mass, 2.0, 1e-7 * mass, 3 * mass),
        positive("along_ratio", "", 1.0, 1.5, 0.2, 1e3),
        signed("off_along", "m", 0.05, -0.4, 0.4),
        positive(PADS, "of the sensor", 1e-4, 2.5, 1e-7, 3.0),
    )


def _held_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """Neither a cable nor a mount's resonance is found from where it does nothing."""
    high, length = context.band[1], _whole_length(context)
    hung: list[Mapping[str, float]] = [{**values, "cable_frequency": share * high} for share in HELD]
    laid = [{**values, "line_mass": share * values["mass"] / length} for share in LAID]
    pressed = [
        {
            **values,
            "firm": share,
            "mass": values["mass"] / share,
            "mount_frequency": own,
            "mount_damping_ratio": 0.5,
        }
        for own in HANDS
        for share in (0.7, 1.5)
    ]
    whipping = [
        {**values, "firm": 1.0, "mount_frequency": share * high, "along_ratio": STIFFER, "off_along": out}
        for share in WHIPS
        for out in (STANDS_OUT, -STANDS_OUT)
    ]
    mounts = [{**values, "mount_frequency": share * high} for share in MOUNTS]
    padded = [{**values, PADS: share, "mass": size * values["mass"]} for share in PADDED for size in SMALLER]
    return [*hung, *mounts, *laid, *pressed, *whipping, *padded]


def _whole_length(context: Context) -> float:
    """Of the arm, joint by joint [m]."""
    return max(sum(float(np.linalg.norm(joint.xyz)) for joint in context.robot.urdf.joints), LEAST)


@lru_cache(maxsize=256)
def _laid(context: Context, point: int) -> tuple[tuple[str, np.ndarray], ...]:
    """Links from a point down to the base, and where on each the cable that comes from its frame ends."""
    at, before = context.point(point), {joint.child: joint for joint in context.robot.urdf.joints}
    found = [(at.link, np.array(at.xyz))]
    while found[-1][0] in before:
        joint = before[found[-1][0]]
        found.append((joint.parent, np.array(joint.xyz)))
    return tuple(found[:-1])


def _lay(assembly: Assembly, placement: Placement) -> None:
    """A line of mass on each link: of a thin rod m/6 moves with either end, and m/6 with the sum of both."""
    for number in np.unique(placement.response[:, 0]).tolist():
        here = (placement.response[:, 0] == number)[:, None, None]
        for link, end in _laid(placement.context, number):
            ends = [assembly.motion(link, place)[..., :3, :] for place in (np.zeros(3), end)]
            rows = here * np.concatenate([*ends, ends[0] + ends[1]], axis=-2)
            mass = placement["line_mass"] * float(np.linalg.norm(end))
            assembly.add_together("mass", rows, np.full(rows.shape[-2], mass / 6))


def _held_shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates(COORDINATES)


def _held(assembly: Assembly, placement: Placement) -> None:
    """The mass moves by its own coordinates against the surface, and is held by its cable."""
    motion, foot = carried_along(assembly, placement)
    at_it, _ = carried_along(assembly, replace(placement, values={**placement.values, "off_along": 0.0}))
    mass, own = placement["mass"], 2 * np.pi * placement["mount_frequency"]
    hung = 2 * np.pi * placement["cable_frequency"]
    for k, name in enumerate(COORDINATES):
        row = assembly.row(name)
        moved = motion[:, k] + row
        assembly.add_inertia(moved, mass)
        assembly.add_inertia(at_it[:, k], placement["firm"] * mass)
        assembly.add_spring(row, mass * own**2)
        assembly.add_damper(row, 2 * placement["mount_damping_ratio"] * mass * own)
        assembly.add_spring(moved, mass * hung**2)
        assembly.add_damper(moved, 2 * placement["cable_damping_ratio"] * mass * hung)
        _weigh_besides(assembly, placement, motion[:, k + 3], foot[:, k])
    stiffer, along_it = placement["along_ratio"], _along_link(assembly, placement)
    assembly.add_spring(along_it, mass * own**2 * (stiffer**2 - 1))
    assembly.add_damper(along_it, 2 * placement["mount_damping_ratio"] * mass * own * (stiffer - 1))
    _lay(assembly, placement)
    for number in sorted({number for number, _ in placement.context.responses}):
        point = placement.context.point(number)
        pad = assembly.motion(point.link, np.array(point.xyz))[..., :3, :]
        assembly.add_together("mass", pad, np.full(3, placement[PADS] * mass))


def _along_link(assembly: Assembly, placement: Placement) -> np.ndarray:
    """Motion of the mass against the surface along the link that it is on."""
    rows = np.array([assembly.row(name) for name in COORDINATES])
    found = np.zeros((len(placement.posture), len(assembly.coordinates)))
    for number in np.unique(placement.response[:, 0]).tolist():
        link, here = placement.context.point(number).link, placement.response[:, 0] == number
        _, axis = along(placement.context, link)
        found[here] = (assembly.axes(link)[here] @ axis) @ rows
    return found


HELD_SENSOR = Effect(
    name="sensor_mass",
    says="the accelerometer weighs on the structure and moves with the measurement from point to point",
    places=lambda context: ("sensor",),
    parameters=_held_parameters,
    starts=lambda context, where: [{"mass": share * context.arm_mass} for share in (0.005, 0.03)],
    shape=_held_shape,
    act=_held,
    variants=("response",),
    untestable=lambda context: (
        "one response point only: the sensor never moved" if len(context.sensors) < 2 else None
    ),
)


def _in_sets(size: int) -> Effect:
    """So many sensors that move on together, and at the next level one more."""
    return replace(
        HELD_SENSOR,
        parameters=_set_parameters,
        shape=None,
        act=lambda assembly, placement: weigh(assembly, placement, size),
        next_level=None if size == SIZES[-1] else Level(_in_sets(size + 1), _set_starts),
    )


def _set_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    return tuple(one for one in _sensor_parameters(context, where) if one.name != "cable")


def _set_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    return [{**values, "mass": share * values["mass"]} for share in (0.4, 1.0)]


EFFECT = replace(
    HELD_SENSOR,
    parameters=_sensor_parameters,
    shape=None,
    act=_weigh,
    next_level=Level(replace(HELD_SENSOR, next_level=Level(_in_sets(SIZES[0]), _set_starts)), _held_starts),
)
