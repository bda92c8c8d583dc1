"""First derivatives of receptances with respect to the posture, many postures at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.kernels.factor import Pairs
from flexmodal.frf.kernels.route import Route, available_cores, has_numba, in_parts, thread_faults
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.model.batch.chain import Chain, chain_of, places_of
from flexmodal.model.batch.compiled import slope_kernel
from flexmodal.model.batch.request import DirectionPair, ReceptanceBatch, expand, posture_array, read_pairs
from flexmodal.model.batch.springs import springs_of
from flexmodal.model.gradient import receptance_and_gradient
from flexmodal.model.posture import Pose
from flexmodal.model.robot import Robot

_POSTURE, _POINT = 3e-4, 2e-5
"""Seconds that Pinocchio and LAPACK take for a posture and for each of its lines [s]."""

_EACH = 64
"""Postures that a thread is worth."""


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
    axis = frequency_axis(frequencies)
    values = posture_array(robot, postures)
    read, rows, numbers = read_pairs(robot, pairs)
    faults = thread_faults(threads)
    if way not in ("auto", "compiled", "numpy"):
        faults.append(Fault("call", "way", repr(way), "auto, compiled, numpy"))
    chain = chain_of(robot)
    if chain is None and way == "compiled":
        faults.append(Fault("call", "way", "compiled for a robot that branches", "auto or numpy"))
    if faults:
        raise InvalidRequest(faults)
    result = np.empty((len(values), len(axis), len(numbers)), dtype=complex)
    slopes = np.empty((*result.shape, len(robot.moving)), dtype=complex)
    if way == "numpy" or (way == "auto" and not _is_worth_compiling(chain, len(values), len(axis))):
        for place in range(len(values)):
            _gradient_of_one(robot, values[place], rows, axis, numbers, result[place], slopes[place])
        return ReceptanceBatch(axis, read, result, Route("numpy", 1, "few points, or as asked"), slopes)
    if not has_numba():
        raise MissingExtra("the compiled gradient needs numba: pip install flexmodal[fast]")
    assert chain is not None
    cores = min(threads or available_cores(), max(1, len(values) // _EACH))
    _compiled(robot, chain, values, rows, axis, numbers, result, slopes, cores)
    reason = f"{len(values)} postures at {len(axis)} frequencies"
    return ReceptanceBatch(axis, read, result, Route("compiled", cores, reason), slopes)


def _is_worth_compiling(chain: Chain | None, postures: int, lines: int) -> bool:
    seconds = postures * (_POSTURE + lines * _POINT)
    ready, kernel = chain is not None and has_numba(), slope_kernel()
    return ready and is_worth_it("slopes", seconds, kernel.seconds, kernel.is_stored)


def _compiled(
    robot: Robot,
    chain: Chain,
    values: np.ndarray,
    rows: tuple[PointDirection, ...],
    axis: np.ndarray,
    numbers: Pairs,
    result: np.ndarray,
    slopes: np.ndarray,
    cores: int,
) -> None:
    """Compiled code; the few points whose pivots are not to be trusted once more by LAPACK."""
    places = places_of(robot, tuple((d.point, d.selector) for d in rows))
    matrices, lag = springs_of(robot, axis)
    function = slope_kernel().compiled

    def solve(part: slice) -> None:
        doubtful = function(
            chain.arrays, places.joint, places.offset, places.selector, robot.flexible_index, matrices,
            lag, expand(robot, values[part]), 2 * np.pi * axis, np.array(numbers), result[part],
            slopes[part],
        )  # fmt: skip
        for place in np.flatnonzero(np.isnan(result[part]).any(axis=(1, 2))) if doubtful else ():
            spot = part.start + int(place)
            _gradient_of_one(robot, values[spot], rows, axis, numbers, result[spot], slopes[spot])

    in_parts(len(values), cores, solve)


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
