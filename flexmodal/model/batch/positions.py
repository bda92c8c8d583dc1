"""Where a point is in many postures."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.model.batch.chain import chain_of
from flexmodal.model.batch.request import expand
from flexmodal.model.build import pinocchio
from flexmodal.model.robot import Robot


def position_batch(
    robot: Robot, values: Float[np.ndarray, "posture commanded"], point: str
) -> Float[np.ndarray, "posture 3"]:
    """World positions of a point [m].

    Args:
        robot: the robot.
        values: of the commanded joints, checked already [rad, m].
        point: a named point or link.

    Raises:
        InvalidPoint: no such point.
    """
    frame = robot.pinocchio.frames[robot.frame_of(point)]
    moved, chain = expand(robot, values), chain_of(robot)
    if chain is None:
        return _by_pinocchio(robot, moved, robot.frame_of(point))
    place = np.tile(np.array(frame.placement.translation), (len(moved), 1))
    for joint in range(frame.parentJoint - 1, -1, -1):  # from the point to the base, vectors only
        axis, angle = chain.axis[joint], moved[:, joint, None]
        if chain.turns[joint]:
            turned = place @ _crossing(axis).T
            along = (place @ axis)[:, None] * axis
            place = along + (place - along) * np.cos(angle) + turned * np.sin(angle)
        else:
            place = place + angle * axis
        place = place @ chain.rotation[joint].T + chain.offset[joint]
    return place


def _crossing(axis: np.ndarray) -> np.ndarray:
    """Matrix of the cross product with an axis on its left."""
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _by_pinocchio(robot: Robot, moved: np.ndarray, frame: int) -> np.ndarray:
    pin, model = pinocchio(), robot.pinocchio
    data, out = model.createData(), np.empty((len(moved), 3))
    for number, vector in enumerate(moved):
        pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), vector))
        out[number] = data.oMf[frame].translation
    return out
