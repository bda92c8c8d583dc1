"""Several starts, and how many distinct optima they end in."""

from __future__ import annotations

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.evidence import Evidence, Fitted
from flexmodal.identification.outcome import Optimum

MOST = 1000
APART = 3.0
"""Optima that lie more standard errors apart, in the metric of the fit's curvature, are two."""
WIDEST = 0.5
"""Standard deviation of starts along a coordinate with a wider prior or none."""
NO_BETTER = 10.0
"""Times the best quick cost beyond which a start is not followed to its end."""


def search(evidence: Evidence, *, starts: int = 1, seed: int = 0) -> tuple[Fitted, tuple[Optimum, ...]]:
    """Fit from the card and from points drawn from the prior.

    Every start is fitted to every so many lines with a high floor; those that come near the best are fitted
    to the end.

    Args:
        evidence: what is fitted.
        starts: how many.
        seed: of the draws.

    Returns:
        The best fit and the distinct optima, best first.

    Raises:
        InvalidRequest: a number of starts below 1 or beyond reason.
    """
    if not 1 <= starts <= MOST:
        raise InvalidRequest(Fault("call", "starts", str(starts), f"1 to {MOST}"))
    if starts == 1:
        fitted = evidence.fit()
        return fitted, (Optimum(tuple(fitted.x.tolist()), fitted.cost, 1),)
    quick = [evidence.fit(start, quick=True) for start in _starts(evidence, starts, seed)]
    best = min(one.cost for one in quick)
    finals: list[tuple[Fitted, int]] = []
    seen: list[tuple[Fitted, int]] = []  # quick optimum, number of its final one
    for one in quick:
        known = next((n for other, n in seen if _same(one, other)), None)
        if known is None and one.cost <= NO_BETTER * best:
            full = evidence.fit(one.x)
            known = next((n for n, (other, _) in enumerate(finals) if _same(full, other)), None)
            if known is None:
                finals.append((full, 0))
                known = len(finals) - 1
        if known is not None:
            seen.append((one, known))
            finals[known] = (finals[known][0], finals[known][1] + 1)
    order = sorted(finals, key=lambda item: item[0].cost)
    optima = tuple(Optimum(tuple(f.x.tolist()), f.cost, hits) for f, hits in order)
    return order[0][0], optima


def _starts(evidence: Evidence, count: int, seed: int) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    low, high = evidence.space.bounds
    spread = np.array([min(p.deviation, WIDEST) for p in evidence.space])
    drawn = [np.clip(random.normal(0, spread), low, high) for _ in range(count - 1)]
    return [np.zeros(len(evidence.space)), *drawn]


def _same(one: Fitted, other: Fitted) -> bool:
    """Whether two fits ended in one place, judged by the curvature there."""
    away = one.x - other.x
    metric = one.normal.curvature + np.diag(np.full(len(away), 1e-12))
    return bool(away @ metric @ away <= APART**2 * len(away))
