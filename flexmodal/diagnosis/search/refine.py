"""A hypothesis fitted again with its non-linear torques integrated in time.

A hammer response that dies away has no single amplitude, so that a describing function leaves some of what
friction or a hardening spring does. This is Gauss and Newton's method on what an integration gives, with
coarse steps of time at first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.search.coarse import ROUGH, ROUGHLY, with_few_hinges
from flexmodal.diagnosis.search.lines import CLOSE, COARSE, some_lines
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.diagnosis.time_domain.secant import fitted_by_secants
from flexmodal.identification import FrfFit, Observations, predict
from flexmodal.identification.frf_fit import FrfMisfit, Weighting

SEARCH = 0.1
"""Model error at which starts are compared."""
FLOORS = (0.05, 0.01)
"""Model errors of the two rounds."""
STEPS = 30
"""Most in each round."""
SETTLED = 1e-3
"""A step that changes the cost relatively by less is the last."""


class Rounds(Enum):
    """Of a fit."""

    BOTH = "both"
    ROUGH = "rough"
    """The first alone, with long steps of time at the larger model error. Links have few hinges there: one
    that was tried beside a friction left 18 noise floors where the friction alone left 12."""
    LAST = "last"
    """The other alone."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A fit of integrated torques."""

    model: TimeDomainModel
    fitted: FrfFit
    predicted: Complex[np.ndarray, "observation line"]
    """Of the observations it was fitted to [m/N]."""

    @property
    def x(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates, in the space of the hypothesis."""
        return self.fitted.x

    @property
    def cost(self) -> float:
        """On the lines of the fit, at its model error."""
        return self.fitted.cost


def refined(
    hypothesis: Hypothesis,
    start: Float[np.ndarray, " parameter"],
    observations: Observations,
    *,
    steps: int = STEPS,
    rounds: Rounds = Rounds.BOTH,
) -> Refined:
    """Fit once more, the torques of effects with a `law` integrated in time.

    Args:
        hypothesis: with at least one such effect.
        start: where the fit sets out.
        observations: what is fitted.
        steps: most in each round.
        rounds: which; after the rough one alone the derivatives at its end are rough too.

    Raises:
        InvalidRequest: no effect of the hypothesis has a law.
    """
    lines = some_lines(observations, CLOSE)
    # Long steps are rough anyway, and so are the links.
    coarse, model = TimeDomainModel(with_few_hinges(hypothesis), ROUGH), TimeDomainModel(hypothesis)
    x, taken = start, 0
    if rounds is not Rounds.LAST:
        first = FrfMisfit(coarse, observations, Weighting(FLOORS[0], lines))
        near = fitted_by_secants(first, _start(coarse, start, observations), steps=steps, settled=ROUGHLY)
        x, taken = near.x, near.steps
    if rounds is Rounds.ROUGH:
        last = FrfMisfit(replace(model, rough=True), observations, Weighting(FLOORS[1], lines))
        made = FrfFit(x, last.cost(x), last, converged=False, steps=taken)
    else:
        last = FrfMisfit(model, observations, Weighting(FLOORS[1], lines))
        made = fitted_by_secants(last, x, steps=steps, settled=SETTLED)
        made = replace(made, steps=taken + made.steps)
    return Refined(model, made, predict(model, made.x, observations))


def _start(
    model: TimeDomainModel, x: Float[np.ndarray, " parameter"], observations: Observations
) -> Float[np.ndarray, " parameter"]:
    """Where the describing functions ended, or that with its laws started afresh, if that is nearer."""
    hypothesis, space = model.hypothesis, model.space
    weighing = Weighting(SEARCH, some_lines(observations, COARSE))
    tried = [x]
    for placed in hypothesis.placed:
        if placed.effect.law is None:
            continue
        for given in placed.effect.starts(hypothesis.context, placed.where):
            other = x.copy()
            for name in (p.name for p in placed.effect.parameters(hypothesis.context, placed.where)):
                k = space.index[f"{placed.label}.{name}"]
                other[k] = space.parameters[k].coordinate(given[name]) if name in given else 0.0
            tried.append(np.clip(other, *space.bounds))
    misfit = FrfMisfit(model, observations, weighing)
    costs = [misfit.cost(one) for one in tried]
    return tried[int(np.argmin(costs))]
