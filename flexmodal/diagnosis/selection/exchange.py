"""Better ones among the effects of a model: another in place of one, or one with a wider law.

What was added while others were missing may have taken up what was due to these.
"""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress

from flexmodal.diagnosis.outcome import Step
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import comes_before
from flexmodal.diagnosis.time_limit import OutOfTime

NEARER = 0.1
"""Part of what is left above the noise that another model has to take to be better."""
WITHOUT = 0.5
"""Part of the disagreement that several effects take without one more that may be due to the narrow law of
one of them: what takes more than they do is no remainder of a law. One effect alone may be all there is."""

EVEN = 0.5
"""Confidence below which an effect is less sure than not."""


def takes(data: Data[M], first: M, last: M, part: float) -> bool:
    """Whether a model takes so much of what another one leaves above the noise.

    Args:
        data: that both are fitted to.
        first: the one.
        last: the other.
        part: of what the first leaves.
    """
    taken = data.share(first, last)
    return taken is not None and taken > part


def reconsidered(data: Data[M], model: M) -> M:
    """With what was considered in place of each effect but the last, where it does better beside the others.

    Args:
        data: that it is fitted to.
        model: with effects.
    """
    for key in model.hypothesis.keys[:-1]:
        others = data.instead(model, key)
        if others and takes(data, model, others[0], NEARER):
            model = others[0]
    return model


def looked_for_again(data: Data[M], model: M, key: tuple[str, str]) -> M:
    """With what a look finds beside the others, in place of one effect; it may be the same, fitted afresh.

    Args:
        data: that it is fitted to.
        model: with effects.
        key: name and place of the one.
    """
    less = data.without(model, key)
    comparison = data.compare(data.pointed(less, len(model.hypothesis.keys) - 1))
    other = comparison.best_effect
    better = bool(other) and takes(data, model, comparison.models[other], NEARER)
    return comparison.models[other] if better else model


def widened(data: Data[M], model: M, keys: Collection[tuple[str, str]]) -> M:
    """With a wider law for one of several effects: with too narrow a one the others fit what it leaves.

    Args:
        data: that it is fitted to.
        model: with effects.
        keys: names and places of those that it is tried for.
    """
    return next((one for one in data.wider(model, keys) if takes(data, model, one, NEARER)), model)


def exchanged(data: Data[M], model: M) -> M:
    """With another effect in place of one but the last, where a look finds a better one.

    Args:
        data: that it is fitted to.
        model: with effects.
    """
    for key in model.hypothesis.keys[:-1]:
        other = looked_for_again(data, model, key)
        if other is not model:
            return other
    return model


def without(data: Data[M], model: M, key: tuple[str, str]) -> M:
    """A model with one effect less, and with a wider law for another one where that does as well.

    What a narrow law leaves may have been taken for one effect more. Of wider laws only while there is time.

    Args:
        data: that it is fitted to.
        model: with effects.
        key: name and place of the one.
    """
    less = data.without(model, key)
    keys, share = less.hypothesis.keys, data.share(data.root, less)
    if len(keys) > 1 and (share is None or share < WITHOUT):
        return less
    wider: list[M] = []
    with suppress(OutOfTime):
        wider = data.wider(less, keys)
    return next((one for one in wider if data.is_close(one) or takes(data, model, one, NEARER)), less)


def of_the_tied(data: Data[M], comparison: Comparison[M], step: Step) -> Comparison[M] | None:
    """What was tied with one of several effects, where it is clearly more plausible beside the others.

    Of one that is less sure than not anything that was considered where it was looked for; of one that can do
    much, what is plainer and touches its place; of one that is another one in a limit, that one.

    Args:
        data: that models are fitted to.
        comparison: of a model without the effect and with it.
        step: the effect, and what it was tied with when it was added.

    Returns:
        The model without the effect, and with the other one in its place.
    """
    less, model = comparison.models
    doubtful = step.confidence < EVEN
    others = data.instead(model, (step.effect, step.where), anyway=True) if step.ties or doubtful else []
    tied = [one for one in others if doubtful or one.key in step.ties]
    tied += data.plainer(less, (step.effect, step.where))
    if not tied:
        return None
    every = data.compare([less, model, *tied])
    found = comes_before(data.plausible(every), 1, range(2, len(every.models)))
    return None if found is None else data.compare([less, every.models[found]])
