"""What a posture is worth along a direction: stiffness, mobility, static and dynamic receptance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model.posed import PosedRobot

TASKS = ("full", "position")


@dataclass(frozen=True)
class Measures:
    """Measures of one posture along one direction."""

    stiffness: float
    """ξ_K = uᵀ J⁺ᵀ K J⁺ u [N/m], Hearne [3.17]: the force felt when the tool is moved along u alone."""
    mobility: float
    """ξ_M = uᵀ J Jᵀ u [m²/rad²], Hearne [3.18]."""
    static_receptance: float
    """j K⁻¹ jᵀ [m/N], without the sign conventions or decisions of a Jacobian inverse."""
    frequency: float | None
    """Where `receptance` was taken [Hz]."""
    receptance: complex | None
    """α at `frequency` [m/N]."""
    tool: tuple[float, float, float]
    """Position of the end-effector [m]."""


def measure(
    posed: PosedRobot,
    direction: str | PointDirection | None = None,
    frequency: float | None = None,
    *,
    task: str = "full",
) -> Measures:
    """Measure a posture along one direction (the tool along z if none is given).

    Args:
        posed: the robot in its posture.
        direction: such as "tool:+z".
        frequency: for the dynamic receptance [Hz].
        task: "full" takes rotations into the stiffness measure (three rows of a planar chain, six of a
            spatial one), "position" leaves them out.

    Raises:
        InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments.
    """
    (along,) = posed.directions(direction)
    row = posed.rows([along])
    rows = reduced_task(posed, task)
    dynamic = None if frequency is None else complex(posed.frf([frequency], response=along).value[0, 0, 0])
    x, y, z = posed.position(posed.robot.tool)
    return Measures(
        stiffness=stiffness_measure(
            rows @ posed.jacobian(along.point), posed.robot.stiffness, rows @ along.selector
        ),
        mobility=float((row @ row.T)[0, 0]),
        static_receptance=float((row @ np.linalg.solve(posed.system.stiffness, row.T))[0, 0]),
        frequency=frequency,
        receptance=dynamic,
        tool=(float(x), float(y), float(z)),
    )


def reduced_task(posed: PosedRobot, task: str) -> Float[np.ndarray, "task 6"]:
    """Rows of the Jacobian that the stiffness measure is taken over.

    Args:
        posed: the robot in its posture.
        task: "full" or "position".

    Raises:
        InvalidRequest: `task` is neither "full" nor "position".
    """
    if task not in TASKS:
        raise InvalidRequest(Fault("call", "task", repr(task), " or ".join(TASKS)))
    rows = posed.robot.task
    return rows if task == "full" else rows[: 2 if posed.robot.is_planar else 3]


def stiffness_measure(
    jacobian: Float[np.ndarray, "task joint"],
    stiffness: Float[np.ndarray, "joint joint"],
    along: Float[np.ndarray, " task"],
) -> float:
    """ξ_K = uᵀ J⁺ᵀ K J⁺ u with the Moore–Penrose inverse, Hearne [3.17].

    Args:
        jacobian: rows of the task over the flexible joints [m/rad].
        stiffness: K over the flexible joints [N·m/rad, N/m].
        along: unit direction in the rows of the task.
    """
    deflection = np.linalg.pinv(jacobian) @ along
    return float(deflection @ stiffness @ deflection)
