"""How high a hidden effect stands once all that may take it up is fitted to it.

The height of `severity` is judged without re-tuning anything. A robot's stiffness, damping, masses and
inertias, and the numbers of what else is hidden, take up some of an effect, some effects altogether: what is
left is all that measurements can tell of it. It is the root mean square over the same lines of

    r = ln(H with / H without the effect) − J p,

p the least of Σ|r|²/σ² + Σ (p/s)², J the derivatives of ln H without the effect along the logarithms of the
robot's parameters, of deviation s as the card is off, and along the numbers of the other effects, free; σ is
the noise of one record. Of an effect that is linear H is taken anew and the step repeated (Gauss and Newton),
beside the linear ones of the others alone. Of one that is not, J is that of the linear others, and there is
one step: what re-tuning takes of it is told as too little.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.believed import ParameterError, known_robot
from flexmodal.rig.effects import Stand
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.severity import (
    Floor,
    noise_floor,
    predicted,
    struck,
    struck_numbers,
    usable_blows,
    usable_lines,
)
from flexmodal.rig.plant.build import Hidden

STEPS, PARTS = 5, (1.0, 0.5, 0.2)
"""Of Gauss and Newton, and parts of a step that are tried where a longer one leads up."""
FAR = math.log(10.0)
"""How far a number is re-tuned at most, as a logarithm: beyond it there may be no model any more."""
SMALL = 1e-4
"""Relative change of a parameter that derivatives are taken by."""
FREE = 1.0
"""Standard deviation of the logarithm of a number of another effect."""


def retuned_heights(
    stand: Stand, hidden: Sequence[Hidden], conduct: Conduct, error: ParameterError
) -> tuple[float, ...]:
    """Of each hidden effect the height that is left beside the others, over the noise of one record.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        conduct: noise, scatter and seed; without noise there are no heights.
        error: how far the card is off; what it is right in is not fitted.
    """
    if not conduct.noise:
        return ()
    floor = noise_floor(stand, conduct)
    return tuple(retuned_height(stand, hidden, number, floor, error) for number in range(len(hidden)))


def retuned_height(
    stand: Stand, hidden: Sequence[Hidden], number: int, floor: Floor, error: ParameterError
) -> float:
    """Root mean square of what is left of one effect beside the others, over that of the noise of one record.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        number: which of them.
        floor: the noise, and lines to take it on.
        error: how far the card is off; what it is right in is not fitted.
    """
    others = [one for k, one in enumerate(hidden) if k != number]
    linear = [one for one in others if one[0].linear]
    tuned = _Tuned(stand, linear, error)
    if hidden[number][0].linear:
        target, usable = predicted(stand, [*linear, hidden[number]], floor), usable_lines(floor)
        left = _iterated(tuned, target, usable, floor)
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            whole = np.log(struck(stand, hidden, floor) / struck(stand, others, floor))
        usable = usable_blows(stand, floor) & np.isfinite(whole)
        slopes = tuned.slopes(np.zeros(len(tuned.deviation)), floor)[:, struck_numbers(floor)]
        slopes = np.broadcast_to(slopes[:, :, None], (len(slopes), *whole.shape))[:, usable]
        step = _step(slopes, whole[usable], np.zeros(len(slopes)), tuned.deviation, floor.height)
        left = whole[usable] - np.tensordot(step, slopes, 1)
    return float(np.sqrt(np.mean(np.abs(left) ** 2)) / floor.height) if left.size else 0.0


class _Tuned:
    """Robot and linear effects, as functions of the logarithms of factors on their numbers."""

    def __init__(self, stand: Stand, others: Sequence[Hidden], error: ParameterError) -> None:
        self.stand, self.others = stand, others
        sizes = {name: float(getattr(error, name.partition(".")[0])) for name in stand.true.factors}
        self.names = [name for name, size in sizes.items() if size > 0]
        self.numbers = [
            (k, name) for k, (_, site) in enumerate(others) for name, one in site.parameters.items() if one
        ]
        self.deviation = np.array([sizes[name] for name in self.names] + [FREE] * len(self.numbers))

    def at(self, change: Float[np.ndarray, " parameter"], floor: Floor) -> np.ndarray:
        """What is predicted at some logarithms [posture, reference, point, axis, line]."""
        factor = np.exp(change).tolist()
        robots = dict(zip(self.names, factor, strict=False))
        numbers = dict(zip(self.numbers, factor[len(self.names) :], strict=True))
        known = self.stand.true.factors
        true = known_robot(
            self.stand.robot, {name: one * robots.get(name, 1.0) for name, one in known.items()}
        )
        stand = replace(self.stand, true=true)
        moved = [
            (effect, replace(site, stand=stand, parameters={
                name: one * numbers.get((k, name), 1.0) for name, one in site.parameters.items()
            }))
            for k, (effect, site) in enumerate(self.others)
        ]  # fmt: skip
        return predicted(stand, moved, floor)

    def slopes(self, change: Float[np.ndarray, " parameter"], floor: Floor) -> np.ndarray:
        """Derivatives of ln H [parameter, posture, reference, point, axis, line]."""
        here = self.at(change, floor)
        steps = SMALL * np.eye(len(change))
        with np.errstate(divide="ignore", invalid="ignore"):
            found = [np.log(self.at(change + step, floor) / here) / SMALL for step in steps]
        slopes = np.reshape(np.array(found, dtype=complex), (len(change), *here.shape))
        return np.where(np.isfinite(slopes), slopes, 0.0)


def _iterated(tuned: _Tuned, target: np.ndarray, usable: np.ndarray, floor: Floor) -> np.ndarray:
    """What is left of ln H after some steps, each as long as it leads down."""

    def off(change: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.asarray(np.log(target / tuned.at(change, floor))[usable])

    def size(left: np.ndarray) -> float:
        return float(np.sum(np.abs(left) ** 2))

    change = np.zeros(len(tuned.deviation))
    left = off(change)
    usable, left = usable.copy(), left[able := np.isfinite(left)]
    usable[usable] = able
    for _ in range(STEPS):
        step = _step(tuned.slopes(change, floor)[:, usable], left, change, tuned.deviation, floor.height)
        tried = ((one, off(one)) for one in (np.clip(change + part * step, -FAR, FAR) for part in PARTS))
        found = next(((one, rest) for one, rest in tried if size(rest) < size(left)), None)
        if found is None:
            break
        change, left = found
    return left


def _step(
    slopes: np.ndarray, left: np.ndarray, change: np.ndarray, deviation: np.ndarray, noise: float
) -> np.ndarray:
    """To the least of the sum above."""
    curvature = np.real(slopes.conj() @ slopes.T) / noise**2 + np.diag(deviation**-2.0)
    return np.linalg.solve(curvature, np.real(slopes.conj() @ left) / noise**2 - change / deviation**2)
