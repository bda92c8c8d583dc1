"""A joint gives across its axis: its bearing tilts and shifts on springs.

Five coordinates between a joint that turns and the link that carries it: two tilts, two shifts across the
axis and one along it; of a planar chain the two shifts alone. The springs meet somewhere on the axis, which
couples tilt and shift as the full stiffness matrix of a rolling bearing does (Lim and Singh, Journal of Sound
and Vibration 139, 1990); a housing may be stiffer one way than the other. A part of all springs may relax,
as a seat of plastic or a film of grease does. In all joints alike, each tilts on a multiple of its own
stiffness, and nothing relaxes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.relaxation import HELD, RELAXING, add_relaxing, relaxation
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.model.placements import link_placements
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

ALL = "joints"
"""Where all joints are meant."""
RADIUS = 0.15
"""Of a bearing, about [m]: what a tilt's stiffness makes of one across or along the axis."""
TILT = 5.0
"""Stiffness of a tilt over that of the joint, about."""


@dataclass(frozen=True, eq=False)
class Way:
    """One way in which a bearing gives."""

    kind: str
    """tilt, radial or axial."""
    number: int
    """1 or 2."""
    vector: Float[np.ndarray, "3"]
    """Direction, or axis of the turn, in the frame of the joint on the side of the carrying link."""

    @property
    def turns(self) -> bool:
        """Whether it is a turn."""
        return self.kind == "tilt"

    @property
    def name(self) -> str:
        """Such as tilt 1."""
        return f"{self.kind} {self.number}"


def _frame(context: Context, joint: str) -> Float[np.ndarray, "3 3"]:
    """Axes of the joint in the carrying link."""
    still, described = link_placements(context.robot, {}), context.robot.urdf.joint_by_name[joint]
    return still[described.parent][:3, :3].T @ still[described.child][:3, :3]


@lru_cache(maxsize=256)
def ways(context: Context, joint: str) -> tuple[Way, ...]:
    """In how many ways a joint can give that the chain can show; slides have none.

    Args:
        context: of the diagnosis.
        joint: its name.
    """
    described = context.robot.urdf.joint_by_name[joint]
    if described.is_prismatic:
        return ()
    axis = np.asarray(described.axis) / np.linalg.norm(described.axis)
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    sides = (first, np.cross(axis, first))
    radial = tuple(Way("radial", k + 1, side) for k, side in enumerate(sides))
    if context.normal is not None:
        return radial
    return (*(Way("tilt", k + 1, side) for k, side in enumerate(sides)), *radial, Way("axial", 1, axis))


def _joints(context: Context, where: str) -> tuple[str, ...]:
    return context.joints if where == ALL else (where,)


def given(context: Context, where: str, joint: str) -> tuple[Way, ...]:
    """The ways in which a joint gives at a place: of all joints alike, tilts alone.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
        joint: name of one there.
    """
    return tuple(way for way in ways(context, joint) if where != ALL or way.turns)


def _places(context: Context) -> tuple[str, ...]:
    turning = tuple(name for name in context.joints if ways(context, name))
    return (*turning, ALL) if context.normal is None and len(turning) > 1 else turning


def size(context: Context, joint: str) -> float:
    """A stiffness of tilts that a joint's own suggests [N·m/rad].

    Args:
        context: of the diagnosis.
        joint: its name.
    """
    return TILT * float(context.robot.joints[joint].stiffness)


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    loss = positive("damping_time", "s", 3e-4, 1.5, 1e-7, 0.03)
    if where == ALL:
        return positive("tilt_factor", "", TILT, 2.0, 1e-2 * TILT, 2e3 * TILT), loss
    tilt = size(context, where)
    kinds = [way.kind for way in ways(context, where)]
    found = []
    if "tilt" in kinds:
        found.append(positive("tilt_stiffness", "N·m/rad", tilt, 2.0, tilt / 300, tilt * 3e3))
    for kind in ("radial", "axial"):
        if kind in kinds:
            shift = tilt / RADIUS**2
            found.append(positive(f"{kind}_stiffness", "N/m", shift, 2.0, shift / 300, shift * 3e3))
    found.append(loss)
    if "tilt" in kinds:
        found.append(signed("offset", "m", 0.05, -0.5, 0.5))
    found += [positive("ratio", "", 1.0, 0.4, 0.05, 20.0), signed("angle", "rad", 0.8, -1.6, 1.6)]
    return (*found, *relaxation(context))


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    grid = (0.06, 0.2, 0.6, 2.0, 8.0)
    if where == ALL:
        return [{"tilt_factor": factor * TILT} for factor in grid]
    tilt, kinds = size(context, where), {way.kind for way in ways(context, where)}
    found: list[Mapping[str, float]] = []
    for factor in grid:
        for shift in (0.1, 1.0, 30.0) if "tilt" in kinds else (1.0,):
            other = {f"{kind}_stiffness": factor * shift * tilt / RADIUS**2 for kind in kinds - {"tilt"}}
            found.append({**({"tilt_stiffness": factor * tilt} if "tilt" in kinds else {}), **other})
    return found + [{**start, "relaxing": RELAXING} for start in found[1::3]]


def _coordinate(joint: str, way: Way) -> str:
    return f"{joint} {way.name}"


def _end(joint: str, number: int) -> str:
    """Of the relaxing part of a spring."""
    return f"{joint} relaxing {number + 1}"


def names_of(context: Context, where: str) -> list[tuple[str, Way, str]]:
    """Joint, way and coordinate, one after the other.

    Args:
        context: of the diagnosis.
        where: place of the effect: a joint, or `ALL`.
    """
    return [
        (joint, way, _coordinate(joint, way))
        for joint in _joints(context, where)
        for way in given(context, where, joint)
    ]


def add_ways(assembly: Assembly, placement: Placement) -> None:
    """A coordinate for each way in which joints give.

    Args:
        assembly: the robot, its motions not complete yet.
        placement: of the effect; its place is the joint, or `ALL`.
    """
    context, where = placement.context, placement.where
    for joint in _joints(context, where):
        some = given(context, where, joint)
        if not some:
            continue
        described = context.robot.urdf.joint_by_name[joint]
        columns = assembly.add_coordinates([_coordinate(joint, way) for way in some])
        axes = assembly.axes(described.parent) @ _frame(context, joint)
        motion = np.zeros((*axes.shape[:-2], 6, len(some)))
        for k, way in enumerate(some):
            motion[..., 3 * way.turns : 3 * way.turns + 3, k] = axes @ way.vector
        assembly.move_link(described.child, columns, motion)


def _shape(assembly: Assembly, placement: Placement) -> None:
    add_ways(assembly, placement)
    if placement.where != ALL:
        count = len(given(placement.context, placement.where, placement.where))
        assembly.add_coordinates([_end(placement.where, number) for number in range(count)])


def _springs(placement: Placement, joint: str) -> list[tuple[list[tuple[Way, float]], float]]:
    """The ways that a spring pulls along with their shares, and its stiffness."""
    context, where = placement.context, placement.where
    some = given(context, where, joint)
    if where == ALL:
        spring = placement["tilt_factor"] * size(context, joint) / TILT
        return [([(way, 1.0)], spring) for way in some]
    found = []
    ratio, angle = placement["ratio"], placement["angle"]
    turned = ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle)))
    for kind in dict.fromkeys(way.kind for way in some):
        along, spring = [way for way in some if way.kind == kind], placement[f"{kind}_stiffness"]
        if len(along) == 1:
            found.append(([(along[0], 1.0)], spring))
            continue
        for row, factor in zip(turned, (1.0, ratio), strict=True):
            found.append((list(zip(along, row, strict=True)), spring * factor))
    return found


@lru_cache(maxsize=256)
def _levers(context: Context, where: str, joint: str) -> Float[np.ndarray, "way way"]:
    """Motion along each way, by each tilt, of a point on the joint's axis as far from its middle as 1."""
    some, axis = given(context, where, joint), np.asarray(context.robot.urdf.joint_by_name[joint].axis)
    along = np.array([np.zeros(3) if way.turns else way.vector for way in some])
    tilted = np.array([np.cross(way.vector, axis) if way.turns else np.zeros(3) for way in some])
    return along @ tilted.T


def _act(assembly: Assembly, placement: Placement) -> None:
    context, where = placement.context, placement.where
    offset = placement.values.get("offset", 0.0)
    for joint in _joints(context, where):
        some = given(context, where, joint)
        if not some:
            continue
        rows = np.array([assembly.row(_coordinate(joint, way)) for way in some])
        if offset:  # motion of the point where the springs meet
            rows = rows + offset * (_levers(context, where, joint) @ rows)
        felt = dict(zip(some, rows, strict=True))
        for number, (pulled, stiffness) in enumerate(_springs(placement, joint)):
            row = sum(share * felt[way] for way, share in pulled)
            assembly.add_spring(row, stiffness)
            assembly.add_damper(row, stiffness * placement["damping_time"])
            if where != ALL:
                part, time = placement["relaxing"] * stiffness, placement["relaxation_time"]
                end = assembly.row(_end(joint, number))
                add_relaxing(assembly, row, end, part, time, context.band[1])


def _extend(draft: Draft, placement: Placement) -> None:
    context, where = placement.context, placement.where
    time, offset = placement["damping_time"], placement.values.get("offset", 0.0)
    for joint in _joints(context, where):
        axis = np.asarray(context.robot.urdf.joint_by_name[joint].axis)
        motions: list[tuple[str, np.ndarray, bool]] = []
        springs: list[tuple[str, float]] = []
        for pulled, stiffness in _springs(placement, joint):
            vector = sum((share * way.vector for way, share in pulled), np.zeros(3))
            way = pulled[0][0]
            name = draft.fresh(f"{joint}_{way.kind}_{len(springs) + 1}")
            motions.append((name, vector, way.turns))
            springs.append((name, stiffness))
        if motions:
            draft.under_joint(joint, motions, offset * axis)
        for name, stiffness in springs:
            draft.flexible(name, stiffness, stiffness * time)
    if placement.values.get("relaxing", 0.0) > HELD:
        draft.notes.append(
            f"the files have the bearing of {where} and lack what relaxes: {placement['relaxing']:.3g} of "
            f"its stiffness within {placement['relaxation_time']:.3g} s"
        )


EFFECT = Effect(
    name="bearing_flexibility",
    says="the joint gives across its axis",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
)
