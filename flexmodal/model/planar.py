"""Does the chain move in one plane, and which rows of the Jacobian describe that plane?"""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.model.build import pinocchio

_PARALLEL = 1e-9
"""Largest sine between axes that count as parallel."""


def task_rows(model: Any) -> Float[np.ndarray, "task 6"]:
    """Rows (two in-plane translations, the angle) of a planar chain; all six of a spatial one.

    A chain is planar when its revolute axes are parallel and its prismatic axes lie across them. For a
    plane spanned by coordinate axes the translations are those axes in order, such as x and z. `model` is
    Pinocchio's.
    """
    normal = _common_normal(model)
    if normal is None:
        return np.eye(6)
    size = np.abs(normal)
    if np.max(size) >= 1 - _PARALLEL:
        across = np.delete(np.eye(3), int(np.argmax(size)), axis=0)
    else:
        first = np.cross(normal, np.eye(3)[int(np.argmin(size))])
        first /= np.linalg.norm(first)
        across = np.array([first, np.cross(normal, first)])
    rows = np.zeros((3, 6))
    rows[:2, :3] = across
    rows[2, 3:] = normal
    return rows


def _common_normal(model: Any) -> np.ndarray | None:
    """The one direction all revolute joints turn about, or None for a spatial chain."""
    pin = pinocchio()
    jacobian = pin.computeJointJacobians(model, model.createData(), pin.neutral(model)).reshape(6, -1)
    linear, angular = jacobian[:3], jacobian[3:]  # at the world origin, in the world frame
    turning = np.linalg.norm(angular, axis=0) > 0.5
    if not np.any(turning):
        return None
    axes = angular[:, turning].T
    normal = axes[0] / np.linalg.norm(axes[0])
    normal = normal * np.sign(normal[np.argmax(np.abs(normal))])
    parallel = np.max(np.linalg.norm(np.cross(axes, normal), axis=1)) <= _PARALLEL
    across = np.max(np.abs(linear[:, ~turning].T @ normal), initial=0.0) <= _PARALLEL
    return normal if parallel and across else None
