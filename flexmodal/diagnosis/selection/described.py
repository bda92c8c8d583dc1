"""A step of the selection described: an effect's parameters with their errors, and how sure it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Compared, Gaps, Step
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.standard_errors import with_errors


def step_of(data: Data[M], root: M, comparison: Comparison[M], chosen: int) -> Step:
    """What a step added, how large it is and how surely, and what it was compared with.

    Args:
        data: that models were fitted to.
        root: the robot re-tuned.
        comparison: of what was there before, first, and of what might be added.
        chosen: number of what was added.
    """
    before, model = comparison.models[0], comparison.models[chosen]
    parameters, units, errors = effect_parameters(
        model.hypothesis, model.key, model.x, data.covariance(model)
    )
    sure = data.confidences(comparison, chosen).tolist()
    others = {
        k: replace(in_figures(data, comparison, k), confidence=sure[k])
        for k in comparison.order
        if k != chosen
    }
    ties = [k for k in comparison.tied if k != chosen]
    shares = [data.share(root, one) for one in (before, model)]
    return Step(
        effect=model.key[0],
        where=model.key[1],
        parameters=parameters,
        units=units,
        uncertainty=errors,
        confidence=sure[chosen],
        gaps=data.gaps(before, model),
        alternatives=tuple(others.values()),
        ties=tuple((others[k].effect, others[k].where) for k in ties),
        share=None if shares[0] is None or shares[1] is None else shares[1] - shares[0],
    )


def anew(data: Data[M], root: M, model: M, describe: Callable[[Comparison[M], int], Step]) -> list[Step]:
    """The steps to a model, its effects one after the other in the order in which it has them.

    Args:
        data: that models were fitted to.
        root: the robot re-tuned.
        model: with effects.
        describe: what a step added, of a comparison and the number of what was added.
    """
    return [describe(data.compare(list(pair)), 1) for pair in pairwise(built_up(data, root, model))]


def as_sure(steps: Sequence[Step], sure: Mapping[tuple[str, str], float]) -> list[Step]:
    """Steps of which some are as sure as was asked apart, whatever they were tied with.

    Args:
        steps: as they were added.
        sure: confidence of some, by name and place.
    """
    told = [(one, sure.get((one.effect, one.where))) for one in steps]
    return [one if how is None else untied(one, how) for one, how in told]


def built_up(data: Data[M], root: M, model: M) -> list[M]:
    """The models that come to one by its effects one after the other, in the order in which it has them.

    Args:
        data: that they are fitted to.
        root: the robot re-tuned, the first of them.
        model: the last of them.
    """
    chain = [model]
    while len(chain[0].hypothesis.keys) > 1:
        chain.insert(0, data.without(chain[0], chain[0].hypothesis.keys[-1]))
    return [root, *chain]


def shared_anew(data: Data[M], root: M, model: M, steps: Sequence[Step]) -> list[Step]:
    """Steps with the gaps and the shares that they have without those that went.

    Args:
        data: that models are fitted to.
        root: the robot re-tuned.
        model: with the effects that stay.
        steps: the same effects, described while others were there.
    """
    chain = built_up(data, root, model)
    shares = [data.share(root, one) for one in chain]
    found: dict[tuple[str, str], tuple[Gaps, float | None]] = {}
    for (before, after), (less, more) in zip(pairwise(chain), pairwise(shares), strict=True):
        share = None if less is None or more is None else more - less
        found[after.hypothesis.keys[-1]] = data.gaps(before, after), share
    own = [found[(step.effect, step.where)] for step in steps]
    return [replace(step, gaps=gaps, share=share) for step, (gaps, share) in zip(steps, own, strict=True)]


def beside_others(step: Step, sure: float, named: Sequence[tuple[str, str]]) -> Step:
    """One of several effects: as sure as it is beside the others, where nothing but they was tied with it.

    That a mode with no structure was tied with it, as long as they were missing, does not count.

    Args:
        step: as it was added, before others were known.
        sure: its confidence beside all others.
        named: all effects.
    """
    ties = tuple(tie for tie in step.ties if tie not in named and tie[0] != UNSTRUCTURED)
    return replace(step, ties=ties) if ties else untied(step, sure)


def untied(step: Step, sure: float) -> Step:
    """One of several effects, as sure as it is beside the others, where none is tied with it there.

    Args:
        step: as it was added, before others were known.
        sure: its confidence beside all others.
    """
    rest = (1 - sure) / max(1 - step.confidence, 1e-12)
    others = tuple(replace(one, confidence=min(one.confidence * rest, 1 - sure)) for one in step.alternatives)
    return replace(step, ties=(), confidence=sure, alternatives=others)


def as_found_last(step: Step, conclusion: Conclusion[M]) -> Step:
    """The same with its parameters where the last model has them: when it was added others were missing.

    Args:
        step: as it was added.
        conclusion: with the last model, fitted to everything.
    """
    last, key = conclusion.after, (step.effect, step.where)
    if key not in last.hypothesis.keys:
        return step
    parameters, units, errors = effect_parameters(last.hypothesis, key, last.x, conclusion.covariance)
    return replace(step, parameters=parameters, units=units, uncertainty=errors)


def effect_parameters(
    hypothesis: Hypothesis,
    key: tuple[str, str],
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
) -> tuple[dict[str, float], dict[str, str], dict[str, float]]:
    """Physical parameters of an effect, their units and standard errors, by finite differences.

    Args:
        hypothesis: with the effect.
        key: name and place of the effect.
        x: coordinates.
        covariance: of these.
    """
    space, context = hypothesis.space, hypothesis.context
    placed = next(one for one in hypothesis.placed if one.key == key)
    own = {p.name: p.unit for p in placed.effect.parameters(context, placed.where)}

    def physical(at: np.ndarray) -> Mapping[str, float]:
        values = hypothesis.values_of(placed, space.values(at))
        found = placed.effect.physical(context, placed.where, values)
        return {k: v for k, v in found.items() if k in own or "." not in k}

    here = physical(x)
    _, errors = with_errors(lambda at: np.array(list(physical(at).values())), x, covariance)
    units = {name: placed.effect.units.get(name, own.get(name, "")) for name in here}
    return dict(here), units, dict(zip(here, errors.tolist(), strict=True))


def in_figures(data: Data[M], comparison: Comparison[M], number: int) -> Compared:
    """A model of a comparison, in figures.

    Args:
        data: that it was fitted to.
        comparison: of several models.
        number: which of them.
    """
    model = comparison.models[number]
    effect, where = model.key if number else (NONE, "")
    return Compared(
        effect,
        where,
        *data.compared_gaps(model),
        float(comparison.scores[number] - comparison.scores.max()),
        float(comparison.probability[number]),
        model.parameters - comparison.models[0].parameters,
    )
