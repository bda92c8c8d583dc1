"""How far a prediction may be off: the errors of the same method on postures that it had not seen.

At each place and line the squared errors of ln size and of phase, of all postures that were left out, are
averaged over neighbouring lines, on axes laid over each other at the resonances; a line that nothing was
measured on above the noise has the largest of its place. The band is

    ± t · √(1 + 1/n) · root mean square,

Student's t for n − 1 degrees of freedom, n postures. Noise of the measurement is in it. Farther from the
measured postures than these are from each other it is wider in that proportion, unless physics alone
predicts.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from flexmodal.identification.baselines import posture_distance
from flexmodal.identification.frf_fit import residual
from flexmodal.prediction.alignment import aligned
from flexmodal.prediction.leave_one_out import LeftOut

CONFIDENCE = 0.95
REACH = 4
"""Lines to either side that are averaged over."""
WIDEST = math.log(1e3)
"""Of ln size: a factor of a thousand says that nothing is known."""


def band(
    left: LeftOut, method: str, resonances: Float[np.ndarray, " mode"]
) -> tuple[Float[np.ndarray, "place line"], Float[np.ndarray, "place line"]]:
    """Half widths of ln size and of phase [rad] at each place and line.

    Args:
        left: errors on postures that were left out.
        method: that predicts.
        resonances: natural frequencies of the posture that is predicted [Hz].
    """
    from scipy.special import stdtrit

    panel, axis = left.panel, left.panel.axis
    seen, count = panel.observations, len(left.postures)
    total = np.zeros((2, len(panel.pairs), len(axis)))
    weight = np.zeros((len(panel.pairs), len(axis)))
    for number in left.postures:
        there = aligned(axis, resonances, left.resonances[number])
        for row in panel.of_posture(number).tolist():
            error = residual(left.predicted[method][row], seen.value[row])
            used = seen.used[row].astype(float)
            for part, value in enumerate((error.real, error.imag)):
                total[part, panel.place[row]] += np.interp(there, axis, used * value**2)
            weight[panel.place[row]] += np.interp(there, axis, used)
    means = np.array([_smoothed(part) for part in total]) / np.maximum(_smoothed(weight), 1e-12)
    enough = _smoothed(weight) > 0
    most = np.where(enough, means, 0).max(axis=2, keepdims=True)
    means = np.where(enough, means, np.where(most > 0, most, WIDEST**2))
    factor = float(stdtrit(max(count - 1, 1), (1 + CONFIDENCE) / 2)) * math.sqrt(1 + 1 / count)
    half = factor * np.sqrt(means)
    return np.minimum(half[0], WIDEST), np.minimum(half[1], np.pi)


def remoteness(left: LeftOut, q: dict[str, float]) -> float:
    """Distance to the nearest measured posture over the typical one between these; 1 where it is less.

    Args:
        left: the measured postures.
        q: posture that is predicted [rad, m].
    """
    postures = [left.panel.observations.postures[number].q for number in left.postures]
    away = min(posture_distance(q, one) for one in postures)
    between = [
        min(posture_distance(one, other) for other in postures if other is not one) for one in postures
    ]
    usual = math.sqrt(float(np.mean(np.square(between))))
    return max(1.0, away / usual) if usual > 0 else 1.0


def _smoothed(value: Float[np.ndarray, "place line"]) -> Float[np.ndarray, "place line"]:
    """Sum over `REACH` lines to either side; fewer at the ends."""
    lines = value.shape[1]
    total = np.concatenate([np.zeros((len(value), 1)), np.cumsum(value, axis=1)], axis=1)
    first = np.maximum(np.arange(lines) - REACH, 0)
    last = np.minimum(np.arange(lines) + REACH + 1, lines)
    return np.maximum(total[:, last] - total[:, first], 0.0)
