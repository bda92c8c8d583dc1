"""Eigenvalues of Φ(ω) W₀ over frequency, on a grid that follows them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.directional import average, chip_axes
from flexmodal.machining.tip_receptance import TipReceptance

_TURN = 0.04
"""Most an eigenvalue may turn between two lines of the grid [rad]."""
_GROWTH = 1.1
"""Most it may grow or shrink there."""
_ROUNDS = 14
_NEGLIGIBLE = 1e-7
"""Eigenvalues smaller than this part of the largest are let go: their depths are millions of times larger."""


@dataclass(frozen=True, eq=False)
class Branches:
    """Cells between neighbouring frequencies, each with one eigenvalue at both ends."""

    tip: TipReceptance
    directional: Float[np.ndarray, "3 axis"]
    low: Float[np.ndarray, " cell"]
    """[Hz]."""
    high: Float[np.ndarray, " cell"]
    at_low: Complex[np.ndarray, " cell"]
    """Eigenvalue at the lower end [1/m]."""
    at_high: Complex[np.ndarray, " cell"]

    @property
    def turn(self) -> Float[np.ndarray, " cell"]:
        """How far the eigenvalue turns from the lower end to the upper [rad]."""
        return np.angle(self.at_high / self.at_low)

    def follow(
        self, cell: np.ndarray, frequency: Float[np.ndarray, " found"]
    ) -> Complex[np.ndarray, " found"]:
        """The eigenvalue of each cell at a frequency inside it, computed anew.

        Args:
            cell: number of the cell of each frequency.
            frequency: inside its cell [Hz].
        """
        part = (frequency - self.low[cell]) / (self.high[cell] - self.low[cell])
        expected = self.at_low[cell] * (self.at_high[cell] / self.at_low[cell]) ** part
        ordered, back = np.unique(frequency, return_inverse=True)
        values = eigenvalues(self.tip, self.directional, ordered)[back]
        nearest = np.argmin(np.abs(values - expected[:, None]), axis=1)
        return values[np.arange(len(values)), nearest]


def eigenvalues(
    tip: TipReceptance, directional: Float[np.ndarray, "3 axis"], frequency: Float[np.ndarray, " line"]
) -> Complex[np.ndarray, "line axis"]:
    """Eigenvalues of Φ W₀ over the axes that change the chip, at ascending frequencies [1/m].

    Args:
        tip: how the tip gives way.
        directional: W₀ [N/m²].
        frequency: of the lines [Hz].
    """
    moved = tip.receptance(frequency)[:, : directional.shape[1], :]
    return np.linalg.eigvals(moved @ directional)


def branches(tip: TipReceptance, cut: Cut) -> Branches:
    """Follow the eigenvalues from the first to the last of the tip's lines.

    Args:
        tip: how the tip gives way.
        cut: the cut.
    """
    directional = average(cut)[:, : chip_axes(cut)]
    frequency = tip.lines
    values = eigenvalues(tip, directional, frequency)
    for _ in range(_ROUNDS):
        ends = _paired(values[:-1], values[1:])
        coarse = _coarse(values[:-1], ends) & (np.diff(frequency) > 1e-9 * frequency[1:])
        if not np.any(coarse):
            break
        between = (frequency[:-1][coarse] + frequency[1:][coarse]) / 2
        values = np.concatenate([values, eigenvalues(tip, directional, between)])
        frequency, order = np.unique(np.concatenate([frequency, between]), return_index=True)
        values = values[order]
    count = values.shape[1]
    begin, end = values[:-1].ravel(), _paired(values[:-1], values[1:]).ravel()
    keep = np.minimum(np.abs(begin), np.abs(end)) > _NEGLIGIBLE * np.max(np.abs(values))
    low, high = (np.repeat(part, count)[keep] for part in (frequency[:-1], frequency[1:]))
    return Branches(tip, directional, low, high, begin[keep], end[keep])


def _paired(
    first: Complex[np.ndarray, "cell axis"], second: Complex[np.ndarray, "cell axis"]
) -> Complex[np.ndarray, "cell axis"]:
    """The second eigenvalues in the order in which they lie nearest to the first."""
    orders = np.array(list(itertools.permutations(range(first.shape[1]))))
    moved = second[:, orders]  # cell, order, axis
    nearest = np.argmin(np.sum(np.abs(moved - first[:, None, :]), axis=2), axis=1)
    return moved[np.arange(len(first)), nearest]


def _coarse(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Cells where an eigenvalue of account turns or grows too far."""
    size = np.maximum(np.abs(begin), np.abs(end))
    counts = size > 1e-4 * np.max(size)
    small = np.minimum(np.abs(begin), np.abs(end))
    ratio = np.divide(end, begin, out=np.ones_like(end), where=begin != 0)
    return np.any(counts & ((np.abs(np.angle(ratio)) > _TURN) | (size > _GROWTH * small)), axis=1)
