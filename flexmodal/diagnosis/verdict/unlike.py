"""Effects that do what nothing of their name does, whatever their laws explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.decision import Answer, reaches
from flexmodal.diagnosis.selection.standard_errors import with_errors

SURE, MARGIN = 2.0, 0.1
"""Standard errors by which a figure goes beyond its limit at least, and the margin besides [1]: 10 %."""


@dataclass(frozen=True)
class Unlike:
    """One that does, or may."""

    key: tuple[str, str]
    """Name and place."""
    says: str
    """What it does."""
    answer: Answer


def unlike(
    hypothesis: Hypothesis,
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
) -> tuple[Unlike, ...]:
    """Those that surely go beyond what bears their name, and those of which that is undecided.

    Args:
        hypothesis: with effects.
        x: coordinates.
        covariance: of these; what the data do not tell speaks against no name.
    """
    found = []
    for placed in hypothesis.placed:
        beyond = _beyond(hypothesis, placed, x, covariance)
        if beyond is not None and (answer := reaches(beyond, 0.0, MARGIN)) > Answer.NO:
            found.append(Unlike(placed.key, placed.effect.unlike_says, answer))
    return tuple(found)


def _beyond(hypothesis: Hypothesis, placed: Placed, x: np.ndarray, covariance: np.ndarray) -> float | None:
    """Lower end of how far; None of effects that have no such figure."""
    measure = placed.effect.unlike
    if measure is None:
        return None

    def at(moved: np.ndarray) -> Float[np.ndarray, " one"]:
        values = hypothesis.values_of(placed, hypothesis.space.values(moved))
        return np.array([measure(hypothesis.context, values)])

    (here,) = at(x).tolist()
    if not np.isfinite(here) or here < -MARGIN:
        return float(here)
    _, (error,) = with_errors(at, x, covariance)
    return float(here - SURE * error)
