"""The first round over all ports: fits of few steps to a part of the data, and which ports go on."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Complex

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree.model import Unknown
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.ported_fit import mended
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.identification import Observations

FLOORS = (0.2, 0.05)
"""Model errors."""
LATE_FLOOR, LATE_OVER_NOISE = 0.01, 4.0
"""The only one where little is missing: at most, and in units of the model error at which fits are judged."""
STEPS = 3
"""Most at each model error."""
LINES = 2
"""It takes every so many of the lines."""
FRFS = 48
"""And about so many of the FRFs, drawn by chance from each posture."""
HOPELESS = 16.0
"""Times the best reduced χ² at the first model error; ports beyond it are not followed to the next, but the
best of each kind. On 26 campaigns looked at, no port that came to stand among the best was beyond 10."""
MOST_NEAR = 16
"""And so many at most, but the best of each kind; on 61 campaigns looked at, the port that came to be the
best was among the first eight."""
GAINS = 0.3
"""Part of what the best port takes that others have to take, where little is missing."""
NOTHING_GAINED = 1.2
"""Times by which the best port lowers the reduced χ² at least where little is missing, for more than the
fewest to go on."""
WELL_PLACED = 3
"""Ports whose geometry matters that are followed from several places, those that do best from one."""
TORQUES = 2
"""Torques that depend on the blow that are fitted well. Of eight campaigns with one that were looked at, the
true one came first with half of the next one's reduced χ² and less."""
UNMENDED = 2.0
"""So many times as far behind, and as many, before lines that ended in other minima are repaired."""
FEWEST, KEPT = 2, 6
"""Ports that go on at least, and while they are not far behind."""
FAR = 10.0
"""Times the best reduced χ² (its root 3.2): on 26 campaigns looked at, no port farther behind after the
first round came to within two and a half times the best misfit, but one of almost the same function."""
WITHIN = 3.0
"""And others up to so many times the misfit of the best."""
MOST_KEPT = 10
MOST_ALIKE, EXPLAINED = 20, 1.5
"""More go on where one place explains everything, to this reduced χ², and others as well: a mass at the end
of a link is one on the next link, and neither is to be left out for want of room."""
BEST_OF_KIND, BEST_OF_SEVERAL = 15.0, 2.0
"""And of each kind the best up to so many times: a coupling of two joints is near its end after a few steps,
the link between them that does the same, with its many hinges, is not. The second where no place explains
everything alone, but for readings, which take little time: beside other effects they are late to show."""
ALIKE = 1.25
"""Ports whose misfits are within this factor cannot be told apart; the one with the fewest unknowns is taken.

Tuned on twelve campaigns of the rig with a single effect: the next best place had at least 1.4 times the
misfit where its port does not contain that of the true one. How sharply was not measured."""


Fit = tuple[Profile, State]


def on_all(z: Unknown, lines: int) -> Complex[np.ndarray, "cell function every"]:
    """Functions on every `LINES`th of some lines, on all of them by straight lines.

    Args:
        z: as the first round found them.
        lines: how many there are.
    """
    known = np.arange(z.shape[-1]) * LINES
    every = np.arange(lines)
    flat = z.reshape(-1, z.shape[-1])
    found = [np.interp(every, known, row.real) + 1j * np.interp(every, known, row.imag) for row in flat]
    return np.array(found).reshape(*z.shape[:-1], lines)


def thinned(observations: Observations) -> Observations:
    """About `FRFS` of them, the same number of each posture, always the same ones."""
    stride, chance = len(observations) // FRFS, np.random.default_rng(0)
    if stride < 2:
        return observations
    keep = np.zeros(len(observations), dtype=bool)
    for posture in np.unique(observations.posture):
        here = chance.permutation(np.flatnonzero(observations.posture == posture))
        keep[here[: -(-len(here) // stride)]] = True
    return observations.keeping(keep)


def misfit_of(fit: Fit) -> float:
    """Its reduced χ²."""
    profile, state = fit
    return profile.reduced(state.residual)


def with_places(
    begins: Sequence[tuple[Port, Fit]], context: Context, again: Callable[[Port], Fit]
) -> list[tuple[Port, Fit]]:
    """With those ports followed from several places that do best from one, where their geometry matters.

    Args:
        begins: ports and their fits, from one place each.
        context: of the diagnosis.
        again: fits a port from several places.
    """
    placed = [(misfit_of(fit), port) for port, fit in begins if port.kind.geometries(context, port.where)]
    best = [port for _, port in sorted(placed, key=lambda one: one[0])[:WELL_PLACED]]
    found = {port.key: fit for port, fit in zip(best, parallel_map(again, best), strict=True)}
    return [(port, found.get(port.key, fit)) for port, fit in begins]


def near(begins: Sequence[tuple[Port, Fit]], without: float | None = None) -> list[tuple[Port, Fit]]:
    """Of all ports at the first model error those that are not hopeless, and of each kind the best.

    Args:
        begins: ports and their fits, whose lines are not repaired yet.
        without: reduced χ² without any port where little is left; then those that take a part of it at all.
    """
    going = _within(UNMENDED * HOPELESS, UNMENDED * MOST_NEAR, begins)
    repaired = parallel_map(lambda one: mended(*one[1]), going)
    found = _within(HOPELESS, MOST_NEAR, list(zip([port for port, _ in going], repaired, strict=True)))
    if without is None or not found:
        return found
    least = without - GAINS * (without - misfit_of(found[0][1]))
    return [one for k, one in enumerate(found) if k < FEWEST or misfit_of(one[1]) <= least]


def _within(times: float, most: float, begins: Sequence[tuple[Port, Fit]]) -> list[tuple[Port, Fit]]:
    """The first ones up to so many times the best misfit, and of each kind the best, in order."""
    judged = [(misfit_of(fit), port, fit) for port, fit in begins]
    order = sorted(judged, key=lambda one: one[0])
    best: dict[str, Port] = {}
    for _, port, _ in order:
        best.setdefault(port.kind.name, port)
    limit = times * order[0][0] if order else 0.0
    return [
        (port, fit)
        for k, (misfit, port, fit) in enumerate(order)
        if (misfit <= limit and k < most) or best[port.kind.name] is port
    ]


def kept(first: Sequence[tuple[float, Port]], without: float | None = None) -> list[Port]:
    """Of all ports with their misfits, the best first, those that go on.

    Args:
        first: reduced χ² and ports.
        without: reduced χ² without any port where little is missing; only the fewest where no port gains.
    """
    if without is not None and without < NOTHING_GAINED * first[0][0]:
        return [port for _, port in first[:FEWEST]]
    explained = first[0][0] < EXPLAINED
    limit = WITHIN * first[0][0]
    alike = ALIKE**2 * first[0][0] if explained else 0.0
    going = [
        port
        for k, (misfit, port) in enumerate(first[:MOST_ALIKE])
        if k < FEWEST
        or (k < KEPT and misfit < FAR * first[0][0])
        or (k < MOST_KEPT and misfit < limit)
        or misfit < alike
    ]
    kinds = {port.kind.name for port in going}
    for misfit, port in first:
        wide = explained or port.kind.reads is not None
        far = (BEST_OF_KIND if wide else BEST_OF_SEVERAL) * first[0][0]
        if misfit < far and port.kind.name not in kinds:
            going.append(port)
            kinds.add(port.kind.name)
    return going
