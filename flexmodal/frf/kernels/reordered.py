"""Points where the recursion along a chain grew, eliminated in the other order: from the base to the tip.

Pivots vanish where a part of the chain resonates that is cut off by the joint at hand: the part behind it in
the recursion, the part before it when rows are taken from the first to the last. The two seldom meet at one
frequency, so that next to nothing is left for elimination with pivoting, one point at a time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Complex

from flexmodal.frf.kernels.factor import pack
from flexmodal.frf.kernels.task import Task

WORTH_A_TILE = 4
"""Points from which a tile of them costs less than LAPACK on each."""


def solve_from_base(
    task: Task,
    posed: tuple[np.ndarray, np.ndarray],
    lines: slice,
    sweep: Any,
    out: Complex[np.ndarray, "system line pair"],
) -> int:
    """Solve the points that stand as NaN, each a system of its own at 1 rad/s: ω²M, K, ωB.

    Args:
        task: of diagonal K and B, with nothing added.
        posed: mass matrices and rows of the block.
        lines: of the block.
        sweep: the compiled loops with the kernel for any number of coordinates.
        out: of the block.

    Returns:
        How many are left.
    """
    which, line = np.nonzero(np.isnan(out[..., 0]))
    if len(which) < WORTH_A_TILE:
        return len(which)
    masses, rows = posed
    omega = task.omega[line + (lines.start or 0)][:, None]
    stiffness, damping, loss = (np.diag(part) for part in (task.stiffness, task.damping, task.hysteresis))
    ones = np.ones_like(omega)
    parts = np.hstack([omega**2 * pack(masses)[which], ones * stiffness, omega * damping, ones * loss])
    values = np.empty((len(which), 1, len(task.pairs)), dtype=complex)
    given = (np.empty(0), rows.reshape(len(rows), -1)[which], np.ones(1), np.empty((0, 1)))
    left = sweep(parts, *given, np.array(task.pairs), True, values)
    out[which, line] = values[:, 0]
    return int(left)
