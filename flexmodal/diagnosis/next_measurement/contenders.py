"""Which explanations another measurement would have to tell apart."""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.comparison import TIE, Comparison, M
from flexmodal.diagnosis.selection.decision import Round

MOST = 4
"""Explanations told apart at once."""
OF_UNKNOWN = 3
"""The same where none of them is good enough."""


def contenders(
    rounds: Sequence[Round[M]], rivals: tuple[M, M] | None, *, open_: bool
) -> list[tuple[M, float]]:
    """Models and their weights, the two that are told first; fewer than two where one stands alone.

    What is tied, as far as it makes predictions of its own, and what came nearest after it: the right one may
    be among those, as a fit to few data is easily bettered. Where nothing is good enough, what came nearest
    alone: none of it is right, but what tells it apart tells where to look.

    Args:
        rounds: every comparison.
        rivals: what was added, or is best, and what it is tied with.
        open_: whether the answer is that something is missing and nobody knows what.
    """
    told = [(one.comparison, one.choice.number) for one in rounds]
    if rivals is not None:
        found = [one for one, _ in told if all(any(m is rival for m in one.models) for rival in rivals)]
        if not found or found[-1].beliefs:  # a comparison that was taken back is not among them
            return [(one, 1.0) for one in rivals]
        return _weighed(found[-1], rivals, found[-1].tied)
    for comparison, number in reversed(told):
        if comparison.beliefs:
            break
        able = _able(comparison, comparison.tied)
        if number is None and not open_ and 0 not in able:  # nothing is added, though it is not the likeliest
            able.append(0)
        if len(able) > 1:
            return _weighed(comparison, (), able)
    if open_ and told:
        comparison = told[-1][0]
        ranked = sorted(range(len(comparison.models)), key=lambda k: -comparison.scores[k])
        return [(comparison.models[k], 1.0) for k in _able(comparison, ranked)[:OF_UNKNOWN]]
    return []


def _able(comparison: Comparison[M], numbers: Sequence[int]) -> list[int]:
    return [k for k in numbers if comparison.models[k].key[0] != UNSTRUCTURED]


def _weighed(comparison: Comparison[M], first: Sequence[M], tied: Sequence[int]) -> list[tuple[M, float]]:
    """Tied models by their probability, some of them first, and others behind them."""
    every = dict.fromkeys((*tied, *comparison.order))
    models = [comparison.models[k] for k in _able(comparison, list(every))]
    ordered = [*first, *(one for one in models if not any(one is other for other in first))]
    index = {id(one): k for k, one in enumerate(comparison.models)}
    return [(one, max(float(comparison.probability[index[id(one)]]), TIE)) for one in ordered[:MOST]]
