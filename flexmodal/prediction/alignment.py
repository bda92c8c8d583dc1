"""Frequency axes laid over each other so that resonances of the same number meet.

What physics leaves of a resonance is a sharp feature at that resonance, which moves with the posture. At a
fixed frequency it would come and go; between the same two resonances of the model it stays where it is. The
axis of one posture is therefore mapped to that of another by straight lines in ln f that lead each natural
frequency of the model to the one of the same number.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.identification import RobotModel
from flexmodal.structure.poles import poles

OSCILLATING = 0.5
"""Damping ratio up to which a pole makes a peak."""
BEYOND = 100.0
"""So many times below the first and above the last natural frequency the ratio of the axes stays theirs."""


def natural_frequencies(
    model: RobotModel, x: Float[np.ndarray, " parameter"], q: Mapping[str, float]
) -> Float[np.ndarray, " mode"]:
    """Natural frequencies of the modes that make peaks, ascending [Hz].

    Args:
        model: the robot and what was fitted.
        x: coordinates of the fit.
        q: posture [rad, m].
    """
    found = poles(model.structure_at(x, q, [], []))
    return np.sort(found.frequency[found.damping_ratio < OSCILLATING])


def aligned(
    frequency: Float[np.ndarray, " line"],
    here: Float[np.ndarray, " mode"],
    there: Float[np.ndarray, " other"],
) -> Float[np.ndarray, " line"]:
    """Where on the axis of another posture the same place between the same resonances is [Hz].

    Args:
        frequency: on the axis of this posture [Hz].
        here: natural frequencies of this posture, ascending [Hz].
        there: of the other; where one has more, the highest of those have no partner.
    """
    count = min(len(here), len(there))
    if not count or np.any(np.diff(here[:count]) <= 0):
        return frequency
    ends = (1 / BEYOND, BEYOND)
    known = np.concatenate([[here[0] * ends[0]], here[:count], [here[count - 1] * ends[1]]])
    meant = np.concatenate([[there[0] * ends[0]], there[:count], [there[count - 1] * ends[1]]])
    return np.exp(np.interp(np.log(frequency), np.log(known), np.log(meant)))


def resampled(
    value: Complex[np.ndarray, "row line"],
    axis: Float[np.ndarray, " line"],
    wanted: Float[np.ndarray, " point"],
) -> Complex[np.ndarray, "row point"]:
    """Rows at other frequencies, straight between their lines and constant beyond.

    Args:
        value: of each line.
        axis: frequencies of the lines, ascending [Hz].
        wanted: frequencies [Hz].
    """
    rows = [np.interp(wanted, axis, row.real) + 1j * np.interp(wanted, axis, row.imag) for row in value]
    return np.array(rows).reshape(len(value), len(wanted))
