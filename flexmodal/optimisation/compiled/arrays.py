"""What the compiled search works on: a problem as plain arrays, and the room it needs to work.

Named tuples, since the compiler knows them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

POSITION, ORIENTATION, AXIS = 0, 1, 2
"""What is held: the position alone, with the orientation, or with an axis free to turn about itself."""

RECEPTANCE, STIFFNESS, MOBILITY = 0, 1, 2
"""What is judged."""

PAIR, FORCE, LARGEST = 0, 1, 2
"""Of a receptance matrix α, with force and toward unit vectors w and t: |tᵀαw|, ‖αw‖, or the 40-norm of its
singular values."""


class Held(NamedTuple):
    """What is held; no rows if nothing is."""

    joint: int
    """Number of the joint that carries the point."""
    offset: np.ndarray
    """Of the point in that joint's frame [m]."""
    kind: int
    """POSITION, ORIENTATION or AXIS."""
    own: np.ndarray
    """Orientation of the point's frame in the joint's; of an axis, the first column."""
    rows: np.ndarray
    """What counts of the error, position [m] before rotation vector [rad]; held × 6."""
    target: np.ndarray
    """Position in the world [m]."""
    orientation: np.ndarray
    """Target of the frame in the world; of an axis, the first column."""


class Judge(NamedTuple):
    """What a posture is judged by."""

    kind: int
    """RECEPTANCE, STIFFNESS or MOBILITY."""
    joint: np.ndarray
    """Carriers of the points that are judged."""
    offset: np.ndarray
    """Of the points in the carriers' frames; point × 3."""
    selector: np.ndarray
    """Directions in world axes, translations first, weights included; point × 6."""
    row: np.ndarray
    """To which row each point adds."""
    pick: np.ndarray
    """Which joints are flexible."""
    matrices: np.ndarray
    """K and B over the flexible joints."""
    lag: np.ndarray
    """What hysteresis adds to the diagonal of Z, real and imaginary part; frequency × 2 × flexible."""
    omega: np.ndarray
    """Angular frequencies [rad/s]."""
    measure: int
    """PAIR, FORCE or LARGEST."""
    force: np.ndarray
    """w over the rows."""
    toward: np.ndarray
    """t over the rows."""
    lines: np.ndarray
    """Share of each frequency."""
    power: float
    """Of the mean over the frequencies: 1, or large for the worst of them."""
    task: np.ndarray
    """Rows of the six-row Jacobian that the stiffness measure takes."""
    along: np.ndarray
    """The direction among them."""
    goal: float
    """Cost below which there is nothing left to gain, or no bound."""
    bounded: bool
    """Whether it is the former."""


class Places(NamedTuple):
    """Where the joints are, and the point held."""

    moved: np.ndarray
    """Angles and lengths of all joints."""
    frames: np.ndarray
    origins: np.ndarray
    axes: np.ndarray
    position: np.ndarray
    jacobian: np.ndarray
    turned: np.ndarray
    turn: np.ndarray


class Scratch(NamedTuple):
    """Room for a judge to work in; what the cost leaves behind, the gradient uses."""

    jacobians: np.ndarray
    rows: np.ndarray
    slope: np.ndarray
    """Derivative of the cost along all joints."""
    mass: np.ndarray
    y: np.ndarray
    """Z⁻¹jᵀ by frequency, row, part and joint."""
    alpha: np.ndarray
    """Receptance matrix by frequency."""
    norms: np.ndarray
    """Its norms; of the stiffness measure, the value."""
    centres: np.ndarray
    inertias: np.ndarray
    matrix: np.ndarray
    size: np.ndarray
    work: np.ndarray
    wide: np.ndarray
    powers: np.ndarray
    weights: np.ndarray
    arms: np.ndarray
    z: np.ndarray
    twists: np.ndarray
    momenta: np.ndarray
    sums: np.ndarray
    turned: np.ndarray
    task: np.ndarray
    """ΣVᵀ of the task Jacobian, U and Σ beside it."""
    left: np.ndarray
    sizes: np.ndarray
    deflection: np.ndarray
    moment: np.ndarray
    shares: np.ndarray
    rates: np.ndarray
    selector: np.ndarray
    spread: np.ndarray


class Arm(NamedTuple):
    """All that a compiled descent asks of the posture at hand."""

    chain: tuple[np.ndarray, ...]
    """Arrays of a `Chain`."""
    hold: Held
    columns: np.ndarray
    """Where the commanded joints stand among all."""
    judge: Judge
    places: Places
    room: Scratch


def places_for(joints: int) -> Places:
    """Arrays for a chain of so many joints."""
    return Places(
        moved=np.zeros(joints), frames=np.zeros((joints, 3, 3)), origins=np.zeros((joints, 3)),
        axes=np.zeros((joints, 3)), position=np.zeros(3), jacobian=np.zeros((6, joints)),
        turned=np.zeros((3, 3)), turn=np.zeros(3),
    )  # fmt: skip


def scratch_for(joints: int, judge: Judge) -> Scratch:
    """Working arrays of a judge for a chain of so many joints.

    Args:
        joints: number of joints.
        judge: what is judged.
    """
    n, lines, task = len(judge.pick), len(judge.omega), len(judge.task)
    points, rows = len(judge.joint), 1 + int(judge.row.max())
    return Scratch(
        jacobians=np.zeros((points, 6, joints)), rows=np.zeros((rows, joints)), slope=np.zeros(joints),
        mass=np.zeros((joints, joints)), y=np.zeros((lines, rows, 2, joints)),
        alpha=np.zeros((lines, rows, rows), dtype=complex), norms=np.zeros(max(lines, 1)),
        centres=np.zeros((joints, 3)), inertias=np.zeros((joints, 3, 3)),
        matrix=np.zeros((n, n), dtype=complex), size=np.zeros(n), work=np.zeros(n, dtype=complex),
        wide=np.zeros((n, n + rows), dtype=complex), powers=np.zeros((4, rows, rows), dtype=complex),
        weights=np.zeros((rows, rows), dtype=complex), arms=np.zeros((joints, 3)),
        z=np.zeros((2, joints)), twists=np.zeros((2, joints, 6)), momenta=np.zeros((3, joints, 6)),
        sums=np.zeros(9), turned=np.zeros(joints), task=np.zeros((task, n)), left=np.zeros((task, task)),
        sizes=np.zeros(task), deflection=np.zeros(n), moment=np.zeros(n), shares=np.zeros(task),
        rates=np.zeros(n), selector=np.zeros(6), spread=np.zeros(joints),
    )  # fmt: skip
