"""The ports that a law-free look tries."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, combinations_with_replacement, product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects import base_flexibility, link_flexibility
from flexmodal.diagnosis.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.diagnosis.lawfree.port import STILL, Patterns, PortKind
from flexmodal.identification import Observations
from flexmodal.structure.assembly import Assembly

ATTACHED = 0.05
"""Of the arm's mass: what a body port is measured by."""
GEOMETRY = ("along", "beside", "above")
"""Parameters of the place of a body port."""


def _outer(row: np.ndarray, other: np.ndarray, count: int) -> np.ndarray:
    product = row[..., :, None] * other[..., None, :]
    pattern = product if row is other else product + np.swapaxes(product, -1, -2)
    return np.broadcast_to(pattern, (count, *pattern.shape[-2:]))


def _constant(size: list[float], frequency: np.ndarray) -> Float[np.ndarray, "function line"]:
    return np.repeat(np.array(size)[:, None], len(frequency), axis=1)


def _stiffness(context: Context, joint: str) -> float:
    return float(context.robot.joints[joint].stiffness)


# joints


def _joint_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    row = assembly.stretch_of(placement.where)
    return Patterns(_outer(row, row, len(placement.posture))[None])


JOINT = PortKind(
    name="joint",
    says="what drives or holds the joint",
    places=lambda context: context.joints,
    functions=lambda context, where: ("stiffness",),
    sizes=lambda context, where, frequency: _constant([_stiffness(context, where)], frequency),
    patterns=_joint_patterns,
)
TORQUE = replace(
    JOINT,
    name="torque",
    says="a torque of the joint that depends on how hard the blow is",
    by_blow=True,
    shape=replace(STILL, variants=("blow",)),
)


def _coupling_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    one, other = (assembly.stretch_of(name) for name in placement.where.split("+"))
    count = len(placement.posture)
    pairs = (one, one), (one, other), (other, other)
    return Patterns(np.stack([_outer(a, b, count) for a, b in pairs]))


def _coupling_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    one, other = (_stiffness(context, name) for name in where.split("+"))
    return _constant([one, float(np.sqrt(one * other)), other], frequency)


COUPLING = PortKind(
    name="coupling",
    says="a mechanism between two joints",
    places=lambda context: tuple(f"{a}+{b}" for a, b in combinations(context.joints, 2)),
    functions=lambda context, where: ("first", "between", "second"),
    sizes=_coupling_sizes,
    patterns=_coupling_patterns,
)


def _damping_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    total = np.zeros((len(placement.posture), *(len(assembly.coordinates),) * 2))
    for name, joint in placement.context.robot.joints.items():
        row = assembly.stretch_of(name)
        total = total + float(joint.stiffness) * _outer(row, row, len(placement.posture))
    return Patterns(total[None])


DAMPING = PortKind(
    name="damping",
    says="the damping of all joints alike",
    places=lambda context: ("joints",),
    functions=lambda context, where: ("share",),
    sizes=lambda context, where, frequency: _constant([1.0], frequency),
    unit="",
    patterns=_damping_patterns,
)

# extra coordinates


def _base_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    names, _ = base_flexibility.motions(placement.context.normal)
    return Patterns(compliance=np.stack([assembly.row(name) for name in names]))


def _base_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    tilt, shift = base_flexibility.sizes(context)
    _, motion = base_flexibility.motions(context.normal)
    return _constant([1 / (tilt if way[3:].any() else shift) for way in motion.T], frequency)


def _base_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    _, motion = base_flexibility.motions(context.normal)
    turns = [bool(way[3:].any()) for way in motion.T]
    grid = product((0.03, 0.2, 1.0, 5.0, 30.0), (0.01, 0.2, 1.0, 5.0, 30.0))
    return tuple(tuple(tilt if turn else shift for turn in turns) for tilt, shift in grid)


BASE = PortKind(
    name="base",
    says="the foundation",
    places=lambda context: (context.robot.urdf.root,),
    functions=lambda context, where: tuple(base_flexibility.motions(context.normal)[0]),
    sizes=_base_sizes,
    starts=_base_starts,
    unit="1/stiffness",
    shape=replace(base_flexibility.EFFECT, name="port", parameters=lambda c, w: (), act=None, extend=None),
    patterns=_base_patterns,
)


def _link_functions(context: Context, where: str) -> tuple[str, ...]:
    planes = 1 if context.normal is not None else 2
    names = [f"bend {plane + 1}" for plane in range(planes)]
    return (*names, *(f"{name}, outwards" for name in names))


def _link_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Even compliance along the link, and what grows along it; the hinges share it by Gauss's weights."""
    context, where = placement.context, placement.where
    places = link_flexibility.hinges(context, where)
    weights = link_flexibility.gauss(len(places))[1]
    planes = 1 if context.normal is not None else 2
    names = link_flexibility.names_of(context, where)
    found = np.zeros((2 * planes, len(assembly.coordinates)))
    for number, name in enumerate(names):
        hinge, plane = divmod(number, planes)
        row = weights[hinge] * assembly.row(name)
        found[plane] += row
        found[planes + plane] += 2 * (places[hinge] - 0.5) * row
    return Patterns(compliance=found)


def _link_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    planes = 1 if context.normal is not None else 2
    return tuple((*(size,) * planes, *(0.0,) * planes) for size in (0.03, 0.1, 0.3, 1.0, 3.0))


LINK = PortKind(
    name="link",
    says="the bending of the link",
    places=link_flexibility.EFFECT.places,
    functions=_link_functions,
    sizes=lambda context, where, frequency: _constant(
        [1 / link_flexibility.stiffest(context, where)] * len(_link_functions(context, where)), frequency
    ),
    starts=_link_starts,
    unit="rad/(N·m)",
    shape=replace(link_flexibility.EFFECT, name="port", parameters=lambda c, w: (), act=None, extend=None),
    patterns=_link_patterns,
)

# bodies


def _ways(context: Context, where: str) -> list[np.ndarray]:
    _, axis = along(context, where)
    return [axis, *sides(context, where, axis)]


def _body_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    context, where = placement.context, placement.where
    motion = assembly.motion(where, place_on(context, where, placement.values))[..., :3, :]
    axes = assembly.axes(where)
    rows = [np.einsum("...i,...ij->...j", axes @ way, motion) for way in _ways(context, where)]
    count = len(placement.posture)
    return Patterns(np.stack([_outer(a, b, count) for a, b in combinations_with_replacement(rows, 2)]))


def _body_functions(context: Context, where: str) -> tuple[str, ...]:
    letters = ("along", "beside", "above")[: len(_ways(context, where))]
    return tuple(a if a == b else f"{a} × {b}" for a, b in combinations_with_replacement(letters, 2))


def _body_sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
    size = ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    return np.repeat(size[None], len(_body_functions(context, where)), axis=0)


BODY = PortKind(
    name="body",
    says="something attached to the link",
    places=lambda context: context.links,
    functions=_body_functions,
    sizes=_body_sizes,
    unit="N/m",
    shape=replace(
        ADDED_MASS,
        name="port",
        parameters=lambda context, where: tuple(
            one for one in ADDED_MASS.parameters(context, where) if one.name in GEOMETRY
        ),
        act=None,
        extend=None,
    ),
    patterns=_body_patterns,
)


def _ground_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """The same along the axes of the world."""
    context, where = placement.context, placement.where
    motion = assembly.motion(where, place_on(context, where, placement.values))[..., :3, :]
    ways = np.eye(3) if context.normal is None else base_flexibility.motions(context.normal)[1][:3, :2].T
    rows = [np.einsum("i,...ij->...j", way, motion) for way in ways]
    count = len(placement.posture)
    return Patterns(np.stack([_outer(a, b, count) for a, b in combinations_with_replacement(rows, 2)]))


def _ground_functions(context: Context, where: str) -> tuple[str, ...]:
    letters = "xyz" if context.normal is None else ("across", "up")
    return tuple(a if a == b else f"{a} × {b}" for a, b in combinations_with_replacement(letters, 2))


GROUND = replace(
    BODY,
    name="ground",
    says="something between the link and what stands around",
    functions=_ground_functions,
    patterns=_ground_patterns,
)


def _carried_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """What moves with the sensor, the same along every axis."""
    context = placement.context
    total = np.zeros((len(placement.posture), *(len(assembly.coordinates),) * 2))
    for number in np.unique(placement.response[:, 0]).tolist():
        point = context.point(number)
        here = (placement.response[:, 0] == number)[:, None, None]
        motion = assembly.motion(point.link, np.array(point.xyz))[..., :3, :]
        total = total + here * (np.swapaxes(motion, -1, -2) @ motion)
    return Patterns(total[None])


CARRIED = PortKind(
    name="carried",
    says="what moves from point to point with the sensor",
    places=lambda context: ("sensor",) if len(context.sensors) > 1 else (),
    functions=lambda context, where: ("force",),
    sizes=lambda context, where, frequency: (
        0.1 * ATTACHED * context.arm_mass * (2 * np.pi * frequency) ** 2
    )[None],
    unit="N/m",
    shape=replace(STILL, variants=("response",)),
    patterns=_carried_patterns,
)

# readings


def _of_sensor(observations: Observations, context: Context, where: str) -> np.ndarray:
    return np.asarray(observations.response[:, 0] == context.point(where).id)


def _of_hammer(observations: Observations, context: Context, where: str) -> np.ndarray:
    return np.asarray(observations.reference[:, 0] == context.point(where).id)


SENSOR = PortKind(
    name="sensor",
    says="what the sensor reads",
    places=lambda context: context.sensors,
    functions=lambda context, where: ("ln gain",),
    sizes=lambda context, where, frequency: _constant([1.0], frequency),
    unit="",
    reads=_of_sensor,
)
HAMMER = replace(
    SENSOR,
    name="hammer",
    says="what the hammer reads",
    places=lambda context: tuple(
        context.point(number).name for number in sorted({number for number, _ in context.references})
    ),
    reads=_of_hammer,
)

CHANNEL = replace(
    SENSOR,
    name="channel",
    says="a sensor that reads something else, posture for posture differently",
    drops=True,
)
BLOWS = replace(
    HAMMER,
    name="blows",
    says="blows that go elsewhere, posture for posture differently",
    places=lambda context: HAMMER.places(context) if len(HAMMER.places(context)) > 1 else (),
    drops=True,
)
NOTHING = replace(
    SENSOR,
    name="nothing",
    says="nothing",
    places=lambda context: ("",),
    reads=lambda observations, context, where: np.zeros(len(observations), dtype=bool),
)
"""The re-tuned robot."""

KINDS = (JOINT, DAMPING, COUPLING, BASE, LINK, BODY, GROUND, CARRIED, SENSOR, HAMMER, CHANNEL, BLOWS)
"""For FRFs that do not depend on the force of the blow; otherwise `TORQUE` besides."""
