"""What an explanation has to gain before it is added: thresholds with a margin on both sides.

A figure within the margin of its threshold is undecided: the simpler explanation stays, and the answer says
so, so that no rounding turns a no into a yes. The thresholds were tuned on campaigns of the virtual rig, on
seeds apart from those of the published exam.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic

from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.comparison import MARGIN, TIED, Comparison, FittedModel, M

SIGNIFICANT = 7.0
"""Evidence that an explanation has to gain, with `MARGIN` on both sides [nat]: 8 are odds of 3000 to 1."""
ASKED = 5.0
"""The same for what was asked for by its place."""
MORE_PLAUSIBLE = 5.0
"""By how much a model that explains everything has to be more plausible than another to come first, with
`MARGIN` on both sides [nat]."""
DOUBTED, DOUBTED_MARGIN = -math.log(0.0141), math.log(2) / 2
"""Of −ln of the confidence of an effect, above which it is hardly possible: below 0.01 it is, from 0.02 on it
is not."""
NEAR = 0.02
"""Distance from a bound up to which a parameter is at it: logarithms of what is positive."""

Asked = Mapping[str, tuple[str, ...]]
"""Effects that the caller named, each with the places that were named along."""


class Answer(IntEnum):
    """Whether a figure reaches its threshold; the least of several is that of all of them together."""

    NO = 0
    UNDECIDED = 1
    YES = 2


def reaches(value: float, threshold: float, margin: float) -> Answer:
    """Whether a figure reaches a threshold.

    Args:
        value: the figure; NaN reaches nothing.
        threshold: in the same unit.
        margin: on both sides of it, within which nothing is decided.
    """
    if value > threshold + margin:
        return Answer.YES
    return Answer.UNDECIDED if value >= threshold - margin else Answer.NO


def hardly_possible(confidence: float) -> Answer:
    """Whether an effect is not believed whatever its evidence, which counts what a law leaves line by line.

    Args:
        confidence: of the effect.
    """
    return reaches(-math.log(max(confidence, 1e-300)), DOUBTED, DOUBTED_MARGIN)


def gains_enough(comparison: Comparison[M], number: int) -> Answer:
    """Whether a model gains enough as believed and with all data, and under (nearly) every setting too.

    Args:
        comparison: of several models.
        number: which.
    """
    first = reaches(comparison.first_gain(number), SIGNIFICANT, MARGIN)
    # Draws of a bootstrap are of one kind; sets of beliefs are not, and none of them may speak against it.
    least = TIED if comparison.beliefs else SIGNIFICANT
    return min(first, reaches(comparison.gain(number), least, MARGIN))


def any_gains(comparison: Comparison[M]) -> Answer:
    """Whether anything at all gains enough, a mode with no structure included."""
    every = range(1, len(comparison.models))
    return max((gains_enough(comparison, k) for k in every), default=Answer.NO)


def named_with_place(key: tuple[str, str], asked: Asked | None) -> bool:
    """Whether the caller named an effect with this place.

    Args:
        key: name and place.
        asked: what was named; None for nothing.
    """
    return asked is not None and key[1] in asked.get(key[0], ())


@dataclass(frozen=True)
class Choice:
    """What is added, and what came too near to its threshold for a yes or a no."""

    number: int | None
    undecided: tuple[int, ...] = ()
    rival: int | None = None
    """What may be plausible enough to come before what is added."""


@dataclass(frozen=True, eq=False)
class Round(Generic[M]):
    """One comparison, and what came of it."""

    comparison: Comparison[M]
    choice: Choice


def choice(
    comparison: Comparison[M],
    asked: Asked | None,
    worth: Sequence[Answer],
    vouched: Sequence[bool] = (),
    plausible: Mapping[int, float] | None = None,
) -> Choice:
    """The best model that has a structure and takes enough away, if it gains enough.

    Where effects were named, the first that does.

    What was named with its place only has to gain more than a tie. Where settings are sets of beliefs, and
    nothing was named, whatever is tied with the best keeps it from being added. What is vouched for comes
    first if it gains anything: of several effects each alone may gain little. An effect that the best comes
    down to in a limit stands in its place where the data cannot tell the two, or where the limit is reached.

    Of models that explain everything one that is clearly more plausible than the best comes before it.

    Args:
        comparison: of the model as it is and of what might be added.
        asked: effects that were named; None for none.
        worth: of each model whether it takes enough away besides.
        vouched: of each whether it is known to be needed; none by default.
        plausible: of those that explain everything, by number, how plausible they are [nat].
    """
    ranked = sorted(range(1, len(comparison.models)), key=lambda k: -comparison.scores[k])
    ranked = [k for k in ranked if comparison.models[k].key[0] != UNSTRUCTURED]
    ranked, rival = _plausible_first(ranked, plausible or {})
    known = [k for k in ranked if any(vouched) and vouched[k] and comparison.first_gain(k) > MARGIN]
    if known:
        return Choice(known[0])
    if asked is None:
        if comparison.beliefs and len(comparison.tied) > 1:
            return Choice(None)
        ranked = [k for k in ranked if worth[k] > Answer.NO]
        ranked = [*_plainer(comparison, ranked[0]), ranked[0]] if ranked else []
    open_ = []
    for k in ranked:
        answer = min(gains_enough(comparison, k), worth[k])
        if named_with_place(comparison.models[k].key, asked):
            answer = max(answer, reaches(comparison.first_gain(k), ASKED, MARGIN))
        if answer is Answer.YES:
            return Choice(k, rival=rival if rival != k else None)
        if answer is Answer.UNDECIDED:
            open_.append(k)
    return Choice(None, tuple(open_))


def _plausible_first(ranked: list[int], plausible: Mapping[int, float]) -> tuple[list[int], int | None]:
    """With one in front that explains everything as the best does, and is clearly more plausible.

    Returns:
        The order, and the number of one for which it is undecided whether it comes first.
    """
    able = [k for k in ranked if k in plausible]
    if not able or able[0] != ranked[0]:
        return ranked, None
    first, answer = _most_plausible(plausible, ranked[0], able)
    if answer is Answer.YES:
        return [first, *(k for k in ranked if k != first)], None
    return ranked, first if answer is Answer.UNDECIDED else None


def comes_before(plausible: Mapping[int, float], number: int, others: Collection[int]) -> int | None:
    """Of others that explain everything, the one most plausible, if it clearly is more so than a model.

    Args:
        plausible: of those of a comparison that explain everything [nat].
        number: of the model.
        others: numbers of those that may come before it.
    """
    able = [k for k in others if k in plausible]
    if not able or number not in plausible:
        return None
    first, answer = _most_plausible(plausible, number, able)
    return first if answer is Answer.YES else None


def _most_plausible(
    plausible: Mapping[int, float], number: int, others: Collection[int]
) -> tuple[int, Answer]:
    """Of others the one most plausible, and whether it clearly is more so than a model."""
    first = max(others, key=lambda k: plausible[k])
    return first, reaches(plausible[first] - plausible[number], MORE_PLAUSIBLE, MARGIN)


def is_idle(plausible: Mapping[int, float]) -> bool:
    """Whether a model explains everything without its last effect too, and is clearly more plausible so.

    Args:
        plausible: of a comparison of the model without the effect, 0, and with it, 1; those that explain
            everything [nat].
    """
    return comes_before(plausible, 1, [0]) is not None


def _plainer(comparison: Comparison[M], first: int) -> list[int]:
    """What the best model's last effect comes down to in a limit, if that is tied with it or it is there."""
    models = comparison.models
    here = [k for k in comparison.order if k not in (0, first) and models[k].key[1] == models[first].key[1]]
    return [
        k
        for k in here
        if models[k].key[0] in models[first].hypothesis.placed[-1].effect.simpler
        and (k in comparison.tied or _at_its_limit(models[first]))
    ]


def _at_its_limit(model: FittedModel) -> bool:
    """Whether the last effect of a model has come to where it is another one."""
    placed, space = model.hypothesis.placed[-1], model.hypothesis.space
    if not placed.effect.limit:
        return False
    k = space.index[f"{placed.label}.{placed.effect.limit}"]
    return bool(model.x[k] >= space.bounds[1][k] - NEAR)


def among_vouched(
    comparison: Comparison[M],
    chosen: int,
    vouches: Callable[[M], bool],
    compare: Callable[[Sequence[M]], Comparison[M]],
) -> tuple[Comparison[M], int]:
    """What was chosen because it is vouched for, compared with nothing added and others that are so.

    Of several effects one in the wrong place may take more alone than any in its own: that says nothing of
    how sure the chosen one is.

    Args:
        comparison: of everything.
        chosen: number of what was chosen.
        vouches: whether a model is known to be needed.
        compare: models, the first without anything new.

    Returns:
        The comparison to go by, and the number of the chosen model in it.
    """
    models = comparison.models
    if comparison.order[0] == chosen or not vouches(models[chosen]):
        return comparison, chosen
    kept = [k for k in range(1, len(models)) if k == chosen or vouches(models[k])]
    return compare([models[0], *(models[k] for k in kept)]), kept.index(chosen) + 1


def rivals(
    comparison: Comparison[M], chosen: int | None, alike: Callable[[M, M], bool]
) -> tuple[M, M] | None:
    """What was added, or is best, and what is tied with it and makes predictions of its own.

    An effect comes before nothing added, one that explains as much before one that does not.

    Args:
        comparison: of several models.
        chosen: number of the one that was added, if any.
        alike: whether two models explain as much.
    """
    able = [k for k in comparison.tied if comparison.models[k].key[0] != UNSTRUCTURED]
    number = chosen if chosen is not None else next((k for k in able if k), None)
    if number is None:
        return None
    first = comparison.models[number]
    others = [k for k in able if k != number]
    others.sort(key=lambda k: (k == 0, not alike(first, comparison.models[k])))
    return (first, comparison.models[others[0]]) if others else None
