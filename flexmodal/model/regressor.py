"""The mass matrix as a linear function of the inertial parameters of the bodies, by Pinocchio."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.model.build import pinocchio
from flexmodal.model.posed import PosedRobot


def mass_regressor(
    posed: PosedRobot,
) -> tuple[Float[np.ndarray, "joint joint parameter"], Float[np.ndarray, " parameter"]]:
    """Regressor of the mass matrix over the flexible joints, and the parameters it has now.

    Column by column: at rest and without gravity, the inverse dynamics of a unit acceleration is a column of
    D.

    Returns:
        R and π with D = R π but for rotor inertias: ten parameters for each joint that moves, those of what
        it carries up to the next: m, m c (3), and I_xx, I_xy, I_yy, I_xz, I_yz, I_zz about the joint's
        origin, axes of the joint.
    """
    pin = pinocchio()
    model = posed.robot.pinocchio
    data = model.createData()
    velocity = np.array([posed.posture.values.get(name, 0.0) for name in posed.robot.moving])
    configuration = pin.integrate(model, pin.neutral(model), velocity)
    pick, zero, unit = posed.robot.flexible_index, np.zeros(model.nv), np.eye(model.nv)
    columns = [
        pin.computeJointTorqueRegressor(model, data, configuration, zero, unit[joint]).copy()[pick]
        for joint in pick
    ]
    parameters = np.concatenate([inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]])
    return np.stack(columns, axis=1), parameters
