"""How a test was most likely set up, seen anew beside an effect.

What was not set up exactly is first looked at beside the re-tuned robot. Where something is missing from it,
that says little, and next to nothing is moved. An effect that takes a good part of the disagreement leaves
what was due to angles, places and gains; beside it these are found, and with them moved the models are
compared. What is moved is what the best of them asks for: the others are fitted again and may do better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.search.close_fit import fitted_closely, tried_closely
from flexmodal.diagnosis.search.unstructured import unstructured_mode
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import NOTHING_HIDDEN
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.errors import SingularResponse
from flexmodal.identification import Observations, predict
from flexmodal.identification.model import Group
from flexmodal.identification.setting_up import Beside, SetUp
from flexmodal.identification.tolerance import set_up_beside
from flexmodal.structure import ParameterSpace

TRIED = 2
"""Models beside which it is looked at how the test was set up, the nearest first."""
GAINS = 0.9
"""Part of the distance from the averages that a model may have left for another set-up to be worth it."""

NO_MODEL = (np.linalg.LinAlgError, SingularResponse)
"""What says that there is no model at some coordinates."""


@dataclass(frozen=True, eq=False)
class Elsewhere:
    """A hypothesis where points and postures may be others than those of its diagnosis (`FrfModel`)."""

    hypothesis: Hypothesis

    @property
    def space(self) -> ParameterSpace:
        """Its parameters."""
        return self.hypothesis.space

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `identification.FrfModel` for the arguments."""
        own = self.hypothesis
        there = Hypothesis(Context.of(own.context.robot, observations), own.base, own.placed)
        return there.groups(x, observations, slopes=slopes)


def is_set_up(setup: Setup, model: FittedFrfs) -> bool:
    """Whether everything is exact, or nothing more can be seen beside a model that leaves mere noise.

    Args:
        setup: what the diagnosis works with.
        model: fitted to it.
    """
    return setup.said is None or over_seen(setup, model) <= NOTHING_HIDDEN


def set_up_closely(setup: Setup) -> Setup:
    """A test as it was most likely set up by the robot alone, re-tuned as closely as it will be.

    Args:
        setup: as it came out by a coarse fit.
    """
    if setup.said is None:
        return setup
    bare = Hypothesis(setup.context, setup.base)
    found = seen_anew(setup, [fitted_closely(setup, bare, np.zeros(len(setup.base)))])
    return setup if found is None else found[0]


def seen_anew(setup: Setup, models: Sequence[FittedFrfs]) -> tuple[Setup, list[FittedFrfs]] | None:
    """The test as it was most likely set up by the best of some models, and these fitted to it.

    Args:
        setup: what the diagnosis works with.
        models: the first without anything new.

    Returns:
        None where everything is exact, one of them leaves no more than noise, or none comes nearer than the
        nearest was.
    """
    if any(is_set_up(setup, one) for one in models):
        return None
    able = nearest(setup, models)
    beside = parallel_map(partial(_beside, setup), able)
    tried = [(one, again) for one, found in zip(able, beside, strict=True) for again in found]
    scores = [over_seen(other, fitted) for _, (other, fitted) in tried]
    if min(scores, default=math.inf) > GAINS * over_seen(setup, able[0]):
        return None
    was, (best, nearer) = tried[int(np.argmin(scores))]

    plain = [one for one in models if one.key[0] != UNSTRUCTURED]
    rest = parallel_map(partial(_moved_to, best), [one for one in plain if one is not was])
    first, *others = ([nearer] if one is was else next(rest) for one in plain)
    if not first:
        return None
    modes = [unstructured_mode(best, first[0])] if len(plain) < len(models) else []
    return best, [*first, *(found for each in others for found in each), *modes]


def nearest(setup: Setup, models: Sequence[FittedFrfs], number: int = TRIED) -> list[FittedFrfs]:
    """A few models with effects or without, the nearest first.

    Args:
        setup: what the diagnosis works with.
        models: fitted to it.
        number: of them; by default of those beside which it is looked at how the test was set up.
    """
    able = [one for one in models if one.key[0] != UNSTRUCTURED]
    return sorted(able, key=lambda one: over_seen(setup, one))[:number]


def clearly_nearer(setup: Setup, models: Sequence[FittedFrfs], others: Sequence[FittedFrfs]) -> bool:
    """Whether the nearest of some models is nearer than that of others by what makes another set-up worth it.

    Args:
        setup: what the diagnosis works with.
        models: fitted to it.
        others: fitted to it too.
    """
    if setup.said is None:
        return False
    near, far = (over_seen(setup, nearest(setup, every, 1)[0]) for every in (models, others))
    return near < GAINS * far


def with_everything(setup: Setup, models: Sequence[FittedFrfs]) -> tuple[Setup, list[FittedFrfs]]:
    """The test as the last of some models sets it up, by what was held out too; the models as they were.

    Args:
        setup: what the diagnosis works with.
        models: fitted to what is not held out.
    """
    if setup.said is None:
        return setup, list(models)
    held, last = np.zeros_like(setup.held), models[-1]
    found = _set_up_by(replace(setup, held=held), last)
    if found is None:
        return setup, list(models)
    now, _ = found
    there = replace(now, held=setup.held, fitted=now.observations.keeping(~setup.held))
    return there, [replace(one, hypothesis=_placed(there, one)) for one in models]


def over_seen(setup: Setup, model: FittedFrfs) -> float:
    """Distance from the averages of what is not held out over that of their noise alone.

    Args:
        setup: what the diagnosis works with.
        model: fitted to it.
    """
    assert setup.said is not None
    plain = replace(setup, observations=replace(setup.observations, variance=setup.said.variance))
    return over_noise(plain, model, ~setup.held)


def _moved_to(setup: Setup, model: FittedFrfs) -> list[FittedFrfs]:
    """A model fitted to the test as it was set up by another one; none where there is no such model."""
    return tried_closely(setup, _placed(setup, model), model.x)


def _placed(setup: Setup, model: FittedFrfs) -> Hypothesis:
    return Hypothesis(setup.context, setup.base, model.hypothesis.placed)


def _beside(setup: Setup, model: FittedFrfs) -> list[tuple[Setup, FittedFrfs]]:
    """The test as it was most likely set up by a model, and this fitted to it.

    What is integrated in time takes long to fit, and is not where that promises nothing.
    """
    found = _set_up_by(setup, model)
    if found is None:
        return []
    now, x = found
    hypothesis, beyond, near = _placed(now, model), _beyond(setup, model), {}
    for number, at in enumerate((x, model.x)):
        with suppress(*NO_MODEL):
            told = replace(model, predicted=beyond * predict(hypothesis, at, now.observations))
            near[number] = over_seen(now, told)
    if not near or (has_law(hypothesis) and min(near.values()) > GAINS * over_seen(setup, model)):
        return []
    begun = (x, model.x)[min(near, key=lambda number: near[number])]
    return [(now, one) for one in tried_closely(now, hypothesis, begun)]


def _set_up_by(setup: Setup, model: FittedFrfs) -> tuple[Setup, Float[np.ndarray, " parameter"]] | None:
    """The test as it was most likely set up by a model, and how far the model's coordinates followed.

    None where they come to where there is no model, as beside a loop that rings up.
    """
    assert setup.said is not None
    assert setup.wide is not None
    begun = SetUp(setup.said, setup.moved)
    beside = Beside(Elsewhere(model.hypothesis), model.x, _beyond(setup, model), begun)
    try:
        found = set_up_beside(
            beside, setup.said, setup.wide, setup.context.robot, setup.held, far=False, in_sample=True
        )
    except NO_MODEL:
        return None
    seen = found.observations
    now = replace(
        setup,
        context=Context.of(setup.context.robot, seen), observations=seen,
        fitted=seen.keeping(~setup.held), moved=found.found,
    )  # fmt: skip
    return now, model.x if found.x is None else found.x


def _beyond(setup: Setup, model: FittedFrfs) -> Complex[np.ndarray, "observation line"]:
    """What a model predicts over what it does without its torques that are not linear."""
    linear = predict(model.hypothesis, model.x, setup.observations)
    return np.where(linear == 0, 1.0, model.predicted / np.where(linear == 0, 1.0, linear))
