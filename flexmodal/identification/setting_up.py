"""What nobody set up exactly, as parameters with priors: angles of each posture, places, directions, gains.

Each nuisance parameter τ has the standard deviation that `[tolerance]` gives it. To first order it changes
ln H by s τ, with s from the robot's own FRFs (`Sensitivities`). Together with the robot's parameters x, whose
derivatives are J, it is found by Gauss and Newton's method,

    min |r + J δx + S τ|²/σ² · κ/s² + |x + δx|²/σₓ² + |τ|²/σ_τ²,

κ the part of the lines that count, as neighbouring ones share their errors, and s² ≥ 1 the mean square of
what is left: where something is missing from the model that is large, and nothing is moved to make up for
it. At first κ and s² are those of what is left before; beside what was fitted closely, which may be all
there is, those of what is left with everything free, for what is moved then is no noise either. A parameter
that the data do not ask for is not fitted: its score has to promise `WORTH` nats (Rao's test).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.campaign import Tolerance
from flexmodal.identification.descent import HUBER
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.model import FrfModel, evaluated
from flexmodal.identification.observations import Observations
from flexmodal.identification.sensitivities import Nuisance, Sensitivities, moved, nuisances_of
from flexmodal.identification.shared import independence

WORTH = 3.0
"""Evidence that fitting a parameter has to promise by its score [nat]."""
FLOOR = 0.02
"""Relative error that the model is granted besides."""
FAR = 3.0
"""Standard deviations of its tolerance from which a parameter is told as far outside."""
ROUNDS = 4
"""Of looking at the scores and moving, at most."""
TEMPERED = 3
"""Times that κ and s² are taken from what is left with everything free."""
SETTLED = 0.1
"""Standard deviations of a tolerance: steps below are the last."""
_MOST_LAG = 40


@dataclass(frozen=True)
class Found:
    """A nuisance parameter that the data asked for."""

    nuisance: Nuisance
    value: float
    """[unit of the nuisance]"""
    deviation: float
    """Its standard error."""

    @property
    def is_far(self) -> bool:
        """Whether it lies far outside its tolerance."""
        return abs(self.value) > FAR * self.nuisance.deviation


@dataclass(frozen=True, eq=False)
class SetUp:
    """Observations as they were most likely set up."""

    observations: Observations
    """With angles, places, directions and gains moved."""
    found: tuple[Found, ...] = ()
    """What was moved, the farthest outside first."""
    left: Tolerance | None = None
    """What is still open, typically of each kind; None where nothing was to begin with."""
    x: Float[np.ndarray, " parameter"] | None = None
    """The model's coordinates after the last step."""

    @property
    def settings(self) -> list[tuple[Nuisance, float]]:
        """What was moved, and by how much."""
        return [(one.nuisance, one.value) for one in self.found]


def far_words(found: Iterable[Found]) -> tuple[str, ...]:
    """A sentence for each that lies far outside its tolerance.

    Args:
        found: what was moved.
    """
    return tuple(
        f"{one.nuisance.says[0].upper()}{one.nuisance.says[1:]} seems off by "
        f"{f'{one.value:.2g} {one.nuisance.unit}'.rstrip()}, {abs(one.value) / one.nuisance.deviation:.0f} "
        "times its tolerance."
        for one in found
        if one.is_far
    )


@dataclass(frozen=True, eq=False)
class Beside:
    """A fitted model beside which it is looked at how a test was set up."""

    model: FrfModel
    """Of the robot, with or without effects."""
    x: Float[np.ndarray, " parameter"]
    """Where it was fitted."""
    factor: Complex[np.ndarray, "observation line"] | None = None
    """What is known to be predicted over what the model gives; 1 if None."""
    begun: SetUp | None = None
    """What was moved when it was fitted closely, so that it may be all there is; if None nothing was, and the
    fit was coarse."""


def set_up(
    beside: Beside,
    observations: Observations,
    lines: Int[np.ndarray, " looked"],
    prior: Float[np.ndarray, "observation line"],
    *,
    far: bool = True,
) -> SetUp:
    """Move what the data ask for.

    Args:
        beside: what was fitted.
        observations: as they are said to have been set up; variances of noise alone.
        lines: numbers of the lines that are looked at.
        prior: variance that the tolerances add, by which residuals are weighed.
        far: whether what lies far outside its tolerance is moved; without it that is left to effects of
            sensors, angles of postures alone being moved as far as they have to.
    """
    kept = ~np.zeros(len(list(nuisances_of(observations))), dtype=bool)
    while True:
        found = _moved_by(_Looked(beside, lines, prior), observations, kept)
        odd = np.array([not far and one.kind != "posture" for one in found.nuisances])
        odd &= np.abs(found.values) > FAR * found.deviations
        if not odd.any():
            break
        kept &= ~odd
    told = [
        Found(one, float(value), float(error))
        for one, value, error in zip(found.nuisances, found.values, found.errors, strict=True)
        if value
    ]
    told.sort(key=lambda one: -abs(one.value) / one.nuisance.deviation)
    return SetUp(found.observations, tuple(told), found.left, found.x)


@dataclass(frozen=True, eq=False)
class _Moved:
    """Where the rounds ended."""

    observations: Observations
    nuisances: tuple[Nuisance, ...]
    values: Float[np.ndarray, " nuisance"]
    errors: Float[np.ndarray, " nuisance"]
    """With all of them free."""
    x: Float[np.ndarray, " parameter"]

    @property
    def deviations(self) -> Float[np.ndarray, " nuisance"]:
        return np.array([one.deviation for one in self.nuisances])

    @property
    def left(self) -> Tolerance:
        """Root mean square of the errors of each kind."""
        sizes = {}
        for kind in ("posture", "position", "direction", "gain"):
            own = [
                error
                for one, error in zip(self.nuisances, self.errors, strict=True)
                if one.kind.endswith(kind)
            ]
            sizes[kind] = float(np.sqrt(np.mean(np.square(own)))) if own else 0.0
        return Tolerance(**sizes)


@dataclass(frozen=True, eq=False)
class _Looked:
    """What stays the same in all rounds; see `set_up`."""

    beside: Beside
    lines: Int[np.ndarray, " looked"]
    prior: Float[np.ndarray, "observation line"]


def _moved_by(looked: _Looked, observations: Observations, kept: np.ndarray) -> _Moved:
    """Rounds of scores and steps, with some of the parameters left as they are."""
    keys = tuple(nuisances_of(observations))
    errors = np.array([one.deviation for one in keys])
    begun, x = looked.beside.begun, looked.beside.x
    known = dict(begun.settings) if begun is not None else {}
    total = kept * np.array([known.get(one, 0.0) for one in keys])
    now = moved(observations, [(one, value) for one, value in zip(keys, total, strict=True) if value])
    for _ in range(ROUNDS):
        sensitivities = Sensitivities.of(looked.beside.model, x, now, looked.lines)
        step, x, errors = _step(looked, x, now, sensitivities, total, kept)
        total = total + step
        now = moved(observations, [(one, value) for one, value in zip(keys, total, strict=True) if value])
        if np.all(np.abs(step) <= SETTLED * sensitivities.deviations):
            break
    return _Moved(now, keys, total, errors, x)


def _step(
    looked: _Looked,
    x: np.ndarray,
    observations: Observations,
    sensitivities: Sensitivities,
    before: np.ndarray,
    kept: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Steps of the nuisance parameters, the robot's coordinates after them, and standard errors."""
    size, model, lines, factor = len(x), looked.beside.model, looked.lines, looked.beside.factor
    value, slopes = _evaluated(model, x, observations, lines)
    r = residual(value if factor is None else value * factor[:, lines], observations.value[:, lines])
    used = observations.used[:, lines]
    variance = np.where(used, observations.variance[:, lines], 1.0) + FLOOR**2
    scaled = np.abs(r) ** 2 / (variance + looked.prior[:, lines])
    counted = used * np.minimum(1.0, HUBER / np.sqrt(np.maximum(scaled, 1e-300)))
    root = np.sqrt(counted / variance)
    own = (slopes / np.where(value == 0, np.inf, value) * root).reshape(size, -1)
    design, pull = np.concatenate([own, sensitivities.weighed(root)]), r * root
    precision = np.concatenate([model.space.precision, 1 / sensitivities.deviations**2])
    normal, gradient = _normal(design, pull.ravel())
    back = precision * np.concatenate([x, before])
    temper = _temper(r, variance, used)
    for _ in range(TEMPERED if looked.beside.begun is not None else 0):
        every = -np.linalg.solve(temper * normal + np.diag(precision), temper * gradient + back)
        change = (every @ design).reshape(r.shape) / np.where(used, root, np.inf)
        temper = _temper(r + change, variance, used)
    normal, gradient = temper * normal, temper * gradient + back
    promising = _asked(normal, gradient, precision, size)[size:] | (before != 0)
    asked = np.concatenate([np.ones(size, dtype=bool), promising & kept])
    errors = np.sqrt(np.diag(np.linalg.inv(normal + np.diag(precision))))[size:]
    if not asked[size:].any():
        return np.zeros_like(before), x, errors
    step = np.zeros(len(precision))
    step[asked] = -np.linalg.solve(normal[np.ix_(asked, asked)] + np.diag(precision[asked]), gradient[asked])
    low, high = model.space.bounds
    return step[size:], np.clip(x + step[:size], low, high), errors


def _asked(normal: np.ndarray, gradient: np.ndarray, precision: np.ndarray, size: int) -> np.ndarray:
    """Which nuisance parameters promise enough by their score, the robot's own being free beside each."""
    found = np.zeros(len(precision), dtype=bool)
    whole = normal[:size, :size] + np.diag(precision[:size])
    cross = normal[:size, size:]
    solved = np.linalg.solve(whole, np.column_stack([gradient[:size], cross]))
    score = gradient[size:] - cross.T @ solved[:, 0]
    curvature = np.diag(normal)[size:] + precision[size:] - np.sum(cross * solved[:, 1:], axis=0)
    found[size:] = score**2 / (2 * curvature) > WORTH
    return found


def _normal(design: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    flat = np.concatenate([design.real, design.imag], axis=1)
    return flat @ flat.T, flat @ np.concatenate([pull.real, pull.imag])


def _temper(r: np.ndarray, variance: np.ndarray, used: np.ndarray) -> float:
    """κ/s²: by how much of the lines count, and how large what is left is."""
    z = np.where(used, r, 0.0) / np.sqrt(variance)
    z = z * np.minimum(1.0, HUBER / np.maximum(np.abs(z), 1e-12))
    mean = float(np.sum(np.abs(z) ** 2)) / max(int(used.sum()), 1)
    return independence(z, _MOST_LAG) / max(1.0, mean)


def _evaluated(
    model: FrfModel, x: np.ndarray, observations: Observations, lines: np.ndarray
) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "parameter observation line"]]:
    shape = len(observations), len(lines)
    value, slopes = np.zeros(shape, dtype=complex), np.zeros((len(x), *shape), dtype=complex)
    for some, found, changes in evaluated(model, x, observations, lines, slopes=True):
        value[some], slopes[:, some] = found, changes
    return value, slopes
