"""How a receptance changes with the frequency, stiffness, damping, masses and places of joints.

With Z y = jᵀ solved once for each direction, a change of Z by dZ and of the rows by dj gives

    dα_uv = dj_u y_v + y_uᵀ dj_vᵀ − y_uᵀ dZ y_v.

All of them are exact, and cost inner products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.receptance import dynamic_stiffness
from flexmodal.model.posed import PosedRobot


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """A receptance between two directions and its derivatives, by frequency."""

    value: Complex[np.ndarray, " line"]
    """α [m/N, rad/N, …]."""
    frequency: Complex[np.ndarray, " line"]
    """∂α/∂f, per hertz."""
    stiffness: Complex[np.ndarray, "line joint joint"]
    """∂α/∂K_ij, each entry by itself; the derivative along a joint's own stiffness is on the diagonal."""
    damping: Complex[np.ndarray, "line joint joint"]
    """∂α/∂B_ij, likewise."""
    mass: Complex[np.ndarray, "line moving"]
    """Per kilogram at the centre of mass of the body behind each moving joint."""
    place: Complex[np.ndarray, "line joint 3"]
    """Per metre that the axis of a flexible joint is moved along x, y or z of the world, all bodies and all
    other joints staying where they are: where a link is split by a pseudo-joint."""


def sensitivity(
    posed: PosedRobot,
    response: str | PointDirection,
    reference: str | PointDirection,
    frequency: Float[np.ndarray, " line"],
) -> Sensitivity:
    """A receptance and its derivatives at a posture.

    Args:
        posed: the robot in its posture.
        response: such as "tool:+z".
        reference: likewise.
        frequency: checked frequency axis [Hz].

    Raises:
        InvalidPoint: bad directions.
        InvalidRequest: a robot that branches: its bodies are not all behind one another.
    """
    robot = posed.robot
    model, data = robot.pinocchio, posed._data[0]
    if any(model.parents[i] != i - 1 for i in range(1, model.njoints)):
        raise InvalidRequest(Fault("call", "robot", "one that branches", "a serial chain"))
    left, right = posed.directions([response, reference])
    rows = posed.rows([left, right])
    system, pick, omega = posed.system, robot.flexible_index, 2 * np.pi * frequency
    y = np.linalg.solve(dynamic_stiffness(system, frequency), rows.T.astype(complex)[None])
    yu, yv = y[:, :, 0], y[:, :, 1]
    outer = yu[:, :, None] * yv[:, None, :]
    both = np.einsum("lij,ij->l", outer, system.mass), np.einsum("lij,ij->l", outer, system.damping)
    lag = system.hysteresis
    loss = 0.0 if lag is None else np.einsum("li,li->l", yu * yv, lag.slope(1j * omega))
    columns = np.array(data.J)[:, pick]  # about the world's origin
    momenta, masses = _momenta(posed, columns, y)
    turning = columns[3:]
    # Moving the axis w by d takes w × d from the velocity of everything behind it.
    steps = -np.cross(turning.T[:, None, :], np.eye(3)[None])  # joint, direction of d, component
    behind = momenta[:, pick]  # line, joint, component, side
    change = np.einsum(
        "jda,lja->ljd", steps, yu[:, :, None] * behind[..., 1] + yv[:, :, None] * behind[..., 0]
    )
    shifts = [
        np.einsum("a,jda->jd", d.selector[:3], steps)
        * np.any(posed.full_jacobian(d.point)[:, pick] != 0, axis=0)[:, None]
        for d in (left, right)
    ]
    return Sensitivity(
        value=np.einsum("i,li->l", rows[0], yv),
        frequency=2 * np.pi * (2 * omega * both[0] - 1j * both[1] - 1j * loss),
        stiffness=-outer,
        damping=-1j * omega[:, None, None] * outer,
        mass=omega[:, None] ** 2 * masses,
        place=omega[:, None, None] ** 2 * change + shifts[0] * yv[:, :, None] + shifts[1] * yu[:, :, None],
    )


def _momenta(posed: PosedRobot, columns: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum behind each joint, by line, joint, component and side; v_u · v_v of each centre."""
    model, data, pick = posed.robot.pinocchio, posed._data[0], posed.robot.flexible_index
    count = model.nv
    momenta = np.zeros((len(y), count + 1, 3, y.shape[2]), dtype=complex)
    products = np.zeros((len(y), count), dtype=complex)
    for body in range(count - 1, -1, -1):
        centre = data.oMi[body + 1].act(model.inertias[body + 1].lever)
        speed = (columns[:3] + np.cross(columns[3:].T, centre).T) * (pick <= body)
        velocity = np.einsum("aj,ljs->las", speed, y)
        momenta[:, body] = momenta[:, body + 1] + model.inertias[body + 1].mass * velocity
        products[:, body] = np.sum(velocity[:, :, 0] * velocity[:, :, -1], axis=1)
    return momenta[:, :count], products
