"""How sure an explanation is that was added: its probability among all that was considered, and what was not.

The evidence that decides counts every line for as much as it is independent of its neighbours. That is
right for noise. An explanation that is wrong in its law errs over whole FRFs, though, and its errors go on
from line to line and are of a size that nobody knows. So for what is told every FRF counts as `PIECES`
independent pieces, and the size of the errors is integrated out with Jeffreys' prior:

    ln p_k = −(ν/2) ln C_k − ½ n_k ln(1 + ν) − ½ xᵀPx / t + const.,   ν = `PIECES` × FRFs,

C_k the sum of squares, n_k how many parameters the data know better than the prior, the last term how far
these are from what was believed. Where even the explanation that stays nearest to that is farther off than
the card says that it may be, the card is trusted too much, and t is by how much: the least xᵀPx of all over
the number of parameters, at least 1.

Beside what was compared stands something that was not, as simple as what is named. Where a look that
assumes no law points elsewhere or nowhere it is as good as what counts as explained, and weighs `ALONE`:
what the named one leaves beyond that counts against it. Where the named one counts as explained itself, or
the look points to the same place so that what is left is due to the law and not to the place, something
else is no better than what is named, and weighs `ALONE`, or `AGREES` where the curve has its class too.
Where the re-tuned robot is at the noise already no error of a law can be larger than that, and lines count
as in the evidence. Where with its function free one place explains everything and no other does, and that
function tells the effect that is named, only what sits there is compared: how narrow its law is says nothing
for what sits elsewhere, or for nothing at all.

Both weights, and the pieces, were tuned on campaigns of the virtual rig that judge nothing
(`benchmarks/calibration.py`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.diagnosis.disagreement.gaps import left, over_noise
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED, at_the_noise
from flexmodal.diagnosis.setup import Setup

PIECES = 3.0
"""Independent pieces of an FRF, as far as errors of a law go: a resonance or two, in size and in phase."""
AGREES, ALONE = 0.05, 0.2
"""Odds of something that was not considered against what is named, both equally good."""
TELLS = 0.2
"""Misfit below which a look fits what is noise: with as many unknowns as FRFs it says nothing [noise]."""


@runtime_checkable
class Looked(Protocol):
    """Data of FRFs with a look that assumes no law."""

    @property
    def setup(self) -> Setup:
        """What a diagnosis works with."""

    @property
    def root(self) -> FittedFrfs:
        """The robot re-tuned, nothing added."""

    def look_for(self, before: FittedFrfs) -> Findings:
        """What was found without a law, beside a model if that was looked at."""


def confidences(data: Looked, comparison: Comparison[FittedFrfs], chosen: int) -> Float[np.ndarray, " model"]:
    """Probability of each model, at most that of the comparison; what they lack of 1 is something else's.

    Args:
        data: on which they were compared.
        comparison: of models.
        chosen: number of the one that is named.
    """
    observations, look = data.setup.observations, data.look_for(comparison.models[0])
    models = comparison.models
    key = models[chosen].key
    costs, sizes, priors = figures_of(models)
    there = look.left > TELLS and any(one.has(*key) for one in look.found)
    agrees = there and key in look.met([key])
    variance, floor = observations.variance[observations.used], models[0].fitted.weighing.floor
    enough = there or explains(data, models[chosen])
    noise = math.inf if enough else FLOOR_REACHED**2 * float(np.sum(variance / (variance + floor**2)))
    odds = AGREES if agrees else ALONE
    if needs_nothing(data, models[0]):
        return np.asarray(comparison.probability / (1 + odds))
    possible = _possible(look, [one.key for one in models], chosen)
    costs = np.where(possible, costs, np.inf)
    found = probabilities(costs, sizes, priors, chosen, PIECES * len(models[0].costs), noise, odds)
    first = int(comparison.order[0])
    told = plausible(data, comparison)
    if chosen in told and first in told and chosen != first:
        return found
    among = comparison.probability / max(float(comparison.probability[possible].sum()), 1e-300)
    return np.minimum(found, np.where(np.arange(len(found)) == chosen, among, 1.0))


def _possible(look: Findings, keys: Sequence[tuple[str, str]], chosen: int) -> Bool[np.ndarray, " model"]:
    """Which models are not ruled out by the only place that explains everything and tells what is there."""
    lone = look.lone
    if lone is None or (lone.tells, lone.where) != keys[chosen]:
        return np.full(len(keys), True)
    return np.array([lone.has(*key) for key in keys])


def plausible(data: Looked, comparison: Comparison[FittedFrfs]) -> dict[int, float]:
    """Of models with effects that explain what there is, by number, ln p of the formula above.

    None where the re-tuned robot does so too: no law errs there by more than noise, and evidence decides.

    Args:
        data: on which they were compared.
        comparison: of models, the first without anything new.
    """
    models = comparison.models
    if needs_nothing(data, models[0]):
        return {}
    pieces, times = PIECES * len(models[0].costs), _over_trusted(models)
    return {
        k: float(_ln(one.costs.sum(), one.strong, one.prior / times, pieces))
        for k, one in enumerate(models)
        if one.hypothesis.placed and one.key[0] != UNSTRUCTURED and _at_the_noise(data, one) is Answer.YES
    }


def needs_nothing(data: Looked, model: FittedFrfs) -> bool:
    """Whether a model is the re-tuned robot and at the noise.

    Args:
        data: on which it is judged.
        model: any.
    """
    return not model.hypothesis.placed and _at_the_noise(data, model) is Answer.YES


def explains(data: Looked, model: FittedFrfs) -> bool:
    """Whether a model reaches the noise, or comes as near as a strong effect has to.

    Args:
        data: on which it is judged.
        model: with effects.
    """
    return _at_the_noise(data, model) > Answer.NO


def _at_the_noise(data: Looked, model: FittedFrfs) -> Answer:
    return at_the_noise(over_noise(data.setup, model), left(data.setup, data.root, model))


def probabilities(
    costs: Float[np.ndarray, " model"],
    sizes: Float[np.ndarray, " model"],
    priors: Float[np.ndarray, " model"],
    chosen: int,
    pieces: float,
    noise: float,
    odds: float,
) -> Float[np.ndarray, " model"]:
    """Of the formula above.

    Args:
        costs: C, sums of squares; infinite of what is ruled out.
        sizes: n, numbers of parameters.
        priors: xᵀPx / t.
        chosen: number of the model that is named.
        pieces: ν.
        noise: sum of squares that something else would leave; what the chosen one leaves, if that is less.
        odds: of something else against the chosen one, were both equally good.
    """
    score = _ln(costs, sizes, priors, pieces)
    ideal = _ln(min(float(costs[chosen]), noise), sizes[chosen], priors[chosen], pieces)
    total = np.logaddexp.reduce(np.append(score, ideal + np.log(odds)))
    return np.asarray(np.exp(score - total))


def figures_of(models: Sequence[FittedFrfs]) -> Float[np.ndarray, "3 model"]:
    """Of each model C, n and xᵀPx / t of the formula above.

    Args:
        models: that are compared.
    """
    figures = [(float(one.costs.sum()), float(one.strong), float(one.prior)) for one in models]
    costs, sizes, priors = np.array(figures).T
    return np.array([costs, sizes, priors / _over_trusted(models)])


def _over_trusted(models: Sequence[FittedFrfs]) -> float:
    """By how much the card is trusted too much, t: 1 where an explanation is as near to it as it may be."""
    return max(1.0, min(float(one.prior) for one in models) / max(models[0].parameters, 1))


def _ln(costs: Any, sizes: Any, priors: Any, pieces: float) -> Any:
    """The formula, of numbers or arrays."""
    return -pieces / 2 * np.log(np.maximum(costs, 1e-300)) - (sizes * np.log1p(pieces) + priors) / 2
