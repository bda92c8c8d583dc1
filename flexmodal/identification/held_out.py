"""Predictions of what a fit has not seen.

Postures (or points) that are named are kept out of every fit. Where none is named each is left out in turn
and predicted by a fit to the others, begun where the normal equations of the fit to all put it; it goes on to
its own optimum from there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Shaped

from flexmodal.identification.evidence.evidence import Evidence, Fitted
from flexmodal.identification.gap import Gap
from flexmodal.identification.outcome import HeldOut
from flexmodal.identification.problem import IdentificationProblem

SETTLED = 2e-5
"""A step that changes the cost of a fit without a fold relatively by less is its last."""
FAR = 0.3
"""Step along a coordinate beyond which first order is not trusted."""


@dataclass(frozen=True)
class Apart:
    """Gaps over everything that was held out, together, and each posture and point by itself."""

    before: Gap
    after: Gap
    each: tuple[HeldOut, ...]
    predicted: Shaped[np.ndarray, "observation *entry"] | None = None
    """Of everything, by fits that had not seen it, where postures were held out."""
    without: Float[np.ndarray, "posture parameter"] | None = None
    """Coordinates of the fits without each posture; None where no two were left out in turn."""


def predicted_apart(problem: IdentificationProblem, fitted: Fitted) -> Apart | None:
    """Gaps of card and fit over what was held out; None where nothing can be.

    Taken in turn, postures and points are both reported; together they are judged over the postures, over the
    points where there is one posture only.

    Args:
        problem: that was solved.
        fitted: by all that was not held out.
    """
    if problem.held_out:
        return _named(problem, fitted)
    found = []
    for kind in ("posture", "point"):
        keys = [key for key in problem.evidence.folds() if key[0] == kind]
        if len(keys) > 1:
            found.append(_in_turn(problem.evidence, keys, fitted))
    found = [one for one in found if one.each]
    if not found:
        return None
    each = tuple(held for one in found for held in one.each)
    predicted = found[0].predicted if found[0].each[0].kind == "posture" else None
    return Apart(found[0].before, found[0].after, each, predicted, found[0].without)


def _named(problem: IdentificationProblem, fitted: Fitted) -> Apart:
    card, folds = np.zeros(len(problem.space)), problem.whole.folds()
    away = problem.whole.keeping(np.any([folds[key] for key in problem.held_out], axis=0))
    each = (_judged(problem.whole.keeping(folds[key]), key, card, fitted.x) for key in problem.held_out)
    named = any(kind == "posture" for kind, _ in problem.held_out)
    predicted = problem.whole.predicted(fitted.x) if named else None
    return Apart(away.gap(away.predicted(card)), away.gap(away.predicted(fitted.x)), tuple(each), predicted)


def _in_turn(evidence: Evidence, keys: list[tuple[str, str]], fitted: Fitted) -> Apart:
    card = np.zeros(len(evidence.space))
    folds = evidence.folds()
    after = evidence.predicted(fitted.x).copy()
    each, without = [], []
    for key in keys:
        rest = evidence.keeping(~folds[key])
        if rest.faults():
            continue
        x = rest.fit(_without(evidence, fitted, folds[key]), warm=True, settled=SETTLED).x
        part = evidence.keeping(folds[key])
        after[folds[key]] = part.predicted(x)
        each.append(_judged(part, key, card, x))
        without.append(x)
    moved = np.array(without) if len(without) > 1 and keys[0][0] == "posture" else None
    return Apart(evidence.gap(evidence.predicted(card)), evidence.gap(after), tuple(each), after, moved)


def _without(
    evidence: Evidence, fitted: Fitted, fold: Bool[np.ndarray, " observation"]
) -> Float[np.ndarray, " parameter"]:
    """Where a fit without some observations ends, to first order.

    Normal equations are sums over observations: without some of them they follow from the fit to all.
    """
    normal, space = fitted.normal, evidence.space
    if normal.blocks is None:
        return fitted.x
    curvature = normal.curvature - normal.blocks[fold].sum(axis=0) + np.diag(space.precision)
    gradient = normal.gradient - normal.scores[fold].sum(axis=0)
    low, high = space.bounds
    free = ~(((fitted.x <= low) & (gradient > 0)) | ((fitted.x >= high) & (gradient < 0)))
    step = np.zeros(len(space))
    step[free] = -np.linalg.pinv(curvature[np.ix_(free, free)], hermitian=True) @ gradient[free]
    if not np.all(np.isfinite(step)) or np.abs(step).max(initial=0.0) > FAR:
        return fitted.x
    return np.clip(fitted.x + step, low, high)


def _judged(part: Evidence, key: tuple[str, str], card: np.ndarray, x: np.ndarray) -> HeldOut:
    before, after = part.gap(part.predicted(card)), part.gap(part.predicted(x))
    return HeldOut(*key, before.value, after.value, after.noise_floor)
