"""Springs and dampers of a robot as plain arrays, for compiled code."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.model.robot import Robot


def springs_of(
    robot: Robot, frequency: Float[np.ndarray, " line"]
) -> tuple[Float[np.ndarray, "2 joint joint"], Float[np.ndarray, "line 2 joint"]]:
    """K and B over the flexible joints, and what hysteresis adds to the diagonal of Z at each frequency.

    The latter is K(iω) − K of each joint's own spring, real and imaginary part [N·m/rad, N/m]: zeros where
    no joint has a loss factor. A coupling between joints loses nothing.

    Args:
        robot: the robot.
        frequency: [Hz].
    """
    matrices = np.array([robot.stiffness, robot.damping])
    lag = np.zeros((len(frequency), 2, len(robot.joints)))
    if robot.hysteresis is not None:
        added = robot.hysteresis.added(2j * np.pi * frequency)
        lag[:, 0], lag[:, 1] = added.real, added.imag
    return matrices, lag
