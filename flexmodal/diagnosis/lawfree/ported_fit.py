"""A fit of a ported model: constants first, then functions free at every line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.beginning import beginnings, origin
from flexmodal.diagnosis.lawfree.geometries import placed_best
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.profile import SETTLED, Profile, State
from flexmodal.diagnosis.lawfree.repair import repaired

FLOORS = (0.2, 0.05, 0.01)
"""Relative model error, in the order in which it is lowered."""
FOLLOWED = 2
"""Starts that are followed, beside that from nothing."""
FOLLOWED_PLACES = 4
"""The same where a port has a geometry that matters."""


def profiled(
    model: PortedModel,
    before: State | None = None,
    *,
    floors: tuple[float, ...] = FLOORS,
    steps: int = 8,
    settled: float = SETTLED,
) -> tuple[Profile, State]:
    """Fit a ported model: constants first, then free at every line.

    Args:
        model: to be fitted.
        before: where a fit with all its ports but the last ended, on the same lines.
        floors: relative model errors, lowered one after the other.
        steps: most at each of them.
        settled: relative change of the cost by a step that ends a descent once functions are free.
    """
    profile, state = mended(*begun(model, before, floor=floors[0], steps=steps))
    return finished(replace(profile, settled=settled), state, floors=floors[1:], steps=steps)


def begun(
    model: PortedModel, before: State | None = None, *, floor: float, steps: int, roughly: bool = False
) -> tuple[Profile, State]:
    """The fit at its first model error, no line repaired yet.

    Args:
        model: to be fitted.
        before: where a fit with all its ports but the last ended, on the same lines.
        floor: relative model error.
        steps: most.
        roughly: whether constants are fitted for the robot as it is, which is re-tuned beside free
            functions, or where a port's geometry matters from the best of some places alone.
    """
    profile = Profile(model, floor)
    state = profile.judged(_constant(model, before, floor, steps, roughly=roughly))
    return profile, profile.descended(state, steps).light


def mended(profile: Profile, state: State) -> tuple[Profile, State]:
    """The fit with lines repaired that ended in other minima.

    Args:
        profile: of the fit.
        state: where it has come to.
    """
    return profile, repaired(profile, state).light


def finished(
    profile: Profile, state: State, *, floors: tuple[float, ...], steps: int
) -> tuple[Profile, State]:
    """The fit at further model errors.

    Args:
        profile: at the one before.
        state: where the fit has come to.
        floors: relative model errors, lowered one after the other.
        steps: most at each of them.
    """
    for floor in floors:
        profile = replace(profile, floor=floor)
        state = repaired(profile, profile.descended(profile.judged(state), steps))
    return profile, profile.descended(state, steps).light


def _constant(model: PortedModel, before: State | None, floor: float, steps: int, *, roughly: bool) -> State:
    """The best of constants for the last port's functions; many starts are looked at, few followed.

    These at first for the robot as it is, which takes no derivatives along its parameters.
    """
    none, port, still = model.zero(), model.ports[-1], model.spans[-1].start
    starts = beginnings(model)
    if before is not None:
        none[:, :still] = before.z
        starts = [np.concatenate([before.x, origin(model)[len(before.x) :]])]
    pooled = Profile(model, floor, pooled=True, still=still)
    places = [AtParameters(model, x) for x in starts]
    plain = min((pooled.with_functions(at, none) for at in places), key=lambda one: one.cost)
    if port.kind.geometries(model.root.context, port.where):
        most = 1 if roughly else FOLLOWED_PLACES
        found = [one for at in places for one in placed_best(pooled, at, none, most, roughly=roughly)]
        found = [min((plain, *found), key=lambda one: one.cost)] if roughly else [plain, *found]
        return min((pooled.descended(one, steps) for one in found), key=lambda one: one.cost)
    started = []
    for start in port.kind.starts(model.root.context, port.where):
        z = none.copy()
        z[:, still:] = np.array(start)[:, None]
        started += [pooled.with_functions(at, z) for at in places]
    best = sorted((one for one in started if np.isfinite(one.cost)), key=lambda one: one.cost)[:FOLLOWED]
    found = [pooled.descended(one, steps, held=True) for one in (plain, *best)]
    nearest = min(found, key=lambda one: one.cost)
    return nearest if roughly else pooled.descended(nearest, steps)
