"""Every law at each of its levels in every place, looked at coarsely, where nothing points to the right one.

A narrow law that takes next to nothing says little of the wider one in its place: of a rod between two joints
whose ratio changes with the posture a constant ratio takes nothing, and the rod all but a fiftieth. A few
steps at a large model error tell them apart, so that all are tried before any is followed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Effect, Level
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.beside import seen_beside
from flexmodal.diagnosis.search.close_fit import tried_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.next_level import at_next_level, level_above, of_last
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Advance, Setup

MODEL_ERROR, STARTS, MOST = 0.2, 2, 200
"""At which they are compared, from how many starts each is fitted, and about how many are looked at."""
FIRST, NEAR, FURTHER = 2, 3.0, 3
"""Steps of each, up to how many times the least cost a law is fitted further, and by how many steps."""
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
    trials = _Trials(replace(seen_beside(setup, before), straight=True), before.hypothesis, x)
    able = [one for one in setup.effects if one.next_level is not None and (with_force or not one.by_force)]
    able = [one for one in able if not one.untestable(setup.context)]
    todo = [(effect, where) for effect in able for where in effect.places(setup.context)]
    todo = [(effect, where) for effect, where in todo if (effect.name, where) not in before.hypothesis.keys]
    return sorted(trials.every(todo, setup.advance), key=lambda one: one.cost)


@dataclass(frozen=True, eq=False)
class _Turn:
    """A law at one of its levels in its place, to be tried."""

    level: Level
    where: str
    narrower: Candidate | None = None
    """With the law one level below."""


class _Trials:
    """Laws beside a model, fitted by a few steps, and by a few more where they are not far from the best."""

    def __init__(self, seen: Look, before: Hypothesis, x: Float[np.ndarray, " before"]) -> None:
        self.seen, self.before, self.x, self.least = seen, before, x, np.inf

    def every(self, laws: Sequence[tuple[Effect, str]], advance: Advance) -> Iterator[Tried]:
        """Laws in their places, from the narrowest level on, each beside the robot as it was."""
        turns, done = [_Turn(Level.anew(effect), where) for effect, where in laws], 0.0
        while turns:
            begun = list[list[Candidate]]()
            for some in parallel_map(self.begun, turns):
                begun.append(some)
                advance("trying every law", done + 0.5 * (1 - done) * len(begun) / len(turns))
            self.least = min([self.least, *(one.cost for some in begun for one in some)])
            done = done + 0.5 * (1 - done)
            there = [(turn, some) for turn, some in zip(turns, begun, strict=True) if some]
            ended = parallel_map(self.furthest, [some for _, some in there])
            turns = []
            for (turn, _), reached in zip(there, ended, strict=True):
                yield Tried(reached, turn.narrower)
                level = level_above(turn.level.effect, self.before.context, turn.where)
                turns += [] if level is None else [_Turn(level, turn.where, reached)]

    def begun(self, turn: _Turn) -> list[Candidate]:
        """From a few of its starts, given the values of the level below."""
        placed, context, below = Placed(turn.level.effect, turn.where), self.before.context, turn.narrower
        hypothesis = self.before.and_also(placed)
        own = {} if below is None else of_last(below.hypothesis, below.x)
        given = _spread(turn.level.starts(context, turn.where, own))
        some = self.seen.started(
            hypothesis, [hypothesis.start(placed, one, self.x) for one in given], MODEL_ERROR, STARTS
        )
        return [self.seen.fitted(one, MODEL_ERROR, FIRST) for one in some]

    def furthest(self, begun: Sequence[Candidate]) -> Candidate:
        """The best of some starts, those fitted further that are not far from the best of all."""
        near = [one for one in begun if one.cost <= NEAR * self.least]
        ended = [self.seen.fitted(one, MODEL_ERROR, FURTHER) for one in near] or begun
        return min(ended, key=lambda one: one.cost)


def _spread(starts: Sequence[Mapping[str, float]]) -> Sequence[Mapping[str, float]]:
    """About `MOST` of a grid's starts, so far apart that those kept have every value of its fastest turns."""
    return starts[:: 2 * (len(starts) // (2 * MOST)) + 1]


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
    *,
    anywhere: bool,
) -> list[FittedFrfs]:
    """Laws fitted closely, one place after the other until one is enough.

    From where they have come to, and if that is not enough perhaps from all starts of their level on.

    Args:
        setup: what the diagnosis works with.
        tried: which, the best first.
        set_out: where else their fits may set out.
        is_enough: whether a fit leaves nothing.
        anywhere: whether all starts are followed. Where more than one effect is missing none leaves nothing,
            and what is come to so is near enough to look for the next one.
    """
    found: list[FittedFrfs] = []
    for one in tried:
        found += tried_closely(setup, one.reached.hypothesis, one.reached.x)
        if any(is_enough(each) for each in found):
            break
        if not anywhere:
            continue
        below = one.narrower
        narrow = [] if below is None else tried_closely(setup, below.hypothesis, below.x)
        found += [more for each in narrow for more in at_next_level(setup, each, set_out, is_enough)]
        if any(is_enough(each) for each in found):
            break
    return found
