"""What might be added to a model: every effect in every place, the few that do best fitted closely."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import Effect
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.beside import both_beside
from flexmodal.diagnosis.search.close_fit import FAR_OFF, tried_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.search import candidates, come_nearer, narrowed, restarted, simpler
from flexmodal.diagnosis.search.set_out import NEAR_BY, SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law

FINALISTS = 4
"""Candidates that are fitted closely and compared."""
INTEGRATED = 3
"""The same for effects that depend on force, whose torques are integrated in time."""
INTEGRATED_FAR = 1.5
"""Times the least cost of theirs in a coarse look, up to which these are: in all of thirteen searches in four
campaigns that were looked at the first one came to be the best."""
FAR_BEHIND, BEHIND, A_FEW = 8.0, 2.0, 6
"""Times the least cost of a coarse look; beyond it nothing comes to be the best, and so few steps show it.
The second where an explanation that was fitted closely before is enough."""
BEYOND_BELIEF = 60.0
"""Sum of the squares of the parameters' deviations, in their own, that nobody believes."""
AGAIN = 2
"""Explanations that are started from elsewhere when none of them reaches the floor."""
FIRST_FLOOR, FOLLOWED = 0.2, 6
"""Model error at which starts are compared where an effect's place is known, and how many are followed."""


def explanations(
    setup: Setup,
    before: FittedFrfs,
    set_out: SetOut,
    *,
    with_force: bool,
    enough: float,
    advance: Callable[[float], None],
    allowed: Callable[[str, str], bool] = lambda effect, where: True,
    one_is_enough: bool,
) -> list[FittedFrfs]:
    """Candidates for the next step, fitted closely and looked at, the best first.

    Args:
        setup: what the diagnosis works with.
        before: the model that something is added to.
        set_out: where the search sets out.
        with_force: whether effects that depend on the force of the blow are among them.
        enough: distance over noise from which no other starts are tried.
        advance: called with the part that is done.
        allowed: names and places that are tried.
        one_is_enough: whether one effect explains everything as far as is known, so that fits which do not
            get there are started from elsewhere.
    """
    advance(0.0)
    finalists, both = list[Candidate](), both_beside(setup, before)
    seen, late = both[0], not before.hypothesis.placed and over_noise(setup, before) <= enough
    if late:  # it has not run away from the truth
        set_out = replace(set_out, before=[before.x, *set_out.before[1:]])
    for (some, most), look in zip(_kinds(setup.effects, with_force=with_force), both, strict=True):
        found = candidates(before.hypothesis, set_out, some, look, allowed)
        near = narrowed(found, look, lambda part: advance(0.6 * part), late=late)[:most]
        far = INTEGRATED_FAR * near[0].cost if near and has_law(near[0].hypothesis) else np.inf
        finalists += [one for one in near if one.cost <= far]
    looked = _looked_at(setup, finalists, enough, lambda part: advance(0.6 + 0.3 * part))
    looked.sort(key=lambda one: one.cost)
    if one_is_enough and looked and over_noise(setup, looked[0]) > enough:
        again = parallel_map(lambda one: _elsewhere(setup, seen, one, set_out), looked[:AGAIN])
        looked = [*again, *looked[AGAIN:]]
        looked.sort(key=lambda one: one.cost)
    if looked:
        found = simpler(looked[0].hypothesis, looked[0].fitted.x, setup.effects, seen)
        looked = best_of_each([*looked, *(more for one in found for more in fitted_believably(setup, one))])
    return looked


def from_each_start(
    setup: Setup,
    before: FittedFrfs,
    set_out: SetOut,
    keys: Sequence[tuple[str, str]],
    is_enough: Callable[[FittedFrfs], bool],
    followed: int = FOLLOWED,
) -> list[FittedFrfs]:
    """Effects in places that are known, fitted closely from each of their best starts.

    A narrow resonance is lost to the coarse looks.

    Args:
        setup: what the diagnosis works with.
        before: the model that one of them is added to.
        set_out: where the search sets out.
        keys: names and places.
        is_enough: whether a fit leaves nothing, so that no other start is followed.
        followed: how many starts of each are fitted closely at most.
    """
    plain, integrated = both_beside(setup, before)
    effects, found = {effect.name: effect for effect in setup.effects}, []
    for name, where in keys:
        placed = Placed(effects[name], where)
        hypothesis = before.hypothesis.and_also(placed)
        tried = [one for some in set_out.starts(hypothesis) for one in some]
        seen = integrated if placed.effect.by_force else plain
        some = seen.started(hypothesis, tried, FIRST_FLOOR, followed)
        near = come_nearer(some, seen) if has_law(hypothesis) else some
        tried_each = parallel_map(lambda one: tried_closely(setup, one.hypothesis, one.x), near)
        for number in range(len(near)):
            setup.advance("fitting where a look points", number / len(near))
            fitted = next(tried_each)
            found += fitted
            if any(is_enough(model) for model in fitted):
                break
    return best_of_each(found)


def best_of_each(looked: Sequence[FittedFrfs]) -> list[FittedFrfs]:
    """Of each effect and place the model that fits best, the best first; none that has no finite cost.

    Args:
        looked: fitted models.
    """
    best: dict[tuple[str, str], FittedFrfs] = {}
    for one in sorted((one for one in looked if np.isfinite(one.cost)), key=lambda one: one.cost):
        best.setdefault(one.key, one)
    return list(best.values())


def _kinds(effects: Sequence[Effect], *, with_force: bool) -> list[tuple[list[Effect], int]]:
    """Effects that depend on the blow after all others, and how many of each are looked at closely."""
    by_force = [effect for effect in effects if effect.by_force]
    others = [effect for effect in effects if not effect.by_force]
    return [(others, FINALISTS), (by_force if with_force else [], INTEGRATED)]


def _looked_at(
    setup: Setup, finalists: Sequence[Candidate], enough: float, advance: Callable[[float], None]
) -> list[FittedFrfs]:
    """Candidates fitted closely, those that are far behind with a few steps.

    How far that is depends on whether one of those that are near is enough.
    """
    least = min((one.cost for one in finalists), default=0.0)
    near = [one.cost <= BEHIND * least for one in finalists]

    def fitted(one: tuple[Candidate, bool]) -> list[FittedFrfs]:
        candidate, closely = one
        if closely:
            return fitted_believably(setup, candidate)
        return tried_closely(setup, candidate.hypothesis, candidate.x, near=True, steps=A_FEW)

    looked: list[FittedFrfs] = []
    far = FAR_BEHIND
    for first in (True, False):
        some = [one for one, is_near in zip(finalists, near, strict=True) if is_near is first]
        for found in parallel_map(fitted, [(one, one.cost <= far * least) for one in some]):
            looked += found
            advance(len(looked) / len(finalists))
        if any(over_noise(setup, one) <= enough for one in looked):
            far = BEHIND
    return looked


def fitted_believably(setup: Setup, one: Candidate) -> list[FittedFrfs]:
    """Once more from the card where a robot is come to that nobody believes, for one as good may be nearer.

    What an effect and the robot's parameters do alike is settled by these beliefs alone, and slowly. Beside
    several effects, whose own parameters count as much, nothing is fitted twice, nor what is far from the
    noise: there it is what else is missing that drives the robot away.

    Args:
        setup: what the diagnosis works with.
        one: the candidate, come near by coarse looks.

    Returns:
        The better one; none where there is no model.
    """
    found = tried_closely(setup, one.hypothesis, one.x, near=True)
    if not found or len(one.hypothesis.placed) > NEAR_BY or has_law(one.hypothesis):
        return found
    if found[0].prior < BEYOND_BELIEF or over_noise(setup, found[0]) > FAR_OFF:
        return found
    start = found[0].x.copy()
    start[: len(one.hypothesis.base)] = 0.0
    return [min([*found, *tried_closely(setup, one.hypothesis, start)], key=lambda model: model.cost)]


def _elsewhere(setup: Setup, seen: Look, one: FittedFrfs, set_out: SetOut) -> FittedFrfs:
    """The same explanation from all the starts of its effect, if one of them leads further down."""
    if has_law(one.hypothesis):
        return one
    others = fitted_believably(setup, restarted(one.hypothesis, one.fitted.x, set_out, seen))
    return min([one, *others], key=lambda model: model.cost)
