"""Operating shapes of fitted modes: what each point does, from residues that share one side.

A sensor that goes from point to point under one hammer position gives residues φ_r φ_f with f fixed. A hammer
that goes from point to point past one sensor gives them with r fixed; the structure being reciprocal, these
are a shape as well, of the places that were struck.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Complex

from flexmodal.ema.fit import Fit

FEWEST = 2
"""Points below which there is no shape."""

Side = Literal["reference", "response"]
Way = tuple[int, int]
"""Point id and direction ±1 ±2 ±3."""
_Modes = dict[int, tuple[float, complex]]
"""Natural frequency and residue by the mode's number."""


@dataclass(frozen=True, eq=False)
class FittedShapes:
    """Shapes of one posture and one fixed place; a mode that some other place does not show is left out."""

    posture: int
    fixed: Way
    """Where the hammer, or the sensor, stayed."""
    side: Side
    """Which of the two it was: "reference" for a hammer that stayed, "response" for a sensor that did."""
    places: tuple[Way, ...]
    """Point id and direction of each row, those of the side that moved."""
    frequency: tuple[float, ...]
    """Mean natural frequency of each column [Hz]."""
    shape: Complex[np.ndarray, "place mode"]
    """Residues, turned so that the largest is real and scaled so that it is 1."""
    trial: int | None = None
    """None where trials were averaged."""


def fitted_shapes(fits: Sequence[Fit]) -> tuple[FittedShapes, ...]:
    """Shapes of every posture and fixed place that has them at two points or more.

    In each posture the side that moved is the one that gives the longest shapes; the sensor where both do.
    """
    tests: dict[tuple[int, int | None], dict[tuple[Way, Way], _Modes]] = {}
    for row in (row for one in fits for row in one.rows()):
        key = (_way(row["response"]), _way(row["reference"]))
        found = tests.setdefault((row["posture"], row.get("trial")), {}).setdefault(key, {})
        found[row["mode"]] = (row["frequency"], complex(*row["residue"]))
    shapes = []
    for test, residues in tests.items():
        groups = {side: _by_fixed(residues, side) for side in ("reference", "response")}
        longest = {side: max(map(len, found.values())) for side, found in groups.items()}
        side: Side = "reference" if longest["reference"] >= longest["response"] else "response"
        for fixed, places in groups[side].items():
            common = sorted(set.intersection(*(set(modes) for modes in places.values())))
            if len(places) >= FEWEST and common:
                shapes.append(_shape(test, fixed, side, places, common))
    return tuple(shapes)


def _way(pair: Sequence[int]) -> Way:
    return int(pair[0]), int(pair[1])


def _by_fixed(residues: dict[tuple[Way, Way], _Modes], side: str) -> dict[Way, dict[Way, _Modes]]:
    """The residues by the place that is fixed, then by the one that moves."""
    groups: dict[Way, dict[Way, _Modes]] = {}
    for (response, reference), modes in residues.items():
        fixed, moving = (reference, response) if side == "reference" else (response, reference)
        groups.setdefault(fixed, {})[moving] = modes
    return groups


def _shape(
    test: tuple[int, int | None], fixed: Way, side: Side, places: dict[Way, _Modes], common: Sequence[int]
) -> FittedShapes:
    columns = np.array([[modes[mode][1] for mode in common] for modes in places.values()])
    largest = columns[np.argmax(np.abs(columns), axis=0), np.arange(len(common))]
    mean = tuple(float(np.mean([modes[mode][0] for modes in places.values()])) for mode in common)
    return FittedShapes(test[0], fixed, side, tuple(places), mean, columns / largest, test[1])
