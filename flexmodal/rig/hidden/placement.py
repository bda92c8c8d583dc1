"""Putting effects in: at a place, as strong as asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.rig.effects import EFFECTS, Site, Stand
from flexmodal.rig.forms import find
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.hide import Hide, canonical
from flexmodal.rig.hidden.severity import CLOSE, Floor, noise_floor, severity_for
from flexmodal.rig.plant.build import Hidden, build
from flexmodal.rig.truth import HiddenEffect
from flexmodal.text.words import listing

NEAR = 0.2
"""Relative distance from the height asked for at which a place will do."""
_MOST_DRAWS = 10
"""Draws of what may give work, until the arm dies down."""
_MOST_PLACES = 4
"""Places tried for an effect that may choose where it sits, one height being asked for."""


@dataclass(frozen=True, eq=False)
class _Placed:
    """An effect put in."""

    site: Site
    severity: float
    height: float | None


def put_in(
    stand: Stand, wanted: Sequence[Hide], conduct: Conduct
) -> tuple[list[Hidden], tuple[HiddenEffect, ...], float | None]:
    """Put effects in, one after the other, each as if it were alone.

    Args:
        stand: the true robot and its plan.
        wanted: what to hide.
        conduct: noise, scatter and seed.

    Returns:
        Their sites, how they came out, and the noise floor where it was needed.

    Raises:
        InvalidRequest: parameters out of the range of their effect.
    """
    searched = any(item.height is not None for item in wanted)
    floor = noise_floor(stand, conduct) if searched else None
    hidden: list[Hidden] = []
    effects = []
    for number, item in enumerate(wanted):
        effect = find(item.effect, item.form)
        random = np.random.default_rng([conduct.seed, 5, number, list(EFFECTS).index(item.effect)])
        placed = _place_beside(stand, hidden, item, random, floor)
        site = placed.site
        hidden.append((effect, site))
        effects.append(
            HiddenEffect(
                effect.name, effect.form, site.where, dict(site.parameters), effect.units, placed.severity,
                placed.height, effect.catalogued,
            )
        )  # fmt: skip
    return hidden, tuple(effects), None if floor is None else floor.height


def _place_beside(
    stand: Stand, hidden: Sequence[Hidden], item: Hide, random: np.random.Generator, floor: Floor | None
) -> _Placed:
    """Place it, and draw it again as long as the arm rings up with it and what is hidden already.

    Raises:
        InvalidRequest: parameters out of their range, or an arm that rings up in each draw.
    """
    effect = find(item.effect, item.form)
    for _ in range(_MOST_DRAWS):
        placed = _place(stand, item, random, floor)
        wrong = effect.check(placed.site.parameters)
        if wrong:
            raise InvalidRequest(Fault("call", f"hide {effect.key}", wrong, "parameters in their range"))
        together = [*hidden, (effect, placed.site)]
        if not any(one.active for one, _ in together) or _dies_down(stand, together):
            return placed
    beside = listing(f"{one.key}@{site.where}" for one, site in hidden)
    found = "an arm that rings up" + (f" with {beside} beside it" if beside else "")
    allowed = "weaker effects, lower gains, another place or another seed"
    raise InvalidRequest(Fault("call", f"hide {effect.key}@{placed.site.where}", found, allowed))


def _dies_down(stand: Stand, hidden: Sequence[Hidden]) -> bool:
    """Whether every pole lies on the left, in every posture."""
    return all(
        float(np.linalg.eigvals(build(stand, posture, hidden).state_matrix).real.max()) < 0
        for posture in stand.plan.postures
    )


def _place(stand: Stand, item: Hide, random: np.random.Generator, floor: Floor | None) -> _Placed:
    """Of several places, drawn in turn, the first where the effect can stand as high as asked for.

    Where there is none, the one where it comes nearest.
    """
    effect, span = find(item.effect, item.form), item.range
    places = effect.places(stand.robot, stand.plan.points)
    order = [canonical(item.where, places)] if item.where else list(map(str, random.permutation(places)))
    if span is None or floor is None:
        return _at(stand, item, order[0], random, None, None)
    target = span[0]
    if isinstance(item.height, tuple):
        low, high = np.log(span) + np.array([CLOSE, -CLOSE])  # the search may end that far off
        target = float(np.exp(random.uniform(low, high) if low < high else (low + high) / 2))
    else:
        order, span = order[:_MOST_PLACES], (target * (1 - NEAR), target * (1 + NEAR))
    tried = []
    for where in order:
        tried.append(_at(stand, item, where, random, target, floor))
        if span[0] <= (tried[-1].height or 0.0) <= span[1]:
            return tried[-1]
    return min(tried, key=lambda one: abs(float(np.log((one.height or 1e-9) / target))))


def _at(
    stand: Stand, item: Hide, where: str, random: np.random.Generator, target: float | None,
    floor: Floor | None, again: int = _MOST_DRAWS,
) -> _Placed:  # fmt: skip
    """Draw it at a place and bring it to its height; a loop that rings up is drawn again."""
    effect = find(item.effect, item.form)
    site = Site(stand, where, {**effect.draw(stand, where, random), **item.parameters})
    severity, reached = item.severity, None
    if target is not None and floor is not None:
        severity, reached = severity_for(stand, effect, site, target, floor)
    if severity != 1:
        site = Site(stand, where, effect.scaled(site.parameters, severity))
    if effect.active and not _dies_down(stand, [(effect, site)]):
        if again:
            return _at(stand, item, where, random, target, floor, again - 1)
        reached = None
    return _Placed(site, severity, reached)
