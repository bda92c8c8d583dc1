"""Predictions of what a fit has not seen.

Postures (or points) that are named are kept out of every fit. Where none is named each is left out in turn
and predicted by a fit to the others, begun where the fit to all ended; it has to find its own optimum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.identification.evidence.evidence import Evidence, Fitted
from flexmodal.identification.gap import Gap
from flexmodal.identification.outcome import HeldOut
from flexmodal.identification.problem import IdentificationProblem


@dataclass(frozen=True)
class Apart:
    """Gaps over everything that was held out, together, and each posture and point by itself."""

    before: Gap
    after: Gap
    each: tuple[HeldOut, ...]


def predicted_apart(problem: IdentificationProblem, fitted: Fitted) -> Apart | None:
    """Gaps of card and fit over what was held out; None where nothing can be.

    Taken in turn, postures and points are both reported; together they are judged over the postures, over the
    points where there is one posture only.
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
    return Apart(found[0].before, found[0].after, tuple(held for one in found for held in one.each))


def _named(problem: IdentificationProblem, fitted: Fitted) -> Apart:
    card, folds = np.zeros(len(problem.space)), problem.whole.folds()
    away = problem.whole.keeping(np.any([folds[key] for key in problem.held_out], axis=0))
    each = (_judged(problem.whole.keeping(folds[key]), key, card, fitted.x) for key in problem.held_out)
    return Apart(away.gap(away.predicted(card)), away.gap(away.predicted(fitted.x)), tuple(each))


def _in_turn(evidence: Evidence, keys: list[tuple[str, str]], fitted: Fitted) -> Apart:
    card = np.zeros(len(evidence.space))
    folds = evidence.folds()
    after = evidence.predicted(fitted.x).copy()
    each = []
    for key in keys:
        rest = evidence.keeping(~folds[key])
        if rest.faults():
            continue
        x = rest.fit(fitted.x, warm=True).x
        part = evidence.keeping(folds[key])
        after[folds[key]] = part.predicted(x)
        each.append(_judged(part, key, card, x))
    return Apart(evidence.gap(evidence.predicted(card)), evidence.gap(after), tuple(each))


def _judged(part: Evidence, key: tuple[str, str], card: np.ndarray, x: np.ndarray) -> HeldOut:
    before, after = part.gap(part.predicted(card)), part.gap(part.predicted(x))
    return HeldOut(*key, before.value, after.value, after.noise_floor)
