"""What a fitted explanation predicts for measurements that are planned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.next_measurement.information import Predicted
from flexmodal.errors import SingularResponse
from flexmodal.identification import Observations, unlimited
from flexmodal.identification.model import evaluated


@dataclass(frozen=True, eq=False)
class Sure:
    """A fitted hypothesis, how sure its parameters are, and how probable it is beside the others."""

    hypothesis: Hypothesis
    x: np.ndarray
    covariance: np.ndarray
    weight: float = 1.0


def predicted_by(fit: Sure, there: Context, planned: Observations, lines: slice) -> Predicted:
    """What a model predicts; in records without an end where it rings up within those that are planned.

    Args:
        fit: the model.
        there: its context with what is planned.
        planned: measurements.
        lines: of their FRFs.
    """
    moved = Hypothesis(there, fit.hypothesis.base, fit.hypothesis.placed)
    count = len(planned.axis.take(lines))
    value = np.zeros((len(planned), count), dtype=complex)
    slopes = np.zeros((len(moved.space), len(planned), count), dtype=complex)
    try:
        every = list(evaluated(moved, fit.x, planned, lines, slopes=True))
    except SingularResponse:
        every = list(evaluated(moved, fit.x, unlimited(planned), lines, slopes=True))
    for some, found, changes in every:
        value[some], slopes[:, some] = found, changes
    return relative(value, slopes, fit)


def relative(value: np.ndarray, slopes: np.ndarray, fit: Sure) -> Predicted:
    """Slopes of ln(value); what does not move, or has no finite value, is nothing and tells nothing.

    Args:
        value: of each row and line.
        slopes: along each parameter.
        fit: the model.
    """
    known = np.isfinite(value) & (value != 0)
    return Predicted(
        np.where(known, value, 0.0),
        np.where(known, slopes, 0.0) / np.where(known, value, 1.0),
        fit.covariance,
    )
