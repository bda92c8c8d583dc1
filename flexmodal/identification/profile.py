"""Profile intervals: how far one parameter can go while all others make the best of it.

Along a profile the cost rises by Δ. Where it is a parabola, Δ = δ²/(A⁻¹)_kk; the interval of clustered
errors, |δ| ≤ t √V_kk, is then {Δ ≤ t² V_kk/(A⁻¹)_kk}, and that is what is looked for where it is none.
Laplace's and the profile's interval agree for a parameter that the data tell well; where they differ, the
profile's is right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.evidence import Fitted
from flexmodal.identification.outcome import Identification

CLOSE = 0.02
"""Relative error of the rise at which an end is found."""
MOST = 12
"""Refits for each end."""


@dataclass(frozen=True)
class Profile:
    """One parameter's."""

    name: str
    interval: tuple[float, float]
    """In the unit of the parameter; an end at a bound is that bound."""
    laplace: tuple[float, float]
    """Of the covariance, for comparison."""
    refits: int


def profile(outcome: Identification, name: str, *, level: float = 0.95) -> Profile:
    """Find the profile interval of a parameter.

    Args:
        outcome: of an identification.
        name: of the parameter.
        level: of confidence.

    Raises:
        InvalidRequest: no such parameter, or a level outside 0 to 1.
    """
    space = outcome.problem.space
    faults = []
    if name not in space.index:
        faults.append(Fault("call", "name", repr(name), ", ".join(space.names)))
    if not 0 < level < 1:
        faults.append(Fault("call", "level", f"{level:g}", "between 0 and 1"))
    if faults:
        raise InvalidRequest(faults)
    from scipy.special import stdtrit

    k, sure = space.index[name], outcome.uncertainty
    inverse = np.linalg.pinv(outcome.fitted.normal.curvature + np.diag(space.precision), hermitian=True)
    factor = float(stdtrit(min(float(sure.freedom[k]), 1e9), (1 + level) / 2))
    rise = factor**2 * float(sure.covariance[k, k]) / float(inverse[k, k])
    reach = factor * float(sure.deviation[k])
    ends, refits = [], 0
    for side in (-1.0, 1.0):
        end, used = _end(outcome, name, side * reach, rise, inverse[:, k] / inverse[k, k])
        ends.append(end)
        refits += used
    parameter = space.parameters[k]
    x = float(outcome.at[k])
    return Profile(
        name,
        (parameter.value(ends[0]), parameter.value(ends[1])),
        (parameter.value(x - reach), parameter.value(x + reach)),
        refits,
    )


def _end(
    outcome: Identification, name: str, reach: float, rise: float, ridge: np.ndarray
) -> tuple[float, int]:
    """Coordinate at which the cost has risen by `rise`; and how many refits that took."""
    evidence, base = outcome.problem.evidence, outcome.fitted
    k = evidence.space.index[name]
    low, high = (float(bound[k]) for bound in evidence.space.bounds)
    x = float(base.x[k])
    step = reach
    for refit in range(1, MOST + 1):
        at = min(max(x + step, low), high)
        found: Fitted = evidence.fit(base.x + ridge * (at - x), warm=True, hold={name: at})
        risen = found.cost - base.cost
        at_bound = at in (low, high)
        if abs(risen / rise - 1) < CLOSE or (at_bound and risen < rise):
            return at, refit
        step = (at - x) * float(
            np.clip(np.sqrt(rise / max(risen, 1e-12)), 0.3, 3.0)
        )  # a parabola's next guess
    return x + step, MOST
