"""Antiresonances of the model — minima of |α| over frequency — and how they move with the parameters.

At a dip g(ω) = Re ∂ ln α/∂ω = 0, so along a parameter p

    ∂ω/∂p = −Re ∂/∂ω (∂α/∂p / α) / Re ∂² ln α/∂ω²,

the derivatives over ω by central differences of exact values. Other than the zeros of α(s), which lie beside
the axis where there is damping, a dip is what one sees.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.structure.structure import Axis, Structure, receptance

NEAR = 0.15
"""Relative distance within which a dip of the model is the one that was measured."""
GRID = 61
"""Lines on which it is looked for."""
STEP = 1e-4
"""Of the differences, relative."""


def nearest_dip(
    structure: Structure, axis: Axis, pair: tuple[int, int], frequency: float, names: tuple[str, ...] = ()
) -> tuple[float, Float[np.ndarray, " name"]] | None:
    """The dip nearest to a frequency [Hz] and its derivatives [Hz]; None where there is none near.

    Args:
        structure: in one posture.
        axis: whose window and middle count; its lines do not.
        pair: numbers of the response and the reference row.
        frequency: where it was measured [Hz].
        names: parameters.
    """
    pairs = np.array([pair])

    def level(lines: np.ndarray) -> np.ndarray:
        value = receptance(structure, replace(axis, frequency=lines), pairs)[0][0]
        return np.log(np.maximum(np.abs(value), 1e-300))

    grid = frequency * np.linspace(1 - NEAR, 1 + NEAR, GRID)
    size = level(grid)
    low = np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] <= size[2:])) + 1
    if not low.size:
        return None
    line = low[np.argmin(np.abs(grid[low] - frequency))]
    place = _minimum(level, float(grid[line - 1]), float(grid[line + 1]))
    step = STEP * place
    around = np.array([place - step, place, place + step])
    value, slopes = receptance(structure, replace(axis, frequency=around), pairs, names)
    log = np.log(value[0] / value[0, 1]).real
    bend = (log[0] - 2 * log[1] + log[2]) / step**2
    relative = (slopes[:, 0] / value[0]).real
    return place, -(relative[:, 2] - relative[:, 0]) / (2 * step) / bend


def _minimum(level, low: float, high: float) -> float:  # type: ignore[no-untyped-def]
    """Minimum of a function inside an interval, to 1e-7 of it."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda f: float(level(np.array([f]))[0]), bounds=(low, high), method="bounded",
        options={"xatol": 1e-8 * high},
    )  # fmt: skip
    return float(found.x)
