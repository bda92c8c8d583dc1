"""Measurements as those of a linear robot whose records last until all is still.

What the end of a record cuts off follows from the poles, which a free function of frequency does not have. It
is taken from the re-tuned robot, whose own is of the right size without being right: measurements are divided
by it, and twice its size counts as noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.compare import but_for_the_blow
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.errors import SingularResponse
from flexmodal.identification import Observations, predict, unlimited
from flexmodal.identification.frf_fit import residual

_UNSURE = 2.0
"""Standard deviation of what is cut off, over its size by the re-tuned robot; 0.9 to 2 on a six-link arm
whose first link bends, from the lowest line to the highest."""


def of_first_blow(
    observations: Observations, root: Hypothesis, x: Float[np.ndarray, " parameter"]
) -> Observations:
    """Observations of all kinds of blow as if each were of the first one.

    Args:
        observations: of a robot that depends on the blow as its stand-ins do.
        root: the robot.
        x: its coordinates.
    """
    owner = but_for_the_blow(observations)
    first = np.unique(owner, return_index=True)[1]
    try:
        value = predict(root, x, observations)
    except SingularResponse:  # which rings up, and says nothing
        return observations
    change = residual(value, value[first[owner]])
    return replace(observations, value=observations.value * np.exp(-change))


def endless(observations: Observations, root: Hypothesis, x: Float[np.ndarray, " parameter"]) -> Observations:
    """Observations as if their records lasted until all is still; as they are where the robot rings up.

    Args:
        observations: as recorded.
        root: the robot.
        x: its coordinates, re-tuned.
    """
    if observations.endless or not any(observations.lengths):
        return observations
    whole = unlimited(observations)
    try:
        cut = residual(predict(root, x, observations), predict(root, x, whole))
    except SingularResponse:  # it says nothing of what is cut off
        return observations
    size = np.minimum(np.abs(cut), 1.0)
    return replace(
        whole,
        value=whole.value * np.exp(-np.where(size < 1.0, cut, 0.0)),
        variance=whole.variance + (_UNSURE * size) ** 2,
    )
