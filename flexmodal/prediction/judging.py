"""How methods are compared by postures that were left out, and how much of what was learnt is taken.

Who asks for a posture asks for one: a method is chosen by its typical gap, the geometric mean over postures.
A root mean square is that of the worst posture, such as one in which a point stands still in the model and in
the robot moves a little: ln of next to nothing over nothing, in which all other postures have no part.

A new posture is about as far from the struck ones as these are from each other. One that has a twin is
predicted well by the twin, and says nothing of such a posture: postures count by how far they are from the
others wherever methods are compared.

How much of what is learnt beside the physics goes into a prediction is such a choice too: the share s of
e^(s r) that leaves least of the physics' squared gap on postures left out. A few postures tell it badly, and
the whole of it loses to none where next to nothing could be learnt; so it is drawn towards one half, as if
`PRIOR` postures more had said that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.identification.baselines import posture_distance
from flexmodal.prediction.methods import METHODS

CLEARLY = 0.98
"""A method takes the place of one that is trusted more from this multiple of its gap down."""
HARDLY = 0.999
"""The same of the squared gap of a larger part of motion beside the model."""
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""That are tried; between them the square of the gap is a parabola, but for phases beyond half a turn."""
USUAL, PRIOR = 0.5, 6
"""Share that is expected, and postures that this counts for; on 24 campaigns 4 to 16 of them did alike."""
ALONE = 0.0
"""Weight that is expected of a prediction without physics beside one with it."""


def best(gaps: Mapping[str, Float[np.ndarray, " posture"]], weight: Float[np.ndarray, " posture"]) -> str:
    """The method with the smallest typical gap, one that is trusted more where the two are alike.

    Alike are those within 2 %, and those whose difference is smaller than its standard error: three postures
    tell no tenth.

    Args:
        gaps: by method, of each posture.
        weight: what each posture counts for.
    """
    chosen, *others = [name for name in METHODS if name in gaps]
    for name in others:
        mean, error = _nearer(gaps[name], gaps[chosen], weight)
        if mean > max(-math.log(CLEARLY), error):
            chosen = name
    return chosen


def _nearer(
    one: Float[np.ndarray, " posture"], other: Float[np.ndarray, " posture"], weight: np.ndarray
) -> tuple[float, float]:
    """Mean over postures of ln(other / one), and its standard error; 0 for one posture."""
    there = np.isfinite(one) & np.isfinite(other) & (one > 0) & (other > 0)
    if not there.any():
        return 0.0, 0.0
    part = weight[there] / weight[there].sum()
    apart = np.log(other[there] / one[there])
    mean = float(part @ apart)
    spread = float(part @ (apart - mean) ** 2)
    return mean, math.sqrt(spread / max(len(apart) - 1, 1))


def best_share(
    gaps: Float[np.ndarray, "posture share"], weight: Float[np.ndarray, " posture"], usual: float = USUAL
) -> float:
    """The share of what was learnt that leaves least of the squared gap, drawn towards the usual one.

    Args:
        gaps: of each posture left out, with each of `SHARES`; each counts by its part of the gap without.
        weight: what the lines of each posture count for together.
        usual: the share that is expected, where postures say nothing.
    """
    there = np.isfinite(gaps).all(axis=1) & (gaps[:, 0] > 0)
    count = int(there.sum())
    if not count:
        return usual
    square = weight[there] @ (gaps[there] / gaps[there, :1]) ** 2 / weight[there].sum()
    curve, slope, _ = np.polyfit(SHARES, square, 2)
    least = -slope / (2 * curve) if curve > 0 else SHARES[int(np.argmin(square))]
    return float((count * np.clip(least, 0.0, 1.0) + PRIOR * usual) / (count + PRIOR))


def best_part(
    gaps: Float[np.ndarray, "posture part"], weight: Float[np.ndarray, " posture"], parts: Sequence[float]
) -> float:
    """The largest part that leaves hardly more of the squared gap than the best does.

    Postures in which something stands still may be those that nobody struck: a larger part costs next to
    nothing elsewhere, and much there if it is missing.

    Args:
        gaps: of each posture left out, with each part; each counts by its part of the first.
        weight: what the lines of each posture count for together.
        parts: ascending.
    """
    there = np.isfinite(gaps).all(axis=1) & (gaps[:, 0] > 0)
    if not there.any():
        return parts[0]
    square = weight[there] @ (gaps[there] / gaps[there, :1]) ** 2
    return float(max(part for part, one in zip(parts, square, strict=True) if HARDLY * one <= square.min()))


def standings(postures: Sequence[Mapping[str, float]]) -> Float[np.ndarray, " posture"]:
    """Distance of each posture from the nearest other over the root mean square of these, 1 at most.

    Args:
        postures: joints of each [rad, m].
    """
    near = np.array(
        [
            min(posture_distance(one, other) for k, other in enumerate(postures) if k != number)
            for number, one in enumerate(postures)
        ]
    )
    usual = math.sqrt(float(np.mean(near**2)))
    return np.minimum(near / usual, 1.0) if usual > 0 else np.ones(len(near))


def together(each: Float[np.ndarray, " posture"], weight: Float[np.ndarray, " posture"]) -> float:
    """The gap over several postures; those with nothing to judge are left out.

    Args:
        each: gap of each posture.
        weight: what the lines of each count for together.
    """
    there = np.isfinite(each)
    return float(np.sqrt(np.sum((weight * each**2)[there]) / np.sum(weight[there])))


def typical(each: Float[np.ndarray, " posture"], weight: Float[np.ndarray, " posture"]) -> float:
    """Geometric mean of the gaps of several postures; those with nothing to judge are left out.

    Args:
        each: gap of each posture.
        weight: what the lines of each count for together.
    """
    there = np.isfinite(each)
    with np.errstate(divide="ignore"):
        return float(np.exp(np.sum((weight * np.log(each))[there]) / np.sum(weight[there])))
