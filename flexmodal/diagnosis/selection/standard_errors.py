"""Standard errors of what follows from a fit's coordinates, by finite differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

STEP = 1e-5
"""Of the differences along coordinates."""


def with_errors(
    follows: Callable[[Float[np.ndarray, " parameter"]], Float[np.ndarray, " value"]],
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
) -> tuple[Float[np.ndarray, " value"], Float[np.ndarray, " value"]]:
    """Values at some coordinates, and √(g C gᵀ) of each, g its slopes.

    Args:
        follows: values from coordinates.
        x: coordinates.
        covariance: of these.
    """
    here = follows(x)
    slopes = np.array([(follows(x + STEP * unit) - here) / STEP for unit in np.eye(len(x))]).T
    return here, np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", slopes, covariance, slopes), 0.0))
