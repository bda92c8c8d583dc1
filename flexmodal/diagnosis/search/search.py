"""From many hypotheses to a few fitted well: coarse looks at all, closer looks at those that do best.

Every hypothesis starts at the card, not at the re-tuned robot: re-tuning without the effect runs away from
the truth. Rounds of more steps with fewer candidates follow one another (successive halving). Torques that
are not linear and are looked for are integrated in time from the first look on: describing functions too
often name the wrong law. What is linear is looked for beside the stand-ins of those that are there
(`beside`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.set_out import SetOut

STARTS = 2
"""Starts that are kept for each effect and place."""
ROUNDS = ((0.2, 3, 20), (0.1, 5, 10), (0.03, 8, 5))
"""Model error, steps, and how many candidates go on."""
LATE_ROUNDS = ((0.03, 3, 20), (0.02, 5, 10), (0.01, 8, 5))
"""The same beside a robot that counts as explained: at a large model error nothing shows of what is missing
there."""
ALIKE = 2
"""Places of one effect beside others that are fitted closely, if there is anything else."""
INTEGRATED_MOST = 12
"""Candidates whose torques are integrated that are fitted at all: each of their steps takes long."""
INTEGRATED_ROUNDS = ((0.2, 8, 5), (0.1, 8, 3))
"""The rounds of these."""
RESTARTS = ((0.2, 3, 6), (0.1, 10, 1))
"""The rounds of a search from many starts of one effect."""
TRIED = 24
"""How many of them are fitted at all."""
ASIDE = (-2.0, -1.0, 0.0, 1.0, 2.0)
"""Where each parameter of an effect is put in turn, in deviations of its prior, the others staying."""


def candidates(
    root: Hypothesis,
    set_out: SetOut,
    effects: Sequence[Effect],
    look: Look,
    allowed: Callable[[str, str], bool] = lambda effect, where: True,
) -> list[Candidate]:
    """Every effect in every place beside what the root holds already, at its best starts.

    Args:
        root: the hypothesis that an effect is added to.
        set_out: where the search sets out; the best starts are kept of each.
        effects: to add.
        look: the coarse look.
        allowed: names and places that are tried.
    """
    able = [effect for effect in effects if not effect.untestable(root.context)]
    todo = [Placed(effect, where) for effect in able for where in effect.places(root.context)]

    def begun(placed: Placed) -> list[Candidate]:
        hypothesis = root.and_also(placed)
        every = set_out.starts(hypothesis)
        return [one for tried in every for one in look.started(hypothesis, tried, ROUNDS[0][0], STARTS)]

    todo = [one for one in todo if one.key not in root.keys and allowed(*one.key)]
    return [one for found in parallel_map(begun, todo) for one in found]


def narrowed(
    found: Sequence[Candidate],
    look: Look,
    advance: Callable[[float], None] = lambda part: None,
    *,
    late: bool = False,
) -> list[Candidate]:
    """The candidates that do best, one for each effect and place, the best first.

    Either all of them have torques to be integrated, or none. Of those that have, the one that was best
    before any fit stays among them: friction is fitted slowly, what does nothing is soon as good as nothing.

    Args:
        found: candidates that are not fitted yet.
        look: the coarse look.
        advance: called with the part that is done.
        late: whether the robot alone counts as explained.
    """
    slow = [one for one in found if look.integrates(one.hypothesis)]
    todo = sorted(slow, key=lambda one: one.cost)[:INTEGRATED_MOST] if slow else list(found)
    rounds = INTEGRATED_ROUNDS if slow else LATE_ROUNDS if late else ROUNDS
    first = todo[0].key if slow else None
    for round_number, (floor, steps, keep) in enumerate(rounds):
        done = []
        fitted = parallel_map(partial(look.fitted, floor=floor, steps=steps), todo)
        for number, one in enumerate(fitted, start=1):
            done.append(one)
            advance((round_number + number / len(todo)) / len(rounds))
        todo = distinct(done)
        if round_number + 1 == len(rounds):
            todo = varied(todo)
        todo = _with_the_first(todo, keep, first)
    return todo


def _with_the_first(found: list[Candidate], keep: int, first: tuple[str, str] | None) -> list[Candidate]:
    """As many candidates as are kept, with the one of an effect and place among them."""
    kept, others = found[:keep], found[keep:]
    behind = [one for one in others if one.key == first]
    return [*kept[:-1], *behind] if behind else kept


def varied(found: Sequence[Candidate]) -> list[Candidate]:
    """Beside effects no more than `ALIKE` places of an effect before all others have had their turn.

    While several are missing absorbers on every link do a little of what each of them does.

    Args:
        found: candidates, the best first.
    """
    counts, first, last = Counter[str](), list[Candidate](), list[Candidate]()
    for one in found:
        counts[one.key[0]] += 1
        several = len(one.hypothesis.placed) > 1
        (last if several and counts[one.key[0]] > ALIKE else first).append(one)
    return [*first, *last]


def come_nearer(found: Sequence[Candidate], look: Look) -> list[Candidate]:
    """Starts of one effect whose torques are integrated, each fitted coarsely, the best first.

    Args:
        found: candidates that are not fitted yet.
        look: the coarse look.
    """
    for floor, steps, keep in INTEGRATED_ROUNDS:
        fitted = parallel_map(partial(look.fitted, floor=floor, steps=steps), found)
        found = sorted(fitted, key=lambda one: one.cost)[:keep]
    return list(found)


def restarted(
    hypothesis: Hypothesis,
    x: Float[np.ndarray, " parameter"],
    set_out: SetOut,
    look: Look,
) -> Candidate:
    """The last effect of a hypothesis started from everywhere, beside what the search set out from and a fit.

    Args:
        hypothesis: with the effect.
        x: where a fit of it ended.
        set_out: where the search sets out.
        look: the coarse look.
    """
    before = len(hypothesis.without(hypothesis.keys[-1]).space)
    every = replace(set_out, before=(*set_out.before, x[:before])).starts(hypothesis)
    starts = [one for some in every for one in some]
    todo = look.started(hypothesis, starts, RESTARTS[0][0], TRIED)
    todo += [Candidate(hypothesis, one, np.inf) for one in _aside(hypothesis, x)]
    for floor, steps, keep in RESTARTS:
        fitted = parallel_map(partial(look.fitted, floor=floor, steps=steps), todo)
        todo = sorted(fitted, key=lambda one: one.cost)[:keep]
    return todo[0]


def simpler(
    one: Hypothesis, x: Float[np.ndarray, " parameter"], effects: Sequence[Effect], look: Look
) -> list[Candidate]:
    """What the last effect of a hypothesis comes down to, from where a fit of it ended.

    Args:
        one: the hypothesis.
        x: where the fit ended.
        effects: those that may be named.
        look: the coarse look.
    """
    placed, root = one.placed[-1], one.without(one.keys[-1])
    values = one.values_of(placed, one.space.values(x))
    known = {effect.name: effect for effect in effects}
    found = []
    for name, shared in placed.effect.simpler.items():
        if name not in known or (name, placed.where) in root.keys:
            continue
        less = Placed(known[name], placed.where)
        hypothesis = root.and_also(less)
        start = hypothesis.start(less, {k: values[k] for k in shared if k in values}, x[: len(root.space)])
        found.append(look.fitted(Candidate(hypothesis, start, np.inf), *RESTARTS[-1][:2]))
    return found


def _aside(
    hypothesis: Hypothesis, x: Float[np.ndarray, " parameter"]
) -> list[Float[np.ndarray, " parameter"]]:
    """Each parameter of the last effect put elsewhere in turn: what hardly matters at first ends anywhere."""
    prefix = f"{hypothesis.placed[-1].label}."
    found = []
    for k, parameter in enumerate(hypothesis.space):
        if parameter.name.startswith(prefix):
            for value in ASIDE:
                moved = x.copy()
                moved[k] = value * parameter.deviation
                found.append(np.clip(moved, *hypothesis.space.bounds))
    return found


def distinct(found: Sequence[Candidate]) -> list[Candidate]:
    """The best of each effect and place, the best first."""
    best: dict[tuple[str, str], Candidate] = {}
    for one in sorted(found, key=lambda one: one.cost):
        best.setdefault(one.key, one)
    return list(best.values())
