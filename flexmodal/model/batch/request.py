"""What is asked of many postures at once, and what comes back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidPosture, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.kernels.factor import Pairs
from flexmodal.frf.kernels.route import Route
from flexmodal.model.posture import FARTHEST, Pose, check_posture
from flexmodal.model.robot import Robot

_SLACK = 1e-9
"""How far outside a limit rounding may put a joint [rad, m]."""

DirectionPair = tuple[str | PointDirection, str | PointDirection]


@dataclass(frozen=True, eq=False)
class ReceptanceBatch:
    """Receptances of one robot in many postures."""

    frequency: Float[np.ndarray, " line"]
    """[Hz]."""
    pairs: tuple[tuple[PointDirection, PointDirection], ...]
    """Response and reference."""
    value: Complex[np.ndarray, "posture line pair"]
    """[m/N, rad/N, …]."""
    route: Route
    """How they were computed, and why so."""
    slope: Complex[np.ndarray, "posture line pair moving"] | None = None
    """Derivative along every moving joint [1/rad or 1/m times the unit of `value`], if asked for."""


def posture_array(
    robot: Robot, postures: Sequence[Pose] | Float[np.ndarray, "posture commanded"]
) -> Float[np.ndarray, "posture commanded"]:
    """Postures as an array over the commanded joints, checked.

    Args:
        robot: the robot.
        postures: names, mappings, checked postures, or an array already [rad, m].

    Raises:
        InvalidPosture: none at all, the wrong number of columns, values that are not finite or outside the
            limits, unknown names.
    """
    if not isinstance(postures, np.ndarray):
        checked = [robot.posture(pose) for pose in postures]
        if not checked:
            raise InvalidPosture(Fault("call", "postures", "none", "at least one"))
        return np.array([[pose.values[name] for name in robot.commanded] for pose in checked], dtype=float)
    names = tuple(robot.commanded)
    if postures.ndim != 2 or postures.shape[1] != len(names) or len(postures) == 0:
        allowed = f"an array of at least one posture with {len(names)} columns: {', '.join(names)}"
        raise InvalidPosture(Fault("call", "postures", f"shape {postures.shape}", allowed))
    values = np.ascontiguousarray(postures, dtype=float)
    lower = np.array([max(joint.lower, -FARTHEST) for joint in robot.commanded.values()]) - _SLACK
    upper = np.array([min(joint.upper, FARTHEST) for joint in robot.commanded.values()]) + _SLACK
    bad = np.flatnonzero(~(np.isfinite(values) & (values >= lower) & (values <= upper)).all(axis=1))
    if len(bad):
        first = int(bad[0])
        given = dict(zip(names, map(float, values[first]), strict=True))
        check_posture(given, robot.commanded, robot.pseudo_joints, source=f"posture {first}")
    return values


def read_pairs(
    robot: Robot, pairs: Sequence[str | PointDirection | DirectionPair]
) -> tuple[tuple[tuple[PointDirection, PointDirection], ...], tuple[PointDirection, ...], Pairs]:
    """Pairs of directions, the distinct directions among them, and the pairs as numbers of those.

    Args:
        robot: the robot.
        pairs: response and reference, or one direction for a drive point.

    Raises:
        InvalidPoint: bad text, or a point the robot does not have.
        InvalidRequest: no pair.
    """
    if isinstance(pairs, str | PointDirection) or len(pairs) == 0:
        found = "none" if not isinstance(pairs, str | PointDirection) else repr(pairs)
        raise InvalidRequest(Fault("call", "pairs", found, 'a sequence, such as [("tool:+x", "tool:+z")]'))
    read = []
    for pair in pairs:
        left, right = (pair, pair) if isinstance(pair, str | PointDirection) else pair
        read.append((PointDirection.parse(left), PointDirection.parse(right)))
    rows = tuple(dict.fromkeys(direction for pair in read for direction in pair))
    for direction in rows:
        robot.frame_of(direction.point)
    return tuple(read), rows, tuple((rows.index(left), rows.index(right)) for left, right in read)


def expand(
    robot: Robot, values: Float[np.ndarray, "posture commanded"]
) -> Float[np.ndarray, "posture moving"]:
    """Values of all moving joints, pseudo-joints at 0.

    Args:
        robot: the robot.
        values: of the commanded joints [rad, m].
    """
    moved = np.zeros((len(values), len(robot.moving)))
    order = list(robot.moving)
    moved[:, [order.index(name) for name in robot.commanded]] = values
    return moved


def check_loss(loss_factor: float) -> None:
    """Refuse a loss factor that is none.

    Raises:
        InvalidRequest: not finite, or below 0.
    """
    if isinstance(loss_factor, bool) or not np.isfinite(loss_factor) or loss_factor < 0:
        raise InvalidRequest(Fault("call", "loss_factor", repr(loss_factor), "a finite number ≥ 0"))


def check_addition(addition: np.ndarray | None, lines: int, dof: int) -> None:
    """Refuse additions to Z that are no symmetric matrices, one for each line.

    Args:
        addition: what is added to Z, if anything.
        lines: number of frequencies.
        dof: number of flexible joints.

    Raises:
        InvalidRequest: another shape, entries that are not finite, not symmetric.
    """
    if addition is None:
        return
    shape = (lines, dof, dof)
    allowed = f"finite symmetric matrices, shape {shape}"
    if addition.shape != shape:
        raise InvalidRequest(Fault("call", "addition", f"shape {addition.shape}", allowed))
    if not np.all(np.isfinite(addition)):
        raise InvalidRequest(Fault("call", "addition", "an entry that is not finite", allowed))
    if np.max(np.abs(addition - np.swapaxes(addition, 1, 2))) > 1e-9 * np.max(np.abs(addition)):
        raise InvalidRequest(Fault("call", "addition", "matrices that are not symmetric", allowed))
