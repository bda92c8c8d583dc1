"""Receptances of many postures at many frequencies: the one entry, whatever the route."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
from jaxtyping import Complex, Float
from numpy.typing import ArrayLike

from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.kernels.route import choose, has_numba, run
from flexmodal.frf.kernels.task import Task
from flexmodal.frf.receptance import hysteretic_addition
from flexmodal.model.batch.poser import Poser, is_worth_compiling
from flexmodal.model.batch.recursion import recursion_of
from flexmodal.model.batch.request import (
    DirectionPair,
    ReceptanceBatch,
    check_addition,
    check_loss,
    posture_array,
    read_pairs,
)
from flexmodal.model.posture import Pose
from flexmodal.model.robot import Robot

_LOG = logging.getLogger("flexmodal.engine")


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
    check_loss(loss_factor)
    check_addition(addition, len(axis), len(robot.joints))
    lag = hysteretic_addition(robot.hysteresis, axis)
    if lag is not None:
        addition = lag if addition is None else addition + lag
    asked = way.startswith("compiled") or way == "recursion"
    pays = is_worth_compiling(len(values)) if way == "auto" else asked and has_numba()
    poser = Poser(robot, values, rows, compiled=pays)
    task = Task(
        count=len(values),
        block=poser,
        stiffness=robot.stiffness,
        damping=robot.damping,
        hysteresis=loss_factor * robot.stiffness,
        pairs=numbers,
        omega=2 * np.pi * axis,
        addition=addition,
        recursion=recursion_of(robot, values, rows, numbers, 2 * np.pi * axis, loss_factor, addition),
        chain="planar" if robot.is_planar else "spatial",
    )
    route = choose(task, threads, way)
    if explain:
        _LOG.info("%s; kinematics by %s", route, "compiled code" if poser.compiled else "Pinocchio")
    return ReceptanceBatch(axis, read, run(task, route), route)
