"""Second derivatives of receptances with respect to the posture, many postures at once."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import unwrap

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from flexmodal.errors import Fault, InvalidRequest, MissingExtra, SingularResponse
from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.kernels.route import Route, available_cores, has_numba, in_parts, thread_faults
from flexmodal.model.batch_chain import chain_of, places_of
from flexmodal.model.batch_request import DirectionPair, ReceptanceBatch, expand, posture_array, read_pairs
from flexmodal.model.batch_second import second_batch
from flexmodal.model.batch_springs import springs_of
from flexmodal.model.posture import Pose
from flexmodal.model.robot import Robot

_MANY = 300
"""Points from which loading the compiled function pays."""


def curvature_batch(
    robot: Robot,
    postures: Sequence[Pose] | Float[np.ndarray, "posture commanded"],
    pairs: Sequence[str | PointDirection | DirectionPair],
    frequencies: ArrayLike,
    *,
    threads: int | None = None,
    way: str = "auto",
) -> ReceptanceBatch:
    """Receptances of many postures with their exact first and second derivatives along every moving joint.

    The second derivatives say whether a posture is a minimum indeed, and what small errors of the joints do
    to a receptance on average: with their covariance C, ½ tr(H C).

    Args:
        robot: a serial chain.
        postures: as for `flexmodal.model.batch.receptance_batch`, as all below.
        pairs: what to compute.
        frequencies: ascending [Hz].
        threads: most threads to use; all cores of the process if none.
        way: "compiled", "plain" (the same function as ordinary Python), or "auto".

    Raises:
        InvalidPosture, InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments.
        SingularResponse: an undamped mode is driven at its natural frequency.
        MissingExtra: the compiled way was asked for and numba is not installed.
    """
    axis = frequency_axis(frequencies)
    values = posture_array(robot, postures)
    read, rows, numbers = read_pairs(robot, pairs)
    chain = chain_of(robot)
    faults = thread_faults(threads)
    if way not in ("auto", "compiled", "plain"):
        faults.append(Fault("call", "way", repr(way), "auto, compiled, plain"))
    if chain is None:
        faults.append(Fault("call", "robot", "one that branches", "a serial chain"))
    if faults:
        raise InvalidRequest(faults)
    if way == "compiled" and not has_numba():
        raise MissingExtra("the compiled second derivatives need numba: pip install flexmodal[fast]")
    assert chain is not None
    compiled = way == "compiled" or (way == "auto" and has_numba() and len(values) * len(axis) >= _MANY)
    function = unwrap(second_batch)
    if compiled:
        from flexmodal.model.batch_compiled import compiled_second

        function = compiled_second()
    joints = len(robot.moving)
    result = np.empty((len(values), len(axis), len(numbers)), dtype=complex)
    slopes = np.empty((*result.shape, joints), dtype=complex)
    seconds = np.empty((*slopes.shape, joints), dtype=complex)
    places = places_of(robot, tuple((d.point, d.selector) for d in rows))
    matrices, lag = springs_of(robot, axis)
    cores = min(threads or available_cores(), -(-len(values) // _MANY)) if compiled else 1

    def solve(part: slice) -> int:
        return int(
            function(
                chain.arrays, places.joint, places.offset, places.selector, robot.flexible_index, matrices,
                lag, expand(robot, values[part]), 2 * np.pi * axis, np.array(numbers), result[part],
                slopes[part], seconds[part],
            )
        )  # fmt: skip

    singular = sum(in_parts(len(values), cores, solve))
    if singular:
        line = axis[int(np.argmax(np.isnan(result[..., 0].real).any(axis=0)))]
        raise SingularResponse(
            f"the receptance is infinite at {line:.9g} Hz: an undamped mode is driven at its natural "
            "frequency; give the joints damping or leave this frequency out"
        )
    route = Route("compiled" if compiled else "plain", cores, f"{len(values)} postures at {len(axis)} lines")
    return ReceptanceBatch(axis, read, result, route, slopes, seconds)
