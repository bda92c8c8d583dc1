"""Which mode of the model a measured mode is: by natural frequency and, where there are shapes, by MAC."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.modal.tracking import assign
from flexmodal.structure.poles import Poles

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
    if not len(frequency):
        return []
    away = 1 - np.exp(-((np.log(found.frequency[None, :] / frequency[:, None]) / scale) ** 2))
    if alike is not None:
        away = np.where(np.isnan(alike), away, shape_weight * (1 - alike) + (1 - shape_weight) * away)
    away[:, found.pole[: found.count].imag == 0] = 10.0  # does not oscillate: nobody measured it
    return assign(away, SINGLE).tolist()
