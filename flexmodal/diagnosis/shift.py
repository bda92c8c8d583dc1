"""What a hypothesis' structures are put together from, and a step along one of an effect's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmodal.diagnosis.placed import Placed
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.frame import Frame
from flexmodal.structure.stack import Slopes


@dataclass(frozen=True, eq=False)
class Shift:
    """The parameters a step further along one of an effect's own."""

    number: int
    placed: Placed
    step: float
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Still:
    """Structures without their derivatives, and what these are differences from."""

    frame: Frame
    total: Mapping[str, np.ndarray]
    """Of the robot alone, by kind."""
    slopes: Slopes
    acted: Mapping[Placed, Assembly]
    """What each effect puts on the motions."""
    sums: Mapping[Placed, Mapping[str, np.ndarray]]
    rows: tuple[np.ndarray, np.ndarray]


def differences(shift: Shift, change: Mapping[str, np.ndarray], shape: tuple[int, ...]) -> Slopes:
    """Differences over a step as derivatives; of what does not change, none.

    Args:
        shift: the step.
        change: what it adds to the matrices, by kind.
        shape: of the matrices [system dof dof].
    """
    number = np.array([shift.number])
    return {
        kind: (number, np.broadcast_to(matrix / shift.step, shape)[None])
        for kind, matrix in change.items()
        if matrix.any()
    }
