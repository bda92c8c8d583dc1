"""Where a search beside a model sets out, and which of what it found stays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from flexmodal.diagnosis.lawfree.result import PORT_OF, Findings, holds
from flexmodal.diagnosis.search.set_out import NEAR_BY, SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs


def starts(before: FittedFrfs, look: Findings | None = None) -> SetOut:
    """Where a search sets out: at the card, with the effects there are, and where other fits ended.

    A fit without an effect that is there runs away from the truth; one with its law free does not, and one
    with several effects is near it.

    Args:
        before: the model that something is added to.
        look: without a law, beside it.
    """
    count, found = len(before.hypothesis.base), []
    if len(before.hypothesis.placed) < NEAR_BY:
        found.append(np.concatenate([np.zeros(count), before.x[count:]]))
    if before.hypothesis.placed:
        found.append(before.x)
    if look is not None and look.needed and look.fitted is not None:
        found.append(look.fitted)
        return SetOut(found, cache(lambda effect, where: look.told(effect, where, before.hypothesis.context)))
    return SetOut(found)


def with_last(model: FittedFrfs, key: tuple[str, str]) -> FittedFrfs:
    """The same model with one of its effects as the last.

    Args:
        model: with effects.
        key: name and place of the one.
    """
    placed = next(one for one in model.hypothesis.placed if one.key == key)
    hypothesis = model.hypothesis.without(key).and_also(placed)
    x = model.x[[model.hypothesis.space.index[name] for name in hypothesis.space.names]]
    return replace(model, key=key, hypothesis=hypothesis, fitted=replace(model.fitted, x=x))


def does_more(one: tuple[str, str], other: tuple[str, str]) -> bool:
    """Whether an effect's port can do all that another one's can, and more.

    Args:
        one: name and place.
        other: the same of the other.
    """
    if one[0] not in PORT_OF or other[0] not in PORT_OF:
        return False
    wide, narrow = (PORT_OF[one[0]], one[1]), (PORT_OF[other[0]], other[1])
    return wide != narrow and holds(wide, narrow)


def narrowest(found: Sequence[FittedFrfs], is_enough: Callable[[FittedFrfs], bool]) -> list[FittedFrfs]:
    """Without what can do more than another one that is enough.

    Args:
        found: models with one effect more.
        is_enough: whether nothing is left to be explained.
    """
    enough = [one.key for one in found if is_enough(one)]
    return [one for one in found if not any(does_more(one.key, other) for other in enough)]
