"""Where a ported model's parameters set out: the robot at its card, named effects as they were fitted."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.lawfree.model import PortedModel


def origin(model: PortedModel) -> Float[np.ndarray, " parameter"]:
    """Where a fit sets out and its priors are centred.

    An effect that is named may be far from what was expected of it; drawn back there it would have to be
    found again.

    Args:
        model: with its ports.
    """
    x, card = np.zeros(len(model.space)), len(model.root.base)
    if model.fitted is not None:
        x[card : len(model.fitted)] = model.fitted[card:]
    return x


def beginnings(model: PortedModel) -> list[Float[np.ndarray, " parameter"]]:
    """The origin; the robot as it was fitted too, where that is known.

    Args:
        model: with its ports.
    """
    x = origin(model)
    if model.fitted is None:
        return [x]
    other = x.copy()
    other[: len(model.fitted)] = model.fitted
    return [x, other]
