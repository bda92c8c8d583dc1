"""A fit in stages, for a card of which little is known: first what all joints share, masses last.

From a start that is a decade off, every resonance is elsewhere, and a descent on all parameters at once bends
masses and single joints to fit a wrong peak. So

1. one factor for every stiffness and one for every damping are looked for on a grid over the prior, coarsely,
   and the best few are followed down with all joints tied together;
2. from there each joint's stiffness and damping is tried on a grid of its own, the others held, round after
   round until nothing betters; then all of them descend together, the masses held;
3. masses and inertias join, and everything is fitted to the end.

The prior counts in every stage. The fit that begins at the card is made as well, and the better one is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.evidence import Evidence, Fitted
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.poor import DECADE

KINDS = ("stiffness", "damping")
"""What is looked for before masses."""
POOR_FROM = 0.9
"""Standard deviation of the logarithm of every stiffness from which a fit goes in stages: cards whose numbers
`flexmodal card new` guessed have 1, `--poor-card` a decade."""
REACH = 2.0
"""Standard deviations of the prior that the grids go to."""
TIED, OWN = 17, 9
"""Points of the grids: of the factor of all joints, and of each joint."""
FOLLOWED = 3
"""Cells of the first grid that are followed."""
ROUNDS = 3
"""Over the joints at most."""
STEPS = 12
"""Of the descent with all joints tied."""
BETTER = 0.99
"""A fit takes the place of the one in stages from this multiple of its cost down."""

SCALE, JOINTS, MASSES = "one factor for all joints", "joint by joint", "masses and inertias too"
CARD = "the card as it came"


@dataclass(frozen=True)
class Stage:
    """What one stage reached."""

    name: str
    gap: float
    """Of the file formats, over everything that was fitted."""
    over_noise: float
    share: float
    """Part of the squared distance above the noise, as the card had it, that this stage took."""


def is_poor(evidence: Evidence) -> bool:
    """Whether the prior is so wide that a fit should go in stages, and there are FRFs for it.

    Modes alone do not say how far a model is that has none near them.

    Args:
        evidence: with its parameters.
    """
    if not isinstance(evidence, FrfEvidence | Both):
        return False
    wide = [one.deviation for one in evidence.space if one.name.startswith("stiffness.")]
    return len(wide) > 1 and min(wide) >= POOR_FROM


def staged(evidence: Evidence) -> tuple[Fitted, tuple[Stage, ...]]:
    """Fit in stages.

    Args:
        evidence: what is fitted.
    """
    at_card = np.zeros(len(evidence.space))
    ends = [_by_joint(evidence, x) for x in _scales(evidence)]
    scale, joints = min(ends, key=lambda pair: _cost(evidence, pair[1]))
    fitted, straight = evidence.fit(joints), evidence.fit()
    if straight.cost < BETTER * fitted.cost:
        return straight, _told(evidence, [(CARD, at_card), ("everything at once, from the card", straight.x)])
    ways = [(CARD, at_card), (SCALE, scale), (JOINTS, joints), (MASSES, fitted.x)]
    return fitted, _told(evidence, ways)


def _cost(evidence: Evidence, x: Float[np.ndarray, " parameter"]) -> float:
    """A coarse look at one point; modes are paired there."""
    return evidence.misfit(x, evidence.floors()[0], near=False, quick=True).cost(x)


def _of_kind(evidence: Evidence, kind: str) -> Float[np.ndarray, " parameter"]:
    """1 for every parameter of a kind."""
    return np.array([float(one.name.startswith(f"{kind}.")) for one in evidence.space])


def _grid(deviations: Float[np.ndarray, " some"], points: int) -> Float[np.ndarray, " point"]:
    reach = REACH * min(float(np.median(deviations)), DECADE)
    return np.linspace(-reach, reach, points)


def _scales(evidence: Evidence) -> list[Float[np.ndarray, " parameter"]]:
    """The best few points with one factor for each kind, each followed down."""
    low, high = evidence.space.bounds
    ties = np.array([tie for kind in KINDS if (tie := _of_kind(evidence, kind)).any()])
    deviation = np.array([one.deviation for one in evidence.space])
    grids = [_grid(deviation[tie > 0], TIED if k == 0 else OWN) for k, tie in enumerate(ties)]
    points = [np.clip(np.array(y) @ ties, low, high) for y in product(*grids)]
    costs = [_cost(evidence, x) for x in points]
    return [_followed(evidence, points[k], ties) for k in np.argsort(costs)[:FOLLOWED]]


def _followed(
    evidence: Evidence, x: Float[np.ndarray, " parameter"], ties: Float[np.ndarray, "tie parameter"]
) -> Float[np.ndarray, " parameter"]:
    """Gauss and Newton's steps along the ties alone, halved until the cost falls."""
    low, high = evidence.space.bounds
    misfit = evidence.misfit(x, evidence.floors()[0], near=False, quick=True)
    for _ in range(STEPS):
        normal = misfit.equations(x)
        curvature = ties @ (normal.curvature + np.diag(evidence.space.precision)) @ ties.T
        step = -np.linalg.lstsq(curvature, ties @ normal.gradient, rcond=None)[0] @ ties
        step = step / max(1.0, float(np.abs(step).max()))
        for _ in range(6):
            trial = np.clip(x + step, low, high)
            if misfit.cost(trial) < normal.cost:
                break
            step = step / 2
        else:
            return x
        x = trial
    return x


def _by_joint(
    evidence: Evidence, x: Float[np.ndarray, " parameter"]
) -> tuple[Float[np.ndarray, " parameter"], Float[np.ndarray, " parameter"]]:
    """Where it began, and where every joint by itself and then all of them, the masses held, end."""
    space, began = evidence.space, np.array(x)
    low, high = space.bounds
    best = _cost(evidence, x)
    for _ in range(ROUNDS):
        before = best
        for k, one in enumerate(space):
            if one.name.partition(".")[0] not in KINDS:
                continue
            for off in _grid(np.array([one.deviation]), OWN):
                trial = np.array(x)
                trial[k] = np.clip(began[k] + off, low[k], high[k])
                cost = _cost(evidence, trial)
                if cost < best:
                    best, x = cost, trial
        if best > BETTER * before:
            break
    held = {one.name: 0.0 for one in space if one.name.partition(".")[0] not in KINDS}
    return began, evidence.fit(x, quick=True, hold=held).x


def _told(evidence: Evidence, ways: Sequence[tuple[str, np.ndarray]]) -> tuple[Stage, ...]:
    """Gap and share of each stage."""
    found: list[Stage] = []
    above: list[float] = []
    for name, x in ways:
        shown = evidence.predicted(x)
        over = evidence.over_noise(shown)
        above.append(max(over**2 - 1, 0.0))
        whole = above[0] or 1.0
        share = (above[-2] - above[-1]) / whole if len(above) > 1 else 0.0
        found.append(Stage(name, evidence.gap(shown).value, over, share))
    return tuple(found)
