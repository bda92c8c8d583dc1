"""A hypothesis fitted closely and seen from all postures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.search.lines import CLOSE, some_lines
from flexmodal.diagnosis.search.refine import STEPS as REFINED
from flexmodal.diagnosis.search.refine import Rounds, refined
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs, fitted_model
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.errors import SingularResponse
from flexmodal.identification import Observations, fit, predict
from flexmodal.identification.frf_fit import FINE

FAR, NEAR, LAST = (0.2, 0.05, 0.01), (0.05, 0.01), (0.01,)
"""Model errors of a fit that starts from afar, from nearby, and from where one has come to."""
STEPS = 25
"""Most at each of them."""
AT_LAST = 0.02
"""Distance from the minimum at which a fit to everything ends [standard errors]."""
IDLE = 10.0
"""What a part of an effect has to take off the cost, twice −ln of the posterior, not to count as nothing."""
FAR_OFF, ROUGHLY = 4.0, 1e-4
"""Distance over noise from which a trial is not brought to its end, and what a step still has to gain then:
something else is missing there, and what is found is fitted again beside it. Of 32 fits beyond that in five
campaigns with several effects that were looked at, none came nearer by more than 0.3 % from the card."""


def fitted_closely(
    setup: Setup,
    hypothesis: Hypothesis,
    start: Float[np.ndarray, " parameter"],
    *,
    floors: tuple[float, ...] = FAR,
    steps: int = STEPS,
    settled: float = FINE,
    near: float = 0.0,
    hold: Mapping[str, float] | None = None,
    fitted_to: Observations | None = None,
) -> FittedFrfs:
    """Fit a hypothesis closely; torques that are not linear are integrated in time.

    Args:
        setup: what the diagnosis works with.
        hypothesis: what is fitted.
        start: where the fit sets out.
        floors: model errors, lowered one after the other.
        steps: most at each model error.
        settled: a step that changes the cost relatively by less is the last; where torques are integrated
            `ROUGHLY` leaves the last round out.
        near: if above 0, a linear model's fit goes on until Newton's step is shorter, in standard errors.
        hold: coordinates of a linear model that stay where they are put, by name.
        fitted_to: by default the observations that are not held out.
    """
    few, every = setup.fitted if fitted_to is None else fitted_to, setup.observations
    if has_law(hypothesis):
        rounds = Rounds.LAST if floors == LAST else Rounds.ROUGH if settled == ROUGHLY else Rounds.BOTH
        close = refined(hypothesis, start, few, steps=min(steps, REFINED), rounds=rounds)
        return fitted_model(hypothesis, close.fitted, every, predict(close.model, close.x, every))
    lines = some_lines(few, CLOSE)
    fitted = fit(
        hypothesis, few, start, floors=floors, lines=lines, steps=steps, settled=settled, near=near, hold=hold
    )
    return fitted_model(hypothesis, fitted, every)


def tried_closely(
    setup: Setup,
    hypothesis: Hypothesis,
    start: Float[np.ndarray, " parameter"],
    *,
    near: bool = False,
    steps: int = STEPS,
) -> list[FittedFrfs]:
    """The same of a trial, which goes to its end only where that is near the noise.

    None where the fit comes to where there is no model, as beside torques that push.

    Args:
        setup: what the diagnosis works with.
        hypothesis: what is tried.
        start: where the fit sets out.
        near: whether that is near its end.
        steps: most at each model error.
    """
    try:
        floors = NEAR if near else FAR
        made = fitted_closely(setup, hypothesis, start, floors=floors, steps=steps, settled=ROUGHLY)
        if over_noise(setup, made) <= FAR_OFF:
            made = fitted_closely(setup, hypothesis, made.x, floors=LAST, steps=steps)
        return [made]
    except (np.linalg.LinAlgError, SingularResponse):
        return []


def fitted_to_everything(setup: Setup, model: FittedFrfs) -> FittedFrfs:
    """A model fitted to what was held out too, close to the minimum along what hardly matters as well.

    From where it is and from afar, the nearer of the two: to all postures the least may be another one. What
    is integrated in time takes long, and is fitted from where it is only where from afar it comes to what is
    worse than it was.

    Args:
        setup: what the diagnosis works with.
        model: fitted to what is not held out.
    """

    def again(floors: tuple[float, ...]) -> FittedFrfs:
        return fitted_closely(
            setup, model.hypothesis, model.x, floors=floors, near=AT_LAST, fitted_to=setup.observations
        )

    if has_law(model.hypothesis):
        far = again(FAR)
        return far if _posterior(far) <= _posterior(model) else min(far, again(LAST), key=_posterior)
    tried = parallel_map(again, (FAR, LAST))
    return _without_idle_parts(setup, min(tried, key=lambda one: one.fitted.cost))


def _posterior(model: FittedFrfs) -> float:
    """Twice −ln of the posterior on all postures, up to a constant."""
    return float(model.costs.sum()) + model.prior


def _without_idle_parts(setup: Setup, model: FittedFrfs) -> FittedFrfs:
    """With those parts of its effects at nothing that take hardly anything: all of them, or one by one."""
    parts = [
        dict.fromkeys((f"{placed.label}.{name}" for name in part), 0.0)
        for placed in model.hypothesis.placed
        for part in placed.effect.parts
    ]
    limit = model.fitted.cost + IDLE

    def with_held(found: FittedFrfs, hold: Mapping[str, float]) -> FittedFrfs:
        made = fitted_closely(
            setup, found.hypothesis, found.x,
            floors=LAST, near=AT_LAST, hold=hold, fitted_to=setup.observations,
        )  # fmt: skip
        return made if made.fitted.cost < limit else found

    held: dict[str, float] = {name: 0.0 for part in parts for name in part}
    found = with_held(model, held) if parts else model
    if found is not model or len(parts) < 2:
        return found
    held = {}
    for part in parts:
        further = with_held(found, {**held, **part})
        held, found = ({**held, **part}, further) if further is not found else (held, found)
    return found
