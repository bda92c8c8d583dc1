"""Other ways to the same receptance, each as its users would write it; checked before they are timed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Point = Callable[[], np.ndarray]


def stacked(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, rows: np.ndarray, omega: np.ndarray
) -> np.ndarray:
    """`np.linalg.solve` on a stack: the reference of every ratio."""
    w = omega[:, None, None]
    matrix = stiffness - w**2 * mass + 1j * w * damping
    return np.asarray(rows @ np.linalg.solve(matrix, rows.T.astype(complex)[None]))


def looped(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, row: np.ndarray, omega: np.ndarray
) -> np.ndarray:
    """A Python loop of `np.linalg.solve`."""
    return np.array([row @ np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, row) for w in omega])


def state_space(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """First-order form with displacement along the row as output and force along it as input."""
    n = len(mass)
    inverse = np.linalg.inv(mass)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    b = np.concatenate([np.zeros(n), inverse @ row])[:, None]
    return a, b, np.concatenate([row, np.zeros(n)])[None], np.zeros((1, 1))


def peers(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, row: np.ndarray, omega: np.ndarray
) -> dict[str, Point]:
    """What is installed of the field, by name."""
    found: dict[str, Point] = {
        "python loop of np.linalg.solve": lambda: looped(mass, damping, stiffness, row, omega)
    }
    try:
        from scipy.signal import freqresp

        form = state_space(mass, damping, stiffness, row)
        found["scipy.signal.freqresp"] = lambda: freqresp(form, omega)[1]
    except ImportError:
        pass
    try:
        import control

        plant = control.ss(*state_space(mass, damping, stiffness, row))
        found["python-control"] = lambda: np.asarray(plant(1j * omega)).ravel()
    except ImportError:
        pass
    try:
        import sdynpy

        # Coordinates of which the first is the displacement along the row: x = T z with row · T = e₁.
        others = np.delete(np.eye(len(row)), int(np.argmax(np.abs(row))), axis=0)
        change = np.linalg.inv(np.vstack([row, others]))
        parts = [change.T @ part @ change for part in (mass, stiffness, damping)]
        coordinates = sdynpy.coordinate_array(np.arange(len(row)) + 1, 1)
        system = sdynpy.System(coordinates, *parts)
        first = coordinates[:1]

        def by_sdynpy() -> np.ndarray:
            hertz = omega / (2 * np.pi)
            data = system.frequency_response(hertz, first, first, displacement_derivative=0)
            return np.asarray(data.ordinate).ravel()

        found["sdynpy"] = by_sdynpy
    except ImportError:
        pass
    return found


def mujoco_frf(
    path: str, body: str, k: np.ndarray, b: np.ndarray, offset: np.ndarray
) -> Callable[..., np.ndarray]:
    """Mass matrix and Jacobian from MuJoCo at a posture, then the stack."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
    mass, jacobian = np.empty((model.nv, model.nv)), np.empty((3, model.nv))

    def full(out: np.ndarray) -> None:
        if hasattr(data, "qM"):  # before MuJoCo 4
            mujoco.mj_fullM(model, out, data.qM)
        else:
            mujoco.mj_fullM(model, data, out)

    def frf(posture: np.ndarray, axis: int, omega: np.ndarray) -> np.ndarray:
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        full(mass)
        point = data.xpos[number] + data.xmat[number].reshape(3, 3) @ offset
        mujoco.mj_jac(model, data, jacobian, None, point, number)
        return stacked(mass, np.diag(b), np.diag(k), jacobian[axis : axis + 1], omega)[:, 0, 0]

    return frf
