"""What a descent works on: joint limits, ends, and arrays, in named tuples since the compiler knows them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

UNREACHED, UNSETTLED, SETTLED, PERFECT, UNBOUNDED = -1, 0, 1, 2, 3
"""How a descent ended: it could not reach the hold, or had no cost there; ran out of iterations; met the
tolerance; has nothing left to gain; ran into a posture where the measure grows without bound."""


class Box(NamedTuple):
    """Limits of the commanded joints."""

    lower: np.ndarray
    upper: np.ndarray


class Work(NamedTuple):
    """The hold's tangent space, and where an iteration works."""

    constraint: np.ndarray
    """Derivative of the hold's error; held × commanded."""
    trial_constraint: np.ndarray
    error: np.ndarray
    rows: np.ndarray
    """ΣVᵀ of the constraint, U and Σ beside it."""
    left: np.ndarray
    sizes: np.ndarray
    basis: np.ndarray
    """Rows that span what the constraint fixes, then what it leaves free."""
    factors: np.ndarray
    model: np.ndarray
    gradient: np.ndarray
    trial: np.ndarray
    trial_gradient: np.ndarray
    step: np.ndarray
    below: np.ndarray
    above: np.ndarray
    change: np.ndarray
    image: np.ndarray
    allowed: np.ndarray
    """Joints that a retraction may move, and those that a Newton step does."""
    free: np.ndarray
    kept: np.ndarray
    reach: np.ndarray
    """For the quadratic program, as all below."""
    root: np.ndarray
    centre: np.ndarray
    away: np.ndarray
    columns: np.ndarray
    residual: np.ndarray
    x: np.ndarray
    triangle: np.ndarray
    unit: np.ndarray
    solved: np.ndarray
    chosen: np.ndarray
    inside: np.ndarray
    barred: np.ndarray


_HELD, _WIDTH, _MORE, _TWICE = range(4)
_SHAPES = {
    "constraint": (_HELD, _WIDTH), "trial_constraint": (_HELD, _WIDTH), "error": (_HELD,),
    "rows": (_HELD, _WIDTH), "left": (_HELD, _HELD), "sizes": (_HELD,), "basis": (_WIDTH, _WIDTH),
    "factors": (_HELD,), "model": (_WIDTH, _WIDTH), "reach": (_WIDTH, _WIDTH), "root": (_WIDTH, _WIDTH),
    "columns": (_TWICE, _MORE), "residual": (_MORE,), "x": (_TWICE,), "triangle": (_MORE, _MORE),
    "unit": (_MORE, _MORE), "solved": (_MORE,), "chosen": (_MORE,), "inside": (_TWICE,), "barred": (_TWICE,),
}  # fmt: skip
"""Of the arrays that are no vectors over the commanded joints."""
_TYPES = {"chosen": np.int64, "allowed": bool, "free": bool, "inside": bool, "barred": bool}


def work_for(held: int, width: int) -> Work:
    """Arrays for so many held components and so many commanded joints.

    Args:
        held: number of held components.
        width: number of commanded joints.
    """
    sizes = (held, width, width + 1, 2 * width)
    shapes = {name: [sizes[axis] for axis in _SHAPES.get(name, (_WIDTH,))] for name in Work._fields}
    return Work(**{name: np.zeros(shape, _TYPES.get(name, float)) for name, shape in shapes.items()})
