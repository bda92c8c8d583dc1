"""What nobody set up exactly, as parameters with priors: angles of each posture, places, directions, gains.

Each nuisance parameter τ has the standard deviation that `[tolerance]` gives it. To first order it changes
ln H by s τ, with s from the robot's own FRFs (`Sensitivities`). Together with the robot's parameters x, whose
derivatives are J, it is found by Gauss and Newton's method,

    min |r + J δx + S τ|²/σ² · κ/s² + |x + δx|²/σₓ² + |τ|²/σ_τ²,

κ the part of the lines that count, as neighbouring ones share their errors, and s² ≥ 1 the mean square of
what is left: where something is missing from the model that is large, and nothing is moved to make up for
it. At first κ and s² are those of what is left before; beside what was fitted closely, which may be all
there is, those of what is left with everything free, for what is moved then is no noise either. A parameter
that the data do not ask for is not fitted: its score has to promise `set_up_step.WORTH` nats (Rao's test).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.campaign import Tolerance
from flexmodal.identification.model import FrfModel
from flexmodal.identification.observations import Observations
from flexmodal.identification.sensitivities import Nuisance, Sensitivities, moved, nuisances_of
from flexmodal.identification.set_up_step import Seen, angles_of, step

FAR = 3.0
"""Standard deviations of its tolerance from which a parameter is told as far outside."""
ROUNDS = 4
"""Of looking at the scores and moving, at most."""
SETTLED, SMALL = 0.1, 0.5
"""Standard deviations of a tolerance: steps below are the last, and take the derivatives along."""
MUCH = 2.0
"""Times the noise left by a model from which on angles far outside their tolerance are none. Chosen, not
tuned: where an angle and a gain alone are off 0.6 is left."""


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
            sensors, and angles of postures are moved so far only where that leaves little: where it leaves
            much they would make up for what is missing from the model, and stay within what is plausible.
    """
    seen = Seen(beside.model, lines, prior, beside.factor, beside.begun is not None)
    begun = _begun(beside, observations)
    kept, plausible = ~np.zeros(len(begun.values), dtype=bool), False
    found = _moved_by(seen, begun, kept, plausible=plausible)
    while not far:
        odd = np.abs(found.values) > FAR * found.deviations
        if not plausible and (odd & found.angles).any() and found.over_noise > MUCH:
            at, plausible = begun.keeping(kept), True
        elif (odd & ~found.angles).any():
            kept &= found.angles | ~odd
            at = found.keeping(kept)
        else:
            break
        found = _moved_by(seen, at, kept, plausible=plausible)
    told = [
        Found(one, float(value), float(error))
        for one, value, error in zip(found.nuisances, found.values, found.errors, strict=True)
        if value
    ]
    told.sort(key=lambda one: -abs(one.value) / one.nuisance.deviation)
    return SetUp(found.observations, tuple(told), found.left, found.x)


@dataclass(frozen=True, eq=False)
class _Moved:
    """Where the rounds have come to."""

    said: Observations
    """As they are said to have been set up."""
    nuisances: tuple[Nuisance, ...]
    values: Float[np.ndarray, " nuisance"]
    x: Float[np.ndarray, " parameter"]
    errors: Float[np.ndarray, " nuisance"]
    """With all of them free."""
    over_noise: float = np.inf
    """What was left before the last step, over the noise."""

    @cached_property
    def observations(self) -> Observations:
        """With everything moved."""
        return moved(self.said, [(one, v) for one, v in zip(self.nuisances, self.values, strict=True) if v])

    @cached_property
    def deviations(self) -> Float[np.ndarray, " nuisance"]:
        """The tolerance of each."""
        return np.array([one.deviation for one in self.nuisances])

    @cached_property
    def angles(self) -> Bool[np.ndarray, " nuisance"]:
        """Which are angles of postures."""
        return angles_of(self.nuisances)

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

    def keeping(self, kept: Bool[np.ndarray, " nuisance"]) -> _Moved:
        """With some of them as they are said to be."""
        return replace(self, values=np.where(kept, self.values, 0.0))


def _begun(beside: Beside, observations: Observations) -> _Moved:
    """Where the rounds set out."""
    keys = tuple(nuisances_of(observations))
    known = dict(beside.begun.settings) if beside.begun is not None else {}
    values = np.array([known.get(one, 0.0) for one in keys])
    return _Moved(observations, keys, values, beside.x, np.zeros(len(keys)))


def _moved_by(
    seen: Seen,
    at: _Moved,
    kept: Bool[np.ndarray, " nuisance"],
    *,
    plausible: bool,
) -> _Moved:
    """Rounds of scores and steps, with some of the parameters left as they are."""
    slopes: Sensitivities | None = None
    for _ in range(ROUNDS):
        slopes = slopes or Sensitivities.of(seen.model, at.x, at.observations, seen.lines)
        made = step(seen, at.x, at.values, at.observations, slopes, kept, plausible=plausible)
        at = replace(
            at, values=at.values + made.change, x=made.x, errors=made.errors, over_noise=made.over_noise
        )
        size = np.max(np.abs(made.change) / at.deviations, initial=0.0)
        if size <= SETTLED:
            break
        slopes = slopes if size <= SMALL else None
    return at
