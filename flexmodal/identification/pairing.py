"""Which mode of the model a measured mode is: by natural frequency and, where there are shapes, by MAC."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.structure.poles import Poles
from flexmodal.structure.structure import Structure

SINGLE = 0.8
"""Pairs that disagree more are no pairs."""


def pair(
    frequency: Float[np.ndarray, " measured"],
    alike: Float[np.ndarray, "measured mode"] | None,
    found: Poles,
    *,
    scale: float = 0.1,
    shape_weight: float = 0.3,
) -> list[int]:
    """Pair measured modes with the oscillating modes of the model, so that disagreements are least in sum.

    A pair disagrees by w(1 − MAC) + (1 − w)(1 − exp(−(ln(f₂/f₁)/s)²)), as in `flexmodal.modal.track`; a mode
    without a shape by its frequency alone.

    Args:
        frequency: measured [Hz].
        alike: MAC; NaN where there is no shape; None to go by frequency.
        found: of the model.
        scale: s, the relative difference that counts as a large one.
        shape_weight: w.

    Returns:
        For each measured mode its number in `found`, −1 where there is none.
    """
    from scipy.optimize import linear_sum_assignment

    if not len(frequency):
        return []
    away = 1 - np.exp(-((np.log(found.frequency[None, :] / frequency[:, None]) / scale) ** 2))
    if alike is not None:
        away = np.where(np.isnan(alike), away, shape_weight * (1 - alike) + (1 - shape_weight) * away)
    away[:, found.pole[: found.count].imag == 0] = 10.0  # does not oscillate: nobody measured it
    padded = np.concatenate([away, np.full((len(away), len(away)), SINGLE)], axis=1)
    rows, columns = linear_sum_assignment(padded)
    partner = [-1] * len(frequency)
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        if column < away.shape[1]:
            partner[row] = column
    return partner


def mac_table(
    structure: Structure,
    found: Poles,
    shapes: Sequence[Sequence[tuple[np.ndarray, np.ndarray]]],
) -> Float[np.ndarray, "measured mode"]:
    """MAC of measured shapes with the model's, of several hammer positions the mean; NaN without a shape.

    Args:
        structure: with the response rows of the places.
        found: its poles.
        shapes: of each measured mode, for each hammer position: row numbers in `structure.response`,
            residues.
    """
    table = np.full((len(shapes), found.count), np.nan)
    for k, some in enumerate(shapes):
        values = []
        for rows, residue in some:
            if len(rows) < 2:
                continue
            model = structure.response[rows] @ found.shape[:, : found.count]
            top = np.abs(residue.conj() @ model) ** 2
            values.append(
                top / np.maximum(np.sum(np.abs(model) ** 2, axis=0) * np.sum(np.abs(residue) ** 2), 1e-300)
            )
        if values:
            table[k] = np.mean(values, axis=0)
    return table
