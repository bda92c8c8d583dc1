"""Operating shapes of fitted modes: what each point does, from residues that share a reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex

from flexmodal.ema.fit import Fit

FEWEST = 2
"""Points below which there is no shape."""


@dataclass(frozen=True, eq=False)
class FittedShapes:
    """Shapes of one posture and one reference; a mode that some point does not show is left out."""

    posture: int
    reference: tuple[int, int]
    responses: tuple[tuple[int, int], ...]
    """Point id and direction of each row."""
    frequency: tuple[float, ...]
    """Mean natural frequency of each column [Hz]."""
    shape: Complex[np.ndarray, "response mode"]
    """Residues, turned so that the largest is real and scaled so that it is 1."""


def fitted_shapes(fits: Sequence[Fit]) -> tuple[FittedShapes, ...]:
    """Shapes of every posture and reference that has them at two points or more."""
    groups: dict[tuple[int, tuple[int, int]], dict[tuple[int, int], dict[int, tuple[float, complex]]]] = {}
    for row in (row for one in fits for row in one.rows()):
        key = (row["posture"], tuple(row["reference"]))
        found = groups.setdefault(key, {}).setdefault(tuple(row["response"]), {})
        found[row["mode"]] = (row["frequency"], complex(*row["residue"]))
    shapes = []
    for (posture, reference), places in groups.items():
        common = sorted(set.intersection(*(set(modes) for modes in places.values())))
        if len(places) < FEWEST or not common:
            continue
        columns = np.array([[modes[mode][1] for mode in common] for modes in places.values()])
        largest = columns[np.argmax(np.abs(columns), axis=0), np.arange(len(common))]
        mean = [float(np.mean([modes[mode][0] for modes in places.values()])) for mode in common]
        shapes.append(FittedShapes(posture, reference, tuple(places), tuple(mean), columns / largest))
    return tuple(shapes)
