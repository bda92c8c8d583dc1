"""From many hypotheses to a few fitted well: coarse looks at all, closer looks at those that do best.

Every hypothesis starts at the card, not at the re-tuned robot: re-tuning without the effect runs away from
the truth. Rounds of more steps with fewer candidates follow one another (successive halving). Torques that
are not linear are marched in time from the first look on: describing functions name the wrong law too often.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.compare import but_for_the_blow
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.hypothesis import Hypothesis, Placed
from flexmodal.diagnosis.march.model import MarchedModel, has_law
from flexmodal.identification import Observations
from flexmodal.identification.descent import robust
from flexmodal.identification.frf_fit import Weighing, cost_of, fit, residual
from flexmodal.identification.model import Model

COARSE = 48
"""Lines of the coarse looks, closer together where resonances are narrow."""
WORST = 16
"""Further lines of the coarse looks, where what is to be explained is."""
CLOSE = 160
"""Lines of the closer ones."""
STARTS = 2
"""Starts that are kept for each effect and place."""
ROUNDS = ((0.2, 3, 20), (0.1, 5, 10), (0.03, 8, 5))
"""Model error, steps, and how many candidates go on."""
MARCHED_MOST = 12
"""Candidates whose torques are marched that are fitted at all: each of their steps takes long."""
MARCHED_ROUNDS = ((0.1, 4, 5),)
"""The rounds of these."""
RESTARTS = ((0.2, 3, 6), (0.1, 10, 1))
"""The rounds of a search from many starts of one effect."""
TRIED = 24
"""How many of them are fitted at all."""
ASIDE = (-2.0, -1.0, 0.0, 1.0, 2.0)
"""Where each parameter of an effect is put in turn, in deviations of its prior, the others staying."""
ROUGH = 5.0
"""Steps of time in a period of the highest line, of the coarse looks."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A hypothesis on its way."""

    hypothesis: Hypothesis
    x: Float[np.ndarray, " parameter"]
    cost: float
    """On coarse lines at the last round's model error."""

    @property
    def key(self) -> tuple[str, str]:
        """Name and place of the effect it adds last."""
        return self.hypothesis.keys[-1]


def some_lines(observations: Observations, count: int) -> Int[np.ndarray, " line"]:
    """Numbers of about so many lines, half of them evenly spaced, half on a logarithmic scale."""
    every = len(observations.axis)
    if count >= every:
        return np.arange(every)
    even = np.linspace(0, every - 1, count // 2)
    frequency = observations.axis.frequency
    spread = np.interp(
        np.linspace(np.log(frequency[0]), np.log(frequency[-1]), count - count // 2),
        np.log(frequency),
        np.arange(every),
    )
    return np.unique(np.concatenate([even, spread]).round().astype(int))


def unlimited(observations: Observations) -> Observations:
    """As if every record lasted until all is still: what is cut off is a matter for the close look."""
    return replace(observations, lengths=tuple(0.0 for _ in observations.lengths))


@dataclass(frozen=True, eq=False)
class Look:
    """Observations as the coarse looks see them: levels of force apart, and as one.

    A model without force levels is as far from the mean over them as from each, but for a constant.
    """

    apart: Observations
    merged: Observations
    share: Float[np.ndarray, " observation"]
    """How many levels each merged observation stands for."""
    lines: Int[np.ndarray, " line"]

    def constant(self, floor: float) -> float:
        """What the mean hides of the sum of squares."""
        weight = Weighing(floor, self.lines).weight(self.apart)
        between = residual(self.merged.value[self.owner][:, self.lines], self.apart.value[:, self.lines])
        return float(np.sum(robust(weight * np.abs(between) ** 2)))

    @cached_property
    def owner(self) -> Int[np.ndarray, " observation"]:
        """The merged observation of each."""
        return but_for_the_blow(self.apart)

    def fitted(self, one: Candidate, floor: float, steps: int) -> Candidate:
        """A candidate some steps further."""
        loud = by_force(one.hypothesis)
        seen, share = (self.apart, None) if loud else (self.merged, self.share)
        made = fit(
            coarse_model(one.hypothesis), seen, one.x, floors=(floor,), steps=steps, lines=self.lines,
            share=share, apart=False,
        )  # fmt: skip
        more = 0.0 if loud else self.constant(floor)
        return Candidate(one.hypothesis, made.x, made.normal.cost + more)


def by_force(hypothesis: Hypothesis) -> bool:
    """Whether one of its effects depends on the blow."""
    return any("blow" in placed.effect.variants for placed in hypothesis.placed)


def coarse_model(hypothesis: Hypothesis) -> Model:
    """A hypothesis as the coarse looks take it: its torques, where it has such, marched in long steps."""
    return replace(MarchedModel(hypothesis), fineness=ROUGH) if has_law(hypothesis) else hypothesis


def worst_lines(
    observations: Observations, predicted: Complex[np.ndarray, "observation line"]
) -> Int[np.ndarray, " worst"]:
    """Lines where a model is far from the measurement, the closer together the further it is."""
    weight = Weighing(ROUNDS[-1][0], np.arange(len(observations.axis))).weight(observations)
    far = robust(weight * np.abs(residual(predicted, observations.value)) ** 2).sum(axis=0)
    above = np.cumsum(np.maximum(far - np.median(far), 0.0))
    if above[-1] < 1e-6:  # in units of noise: rounding
        return np.zeros(0, dtype=int)
    return np.unique(np.searchsorted(above, (np.arange(WORST) + 0.5) / WORST * above[-1]))


def look_at(observations: Observations, more: Sequence[int] | Int[np.ndarray, " more"] = ()) -> Look:
    """Prepare the coarse looks.

    Args:
        observations: what is looked at.
        more: lines besides those that are spread over the band.
    """
    observations = unlimited(observations)
    owner = but_for_the_blow(observations)
    first = np.unique(owner, return_index=True)[1]
    share = np.bincount(owner).astype(float)
    value, variance = np.zeros((2, len(share), observations.value.shape[1]), dtype=complex)
    used = np.ones(value.shape, dtype=bool)
    np.add.at(value, owner, observations.value)
    np.add.at(variance, owner, observations.variance)
    np.logical_and.at(used, owner, observations.used)
    keep = np.zeros(len(observations), dtype=bool)
    keep[first] = True
    kept = observations.keeping(keep)
    order = np.argsort(np.argsort(first))
    back = np.argsort(order)
    merged = replace(
        kept,
        value=(value / share[:, None])[back],
        variance=(variance.real / share[:, None])[back],
        used=used[back],
    )
    lines = np.union1d(some_lines(observations, COARSE), np.array(more, dtype=int))
    look = Look(observations, merged, share[back], lines)
    look.__dict__["owner"] = order[owner]
    return look


def candidates(
    root: Hypothesis,
    set_out: Sequence[Float[np.ndarray, " before"]],
    effects: Sequence[Effect],
    look: Look,
) -> list[Candidate]:
    """Every effect in every place beside what the root holds already, at its best starts.

    Args:
        root: the hypothesis that an effect is added to.
        set_out: parameters of the root from which the search sets out; the best starts are kept of each.
        effects: to add.
        look: the coarse look.
    """
    weighing = Weighing(ROUNDS[0][0], look.lines)
    found = []
    for effect in effects:
        if effect.untestable(root.scene):
            continue
        for where in effect.places(root.scene):
            if (effect.name, where) in root.keys:
                continue
            placed = Placed(effect, where)
            hypothesis = root.and_also(placed)
            model, loud = coarse_model(hypothesis), by_force(hypothesis)
            seen = look.apart if loud else look.merged
            starts = effect.starts(root.scene, where)
            for x in set_out:
                tried = [hypothesis.start(placed, start, x) for start in starts]
                costs = [cost_of(model, one, seen, weighing) for one in tried]
                order = np.argsort(costs, kind="stable")[: 1 if has_law(hypothesis) else STARTS]
                found += [Candidate(hypothesis, tried[k], costs[k]) for k in order]
    return found


def narrowed(
    found: Sequence[Candidate], look: Look, advance: Callable[[float], None] = lambda part: None
) -> list[Candidate]:
    """The candidates that do best, one for each effect and place, the best first.

    Either all of them have torques to be marched, or none.
    """
    slow = [one for one in found if has_law(one.hypothesis)]
    todo = sorted(slow, key=lambda one: one.cost)[:MARCHED_MOST] if slow else list(found)
    rounds = MARCHED_ROUNDS if slow else ROUNDS
    for round_number, (floor, steps, keep) in enumerate(rounds):
        done = []
        for number, one in enumerate(todo):
            done.append(look.fitted(one, floor, steps))
            advance((round_number + (number + 1) / len(todo)) / len(rounds))
        todo = distinct(done)[:keep]
    return todo


def restarted(
    hypothesis: Hypothesis,
    x: Float[np.ndarray, " parameter"],
    set_out: Sequence[Float[np.ndarray, " before"]],
    look: Look,
) -> Candidate:
    """The last effect of a hypothesis started from everywhere, beside what the search set out from and a fit.

    Args:
        hypothesis: with the effect.
        x: where a fit of it ended.
        set_out: parameters of the hypothesis without the effect, from which the search sets out.
        look: the coarse look.
    """
    placed = hypothesis.placed[-1]
    starts = [
        hypothesis.start(placed, given, tail)
        for given in placed.effect.starts(hypothesis.scene, placed.where)
        for tail in (*set_out, x[: len(set_out[0])])
    ]
    weighing = Weighing(RESTARTS[0][0], look.lines)
    seen = look.apart if by_force(hypothesis) else look.merged
    costs = [cost_of(hypothesis, one, seen, weighing) for one in starts]
    best = [starts[k] for k in np.argsort(costs, kind="stable")[:TRIED]]
    todo = [Candidate(hypothesis, one, np.inf) for one in (*best, *_aside(hypothesis, x))]
    for floor, steps, keep in RESTARTS:
        todo = sorted((look.fitted(one, floor, steps) for one in todo), key=lambda one: one.cost)[:keep]
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
