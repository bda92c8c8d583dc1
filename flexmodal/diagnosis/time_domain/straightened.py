"""Measurements as if torques that are integrated in time were their stand-ins at one amplitude.

What they do beyond these is taken from a model that has them. All that is linear is then looked for in
frequency, at a small part of what integrations take.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.identification import Observations, predict
from flexmodal.identification.frf_fit import residual

_MOST_BEYOND = 5.0
"""ln of what torques do beyond their stand-ins, from which nothing is taken out: one of them is nothing."""


def straightened(
    observations: Observations,
    root: Hypothesis,
    x: Float[np.ndarray, " parameter"],
    predicted: Complex[np.ndarray, "observation line"],
) -> Observations:
    """Observations as if the stand-ins of torques that are integrated were what they stand for.

    Args:
        observations: as measured.
        root: the robot with such torques.
        x: its coordinates.
        predicted: receptances of the same with those torques integrated [m/N].
    """
    beyond = residual(predicted, predict(root, x, observations))
    known = np.abs(beyond) < _MOST_BEYOND
    return replace(observations, value=observations.value * np.exp(-np.where(known, beyond, 0.0)))
