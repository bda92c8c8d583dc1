"""Where a search beside a model sets out, what it is for, and which of what it found stays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from flexmodal.diagnosis.lawfree.effects_at import CLASSES_OF, PORT_OF, holds
from flexmodal.diagnosis.lawfree.joint_ports import TORQUE
from flexmodal.diagnosis.lawfree.look import SOUND
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.set_out import NEAR_BY, SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup


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


def pointed_to(setup: Setup, before: FittedFrfs, look: Findings) -> list[tuple[str, str]]:
    """Further effects whose place and class a look has found: those that it has a class for, and laws.

    Args:
        setup: what the diagnosis works with.
        before: the model that one of them may be added to.
        look: without a law, beside it.
    """
    return [
        key
        for key in _others(setup, before)
        if any(one.where == key[1] and one.could_be(*key) for one in look.found)
    ]


def nearer(setup: Setup, before: FittedFrfs, look: Findings) -> list[tuple[str, str]]:
    """Further effects where a look leaves less than at the simpler place that it found for them.

    Args:
        setup: what the diagnosis works with.
        before: the model that one of them may be added to.
        look: without a law, beside it.
    """
    judged = {(one.port, one.where): one.judged for one in look.places}
    less = {
        key
        for one in look.found
        for key in one.alike
        if judged.get(key, np.inf) < judged.get((one.port, one.where), 0.0)
    }
    return [(name, where) for name, where in _others(setup, before) if (PORT_OF.get(name), where) in less]


def swung(setup: Setup, before: FittedFrfs, look: Findings) -> list[tuple[str, str]]:
    """Further effects that depend on the blow in a joint whose torque explains everything, but not best.

    A hammer point whose blows go elsewhere in each posture does best for a joint that only they swing far
    enough.

    Args:
        setup: what the diagnosis works with.
        before: the model that one of them may be added to.
        look: without a law, beside it.
    """
    if not look.explains or len(look.found) != 1 or look.found[0].curve is not None:
        return []
    able = [one.where for one in look.places if one.port == TORQUE.name and one.judged <= SOUND]
    if look.found[0].port == TORQUE.name or not able:
        return []
    forced = {effect.name for effect in setup.effects if effect.by_force}
    return [key for key in _others(setup, before) if key[0] in forced and key[1] == able[0]]


def _others(setup: Setup, before: FittedFrfs) -> list[tuple[str, str]]:
    """Effects that a curve or a law can tell, in each of their places, but those that are there."""
    return [
        (effect.name, where)
        for effect in setup.effects
        if (effect.name in CLASSES_OF or effect.law is not None) and not effect.untestable(setup.context)
        for where in effect.places(setup.context)
        if (effect.name, where) not in before.hypothesis.keys
    ]


def with_last(model: FittedFrfs, key: tuple[str, str]) -> FittedFrfs:
    """The same model with one of its effects as the last.

    Args:
        model: with effects.
        key: name and place of the one.
    """
    placed = next(one for one in model.hypothesis.placed if one.key == key)
    hypothesis = model.hypothesis.without(key).and_also(placed)
    order = np.array([model.hypothesis.space.index[name] for name in hypothesis.space.names])
    fitted = replace(model.fitted, x=model.x[order], known=model.fitted.normal.ordered(order))
    return replace(model, key=key, hypothesis=hypothesis, fitted=fitted)


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
