"""One step towards how a test was most likely set up, beside a model that was fitted.

The formula stands in `setting_up`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.identification.descent import HUBER
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.model import FrfModel, evaluated
from flexmodal.identification.observations import Observations
from flexmodal.identification.sensitivities import Nuisance, Sensitivities
from flexmodal.identification.shared import independence

WORTH = 3.0
"""Evidence that fitting a parameter has to promise by its score [nat]."""
FLOOR = 0.02
"""Relative error that the model is granted besides."""
TEMPERED = 3
"""Times that κ and s² are taken from what is left with everything free."""
PLAUSIBLE = 3.0
"""Standard deviations by which the sum of squares of angles, each over its tolerance, may pass what it is
expected to be."""
HALVINGS = 60
"""Times at most that the data count for half as much, for angles to be plausible: next to nothing then."""
_MOST_LAG = 40


@dataclass(frozen=True, eq=False)
class Seen:
    """What the data are seen by."""

    model: FrfModel
    lines: Int[np.ndarray, " looked"]
    """Numbers of those that are looked at."""
    prior: Float[np.ndarray, "observation line"]
    """Variance that the tolerances add, by which residuals are weighed."""
    factor: Complex[np.ndarray, "observation line"] | None
    """What is known to be predicted over what the model gives; 1 if None."""
    closely: bool
    """Whether the model was fitted closely, so that it may be all there is."""


@dataclass(frozen=True, eq=False)
class SetUpStep:
    """What a step comes to."""

    change: Float[np.ndarray, " nuisance"]
    x: Float[np.ndarray, " parameter"]
    """The model's coordinates after it."""
    errors: Float[np.ndarray, " nuisance"]
    """Standard errors of the nuisance parameters, all of them free."""
    over_noise: float
    """What was left before it, over the noise."""


def step(
    seen: Seen,
    x: Float[np.ndarray, " parameter"],
    before: Float[np.ndarray, " nuisance"],
    observations: Observations,
    sensitivities: Sensitivities,
    kept: Bool[np.ndarray, " nuisance"],
    *,
    plausible: bool,
) -> SetUpStep:
    """One step of Gauss and Newton's method.

    Args:
        seen: what the data are seen by.
        x: coordinates of the model.
        before: values of the nuisance parameters.
        observations: with these moved; variances of noise alone.
        sensitivities: derivatives along the nuisance parameters.
        kept: which may move.
        plausible: whether angles of postures are no farther from what is said, all in all, than is plausible:
            the data count for less until that is so.
    """
    size, model, lines, factor = len(x), seen.model, seen.lines, seen.factor
    value, slopes = _evaluated(model, x, observations, lines)
    r = residual(value if factor is None else value * factor[:, lines], observations.value[:, lines])
    used = observations.used[:, lines]
    variance = np.where(used, observations.variance[:, lines], 1.0) + FLOOR**2
    scaled = np.abs(r) ** 2 / (variance + seen.prior[:, lines])
    counted = used * np.minimum(1.0, HUBER / np.sqrt(np.maximum(scaled, 1e-300)))
    root = np.sqrt(counted / variance)
    own = (slopes / np.where(value == 0, np.inf, value) * root).reshape(size, -1)
    design, pull = np.concatenate([own, sensitivities.weighed(root)]), r * root
    precision = np.concatenate([model.space.precision, 1 / sensitivities.deviations**2])
    normal, gradient = _normal(design, pull.ravel())
    back = precision * np.concatenate([x, before])
    temper, over_noise = _temper(r, variance, used)
    for _ in range(TEMPERED if seen.closely else 0):
        every = -np.linalg.solve(temper * normal + np.diag(precision), temper * gradient + back)
        linear = (every @ design).reshape(r.shape) / np.where(used, root, np.inf)
        temper, _ = _temper(r + linear, variance, used)
    told_of = np.diag(normal)[size:] > 0
    for _ in range(HALVINGS):
        told = temper * normal + np.diag(precision), temper * gradient + back
        promising = _asked(*told, size)[size:] | (before != 0)
        change = _solved(*told, np.concatenate([np.ones(size, dtype=bool), promising & kept]))
        if not plausible or _is_plausible(before + change[size:], sensitivities, told_of):
            break
        temper /= 2
    errors = np.sqrt(np.diag(np.linalg.inv(told[0])))[size:]
    if not (promising & kept).any():
        return SetUpStep(np.zeros_like(before), x, errors, over_noise)
    low, high = model.space.bounds
    return SetUpStep(change[size:], np.clip(x + change[:size], low, high), errors, over_noise)


def _solved(normal: np.ndarray, gradient: np.ndarray, asked: np.ndarray) -> np.ndarray:
    step = np.zeros(len(gradient))
    step[asked] = -np.linalg.solve(normal[np.ix_(asked, asked)], gradient[asked])
    return step


def _is_plausible(values: np.ndarray, sensitivities: Sensitivities, told_of: np.ndarray) -> bool:
    """Whether angles of postures, all in all, are no farther from what is said than tolerances let expect.

    A sum of squares of so many independent normal ones has a variance of twice their number.
    """
    over = (values / sensitivities.deviations)[angles_of(sensitivities.nuisances) & told_of]
    return bool(np.sum(over**2) <= len(over) + PLAUSIBLE * np.sqrt(2 * len(over)))


def angles_of(nuisances: Iterable[Nuisance]) -> Bool[np.ndarray, " nuisance"]:
    """Which nuisance parameters are angles of postures.

    Args:
        nuisances: of a set-up.
    """
    return np.array([one.kind == "posture" for one in nuisances], dtype=bool)


def _asked(normal: np.ndarray, gradient: np.ndarray, size: int) -> np.ndarray:
    """Which nuisance parameters promise enough by their score, the robot's own being free beside each."""
    found = np.zeros(len(gradient), dtype=bool)
    cross = normal[:size, size:]
    solved = np.linalg.solve(normal[:size, :size], np.column_stack([gradient[:size], cross]))
    score = gradient[size:] - cross.T @ solved[:, 0]
    curvature = np.diag(normal)[size:] - np.sum(cross * solved[:, 1:], axis=0)
    found[size:] = score**2 / (2 * curvature) > WORTH
    return found


def _normal(design: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    flat = np.concatenate([design.real, design.imag], axis=1)
    return flat @ flat.T, flat @ np.concatenate([pull.real, pull.imag])


def _temper(r: np.ndarray, variance: np.ndarray, used: np.ndarray) -> tuple[float, float]:
    """κ/s²: by how much of the lines count, and how large what is left is; the root of s² itself."""
    z = np.where(used, r, 0.0) / np.sqrt(variance)
    z = z * np.minimum(1.0, HUBER / np.maximum(np.abs(z), 1e-12))
    mean = float(np.sum(np.abs(z) ** 2)) / max(int(used.sum()), 1)
    return independence(z, _MOST_LAG) / max(1.0, mean), float(np.sqrt(mean))


def _evaluated(
    model: FrfModel, x: np.ndarray, observations: Observations, lines: np.ndarray
) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "parameter observation line"]]:
    shape = len(observations), len(lines)
    value, slopes = np.zeros(shape, dtype=complex), np.zeros((len(x), *shape), dtype=complex)
    for some, found, changes in evaluated(model, x, observations, lines, slopes=True):
        value[some], slopes[:, some] = found, changes
    return value, slopes
