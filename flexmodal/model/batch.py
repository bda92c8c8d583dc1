"""Receptances of many postures at many frequencies: the one entry, whatever the route."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float
from numpy.typing import ArrayLike

from flexmodal.errors import Fault, InvalidPosture, InvalidRequest, MissingExtra
from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.kernels.factor import LANES, Pairs
from flexmodal.frf.kernels.planar import PLANAR
from flexmodal.frf.kernels.recursion import RIGID, SLIDING, TURNING
from flexmodal.frf.kernels.route import Route, available_cores, choose, has_numba, run
from flexmodal.frf.kernels.spatial import SPATIAL
from flexmodal.frf.kernels.task import Task
from flexmodal.frf.receptance import hysteretic_addition
from flexmodal.model.batch_chain import chain_of, places_of
from flexmodal.model.batch_planar import empty_plane
from flexmodal.model.batch_spatial import empty_space
from flexmodal.model.batch_springs import springs_of
from flexmodal.model.build import pinocchio
from flexmodal.model.gradient import receptance_and_gradient
from flexmodal.model.posture import check_posture
from flexmodal.model.robot import Pose, Robot

_LOG = logging.getLogger("flexmodal.engine")

_SLACK = 1e-9
"""How far outside a limit rounding may put a joint [rad, m]."""

_FEW, _MANY = 64, 4000
"""Postures from which compiled kinematics pay, with numba loaded already and without."""

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
    curvature: Complex[np.ndarray, "posture line pair moving moving"] | None = None
    """Second derivative along every two of them, if asked for."""


def receptance_batch(
    robot: Robot,
    postures: Sequence[Pose] | Float[np.ndarray, "posture commanded"],
    pairs: Sequence[str | PointDirection | DirectionPair],
    frequencies: ArrayLike,
    *,
    loss_factor: float = 0.0,
    addition: Complex[np.ndarray, "line joint joint"] | None = None,
    threads: int | None = None,
    way: str = "auto",
    explain: bool = False,
) -> ReceptanceBatch:
    """Receptances of many postures.

    Args:
        robot: the robot.
        postures: names, mappings, checked postures, or an array with a column for each commanded joint.
        pairs: what to compute: (response, reference), or one direction for a drive point.
        frequencies: ascending [Hz].
        loss_factor: structural damping η beside that of the card, K becomes K(1 + iη).
        addition: symmetric matrices added to Z, one for each frequency.
        threads: most threads to use; all cores of the process if none.
        way: "auto", or one of `flexmodal.frf.kernels.route.WAYS`; all give the same numbers but for rounding.
        explain: log the route taken, at level INFO of the logger "flexmodal.engine".

    Raises:
        InvalidPosture, InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments.
        InvalidUrdf: a mass matrix is not positive definite.
        SingularResponse: an undamped mode is driven at its natural frequency.
        MissingExtra: a compiled way was asked for and numba is not installed.
    """
    axis = frequency_axis(frequencies)
    values = posture_array(robot, postures)
    read, rows, numbers = read_pairs(robot, pairs)
    _check_loss(loss_factor)
    _check_addition(addition, len(axis), len(robot.joints))
    lag = hysteretic_addition(robot.hysteresis, axis)
    if lag is not None:
        addition = lag if addition is None else addition + lag
    pays = way == "auto" and len(values) >= (_FEW if "numba" in sys.modules else _MANY)
    asked = way.startswith("compiled") or way == "recursion"
    poser = _Poser(robot, values, rows, compiled=has_numba() and (pays or asked))
    task = Task(
        count=len(values),
        block=poser,
        stiffness=robot.stiffness,
        damping=robot.damping,
        hysteresis=loss_factor * robot.stiffness,
        pairs=numbers,
        omega=2 * np.pi * axis,
        addition=addition,
        recursion=_recursion(robot, values, rows, numbers, 2 * np.pi * axis, loss_factor, addition),
        chain="planar" if robot.is_planar else "spatial",
    )
    route = choose(task, threads, way)
    if explain:
        _LOG.info("%s; kinematics by %s", route, "compiled code" if poser.compiled else "Pinocchio")
    return ReceptanceBatch(axis, read, run(task, route), route)


def gradient_batch(
    robot: Robot,
    postures: Sequence[Pose] | Float[np.ndarray, "posture commanded"],
    pairs: Sequence[str | PointDirection | DirectionPair],
    frequencies: ArrayLike,
    *,
    threads: int | None = None,
    way: str = "auto",
) -> ReceptanceBatch:
    """Receptances of many postures with their exact derivatives along every moving joint.

    Args:
        robot: the robot.
        postures: as for `receptance_batch`.
        pairs: as for `receptance_batch`.
        frequencies: ascending [Hz].
        threads: most threads to use; all cores of the process if none.
        way: "auto", "compiled" or "numpy" (Pinocchio and LAPACK).

    Raises:
        InvalidPosture, InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments.
        MissingExtra: the compiled way was asked for and numba is not installed.
    """
    if threads is not None and (isinstance(threads, bool) or threads < 1):
        raise InvalidRequest(Fault("call", "threads", repr(threads), "a whole number of at least 1, or none"))
    axis = frequency_axis(frequencies)
    values = posture_array(robot, postures)
    read, rows, numbers = read_pairs(robot, pairs)
    if way not in ("auto", "compiled", "numpy"):
        raise InvalidRequest(Fault("call", "way", repr(way), "auto, compiled, numpy"))
    result = np.empty((len(values), len(axis), len(numbers)), dtype=complex)
    slopes = np.empty((*result.shape, len(robot.moving)), dtype=complex)
    chain = chain_of(robot)
    few = _FEW if "numba" in sys.modules else _MANY
    pays = len(values) * len(axis) >= few and has_numba() and chain is not None
    if way == "numpy" or (way == "auto" and not pays):
        for place in range(len(values)):
            _gradient_of_one(robot, values[place], rows, axis, numbers, result[place], slopes[place])
        return ReceptanceBatch(axis, read, result, Route("numpy", 1, "few points, or as asked"), slopes)
    if not has_numba():
        raise MissingExtra("the compiled gradient needs numba: pip install flexmodal[fast]")
    if chain is None:
        raise InvalidRequest(Fault("call", "way", "compiled for a robot that branches", "auto or numpy"))
    from flexmodal.model.batch_compiled import compiled_gradient

    places = places_of(robot, tuple((d.point, d.selector) for d in rows))
    matrices, lag = springs_of(robot, axis)
    function = compiled_gradient()
    cores = min(threads or available_cores(), max(1, len(values) // _FEW))

    def solve(part: slice) -> None:
        moved = expand(robot, values[part])
        doubtful = function(
            chain.arrays, places.joint, places.offset, places.selector, robot.flexible_index, matrices,
            lag, moved, 2 * np.pi * axis, np.array(numbers), result[part], slopes[part],
        )  # fmt: skip
        for place in np.flatnonzero(np.isnan(result[part]).any(axis=(1, 2))) if doubtful else ():
            spot = part.start + int(place)
            _gradient_of_one(robot, values[spot], rows, axis, numbers, result[spot], slopes[spot])

    edges = np.linspace(0, len(values), cores + 1).astype(int)
    parts = [slice(int(a), int(b)) for a, b in pairwise(edges)]
    if cores == 1:
        solve(parts[0])
    else:
        with ThreadPoolExecutor(cores) as pool:
            list(pool.map(solve, parts))
    reason = f"{len(values)} postures at {len(axis)} frequencies"
    return ReceptanceBatch(axis, read, result, Route("compiled", cores, reason), slopes)


def posture_array(
    robot: Robot, postures: Sequence[Pose] | Float[np.ndarray, "posture commanded"]
) -> Float[np.ndarray, "posture commanded"]:
    """Postures as an array over the commanded joints, checked.

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
    lower = np.array([joint.lower for joint in robot.commanded.values()]) - _SLACK
    upper = np.array([joint.upper for joint in robot.commanded.values()]) + _SLACK
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
    """Values of all moving joints, pseudo-joints at 0."""
    moved = np.zeros((len(values), len(robot.moving)))
    order = list(robot.moving)
    moved[:, [order.index(name) for name in robot.commanded]] = values
    return moved


class _Poser:
    """Mass matrices and rows of a slice of the postures."""

    def __init__(
        self, robot: Robot, values: np.ndarray, rows: tuple[PointDirection, ...], *, compiled: bool
    ) -> None:
        self.robot, self.values, self.rows = robot, values, rows
        self.chain = chain_of(robot) if compiled else None
        self.compiled = self.chain is not None
        self.places = places_of(robot, tuple((d.point, d.selector) for d in rows))

    def __call__(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        pick = self.robot.flexible_index
        values = self.values[part]
        masses = np.empty((len(values), len(pick), len(pick)))
        rows = np.empty((len(values), len(self.rows), len(pick)))
        if self.chain is not None:
            from flexmodal.model.batch_compiled import compiled_poses

            places = self.places
            compiled_poses()(
                self.chain.arrays, places.joint, places.offset, places.selector, pick,
                expand(self.robot, values), masses, rows,
            )  # fmt: skip
        else:
            self._by_pinocchio(expand(self.robot, values), masses, rows)
        try:
            np.linalg.cholesky(masses)
        except np.linalg.LinAlgError:
            for vector in values:  # the first that fails names the link at fault
                _ = self.robot.at(dict(zip(self.robot.commanded, map(float, vector), strict=True))).system
            raise
        return masses, rows

    def _by_pinocchio(self, moved: np.ndarray, masses: np.ndarray, rows: np.ndarray) -> None:
        pin, model = pinocchio(), self.robot.pinocchio
        data, pick = model.createData(), self.robot.flexible_index
        frames = [self.robot.frame_of(direction.point) for direction in self.rows]
        for place, vector in enumerate(moved):
            configuration = pin.integrate(model, pin.neutral(model), vector)
            masses[place] = pin.crba(model, data, configuration)[np.ix_(pick, pick)]
            pin.computeJointJacobians(model, data, configuration)
            pin.updateFramePlacements(model, data)
            for row, (frame, direction) in enumerate(zip(frames, self.rows, strict=True)):
                full = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
                rows[place, row] = (direction.selector @ full)[pick]


def _recursion(
    robot: Robot,
    values: np.ndarray,
    rows: tuple[PointDirection, ...],
    numbers: Pairs,
    omega: np.ndarray,
    loss_factor: float,
    addition: np.ndarray | None,
) -> Callable[[slice, slice, np.ndarray], int] | None:
    """The recursion along a chain; none where the robot is no such chain or numba is missing."""
    plain = addition is None and not robot.couplings
    chain = chain_of(robot) if plain and has_numba() else None
    if chain is None:
        return None
    places = places_of(robot, tuple((d.point, d.selector) for d in rows))
    springs = np.zeros((len(robot.moving), 4))
    flexible = robot.flexible_index
    springs[flexible, 0], springs[flexible, 1] = np.diag(robot.stiffness), np.diag(robot.damping)
    springs[flexible, 2], springs[flexible, 3] = loss_factor * np.diag(robot.stiffness), 1.0
    where = (places.joint, places.offset, places.selector)
    kinds = frozenset(
        (TURNING if turns else SLIDING) if soft else RIGID
        for turns, soft in zip(chain.turns, springs[:, 3], strict=True)
    )

    def fill(systems: slice, lines: slice, out: np.ndarray) -> int:
        from flexmodal.frf.kernels.compiled import compiled_sweep_along
        from flexmodal.model.batch_compiled import compiled_planes, compiled_spaces

        moved, here = expand(robot, values[systems]), omega[lines]
        if robot.is_planar:
            algebra, across = PLANAR, robot.task[:2, :3]
            joints, wrenches = empty_plane(moved.shape[0], moved.shape[1], len(rows))
            plane = np.array([*across, np.cross(across[0], across[1])])
            compiled_planes()(chain.arrays, where, plane, springs, moved, joints, wrenches)
        else:
            algebra = SPATIAL
            joints, wrenches = empty_space(moved.shape[0], moved.shape[1], len(rows))
            compiled_spaces()(chain.arrays, where, springs, moved, joints, wrenches)
        padded = np.pad(here, (0, -len(here) % LANES), mode="edge")
        sweep = compiled_sweep_along(algebra, numbers, kinds)
        return int(sweep(joints, wrenches, padded, algebra.before(len(rows)), out))

    return fill


def _gradient_of_one(
    robot: Robot,
    vector: np.ndarray,
    rows: tuple[PointDirection, ...],
    axis: np.ndarray,
    numbers: Pairs,
    value: np.ndarray,
    slope: np.ndarray,
) -> None:
    posed = robot.at(dict(zip(robot.commanded, map(float, vector), strict=True)))
    found, slopes = receptance_and_gradient(posed, rows, axis)
    left, right = ([pair[side] for pair in numbers] for side in (0, 1))
    value[...] = found[:, left, right]
    slope[...] = slopes[:, left, right]


def _check_loss(loss_factor: float) -> None:
    if isinstance(loss_factor, bool) or not np.isfinite(loss_factor) or loss_factor < 0:
        raise InvalidRequest(Fault("call", "loss_factor", repr(loss_factor), "a finite number ≥ 0"))


def _check_addition(addition: np.ndarray | None, lines: int, dof: int) -> None:
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
