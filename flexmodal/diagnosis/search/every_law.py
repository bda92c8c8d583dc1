"""Every law at each of its levels in every place, looked at coarsely, where nothing points to the right one.

A narrow law that takes next to nothing says little of the wider one in its place: of a rod between two joints
whose ratio changes with the posture a constant ratio takes nothing, and the rod all but a fiftieth. A few
steps at a large model error tell them apart, so that all are tried before any is followed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Effect, Level
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.beside import seen_beside
from flexmodal.diagnosis.search.close_fit import tried_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.next_level import at_next_level, of_last
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup

MODEL_ERROR, STEPS, STARTS = 0.2, 5, 2
"""At which they are compared, how far each is fitted, and from how many starts."""
GAINS = 0.8
"""Part of what the best narrow law leaves that a wider one leaves at most, to be followed, as each takes long
to be fitted closely. In four looked-at campaigns that had come to nothing otherwise the true law came first,
with 0.02 to 0.69 of it."""
FOLLOWED, BEHIND = 3, 2.0
"""Places that are followed at most, up to so many times the least cost."""


@dataclass(frozen=True, eq=False)
class Tried:
    """A law in its place after a few steps."""

    reached: Candidate
    narrower: Candidate | None
    """With the law one level below; None of the narrowest."""

    @property
    def cost(self) -> float:
        """See `Candidate`."""
        return self.reached.cost


def every_law(
    setup: Setup, before: FittedFrfs, x: Float[np.ndarray, " before"], *, with_force: bool
) -> list[Tried]:
    """Laws that have levels, at each of them and in every place, the best first.

    Torques count as their stand-ins at one amplitude, so that nothing is integrated.

    Args:
        setup: what the diagnosis works with.
        before: the model that one of them is added to.
        x: coordinates of it to set out from.
        with_force: whether those that depend on the force of the blow are among them.
    """
    seen = replace(seen_beside(setup, before), straight=True)
    able = [one for one in setup.effects if one.next_level is not None and (with_force or not one.by_force)]
    able = [one for one in able if not one.untestable(setup.context)]
    todo = [(effect, where) for effect in able for where in effect.places(setup.context)]
    todo = [(effect, where) for effect, where in todo if (effect.name, where) not in before.hypothesis.keys]
    found: list[Tried] = []
    for number, (effect, where) in enumerate(todo):
        setup.advance("trying every law", number / len(todo))
        found += _levels(seen, before.hypothesis, x, effect, where)
    return sorted(found, key=lambda one: one.cost)


def _levels(
    seen: Look, before: Hypothesis, x: Float[np.ndarray, " before"], effect: Effect, where: str
) -> Iterator[Tried]:
    """One law in one place, from the narrowest on; the robot as it was, whatever the one below made of it."""
    context, below = before.context, None
    level: Level | None = Level.anew(effect)
    while level is not None:
        placed, given = Placed(level.effect, where), level.starts
        level = level.effect.next_level
        if where not in placed.effect.places(context):
            continue
        hypothesis = before.and_also(placed)
        own: dict[str, float] = {} if below is None else of_last(below.hypothesis, below.x)
        tried = [hypothesis.start(placed, one, x) for one in given(context, where, own)]
        some = seen.started(hypothesis, tried, MODEL_ERROR, STARTS)
        fitted = [seen.fitted(one, MODEL_ERROR, STEPS) for one in some]
        if not fitted:
            return
        reached = min(fitted, key=lambda one: one.cost)
        yield Tried(reached, below)
        below = reached


def worth_following(tried: Sequence[Tried]) -> list[Tried]:
    """The best level of the few places where a wider law does far better than every narrow one.

    Args:
        tried: the best first.
    """
    narrow = min((one.cost for one in tried if one.narrower is None), default=np.inf)
    best: dict[tuple[str, str], Tried] = {}
    for one in tried:
        if one.cost <= GAINS * narrow:
            best.setdefault(one.reached.key, one)
    return [one for one in best.values() if one.cost <= BEHIND * tried[0].cost][:FOLLOWED]


def followed(
    setup: Setup,
    tried: Sequence[Tried],
    set_out: SetOut,
    is_enough: Callable[[FittedFrfs], bool],
) -> list[FittedFrfs]:
    """Laws fitted closely, one place after the other until one is enough.

    From where they have come to, and if that is not enough from all starts of their level on.

    Args:
        setup: what the diagnosis works with.
        tried: which, the best first.
        set_out: where else their fits may set out.
        is_enough: whether a fit leaves nothing.
    """
    found: list[FittedFrfs] = []
    for one in tried:
        found += tried_closely(setup, one.reached.hypothesis, one.reached.x)
        if any(is_enough(each) for each in found):
            break
        below = one.narrower
        narrow = [] if below is None else tried_closely(setup, below.hypothesis, below.x)
        found += [more for each in narrow for more in at_next_level(setup, each, set_out, is_enough)]
        if any(is_enough(each) for each in found):
            break
    return found
