"""How a robot moves where its model stands still.

No arm moves as its model says and not at all across: links twist, bearings give, a hammer is tilted by some
degrees, a sensor hears a few per cent of what goes across its axis. Where a model has next to nothing, an
error of its logarithm says how little, and not how far the model is from the robot.

So the robot's receptance is taken to be that of the model, H, and beside it some motion of which nothing is
known but its size s: e, normally distributed in the complex plane with E|e|² = s². What comes nearest to
ln|H + e| in the mean square is its expectation,

    E ln|H + e| = ln|H| + E₁(|H|²/s²)/2,

E₁ the exponential integral: the logarithm of the mean of a noncentral χ² of two degrees of freedom (Lapidoth
and Moser, IEEE Transactions on Information Theory 49, 2003, theorem 10.2). It is ln|H| where H is large and
ln s − γ/2 where it is nothing, γ Euler's constant.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Int

PARTS = (0.01, 0.02, 0.05, 0.1, 0.2)
"""s over the motion there is: the mean of the struck postures at that place and line, and no more than the
largest that the model has at any place of this posture, where the arm may move little in all. Those that are
tried."""
NOTHING = 1e-12
"""|H|²/s² below which the limit is taken, and the phase is that of the mean."""


def with_cross_motion(
    model: Complex[np.ndarray, "row line"],
    usual: Complex[np.ndarray, "row line"],
    part: float,
    posture: Int[np.ndarray, " row"] | None = None,
) -> Complex[np.ndarray, "row line"]:
    """A model's receptances, no smaller than what moves beside the model.

    Args:
        model: H, of any places and lines [m/N].
        usual: the mean of the struck postures there [m/N].
        part: of the motion there is that moves beside the model.
        posture: number of the posture of each row; one and the same if None.
    """
    from scipy.special import exp1

    size = np.abs(model)
    numbers = np.zeros(len(model), dtype=int) if posture is None else posture
    most = np.zeros_like(size)
    for number in np.unique(numbers):
        most[numbers == number] = size[numbers == number].max(axis=0)
    beside = part * np.where(most > 0, np.minimum(np.abs(usual), most), np.abs(usual))
    square = (size / np.where(beside > 0, beside, 1.0)) ** 2
    some = square > NOTHING
    larger = np.exp(exp1(np.where(some, square, 1.0)) / 2)
    found = np.where(some, model * larger, usual / np.maximum(np.abs(usual), 1e-300) * beside * _LEAST)
    return np.where(beside > 0, found, model)


_LEAST = float(np.exp(-np.euler_gamma / 2))
