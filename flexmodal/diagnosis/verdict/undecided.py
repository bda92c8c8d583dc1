"""Sentences on what was compared and not added: what was asked for, and what came too near to a threshold."""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.selection.comparison import M
from flexmodal.diagnosis.selection.decision import Asked, Round, named_with_place
from flexmodal.diagnosis.verdict.modal_words import named


def refused_words(rounds: Sequence[Round[M]], asked: Asked | None) -> tuple[str, ...]:
    """Why what was asked for by its place was not added.

    Args:
        rounds: every comparison; the last of them counts.
        asked: what was asked for; None for nothing.
    """
    return tuple(
        f"Asked for, {named(one.key)} gains {gain} nats, which is a tie with nothing added."
        for k, one, gain in _not_added(rounds)
        if named_with_place(one.key, asked) and k not in rounds[-1].choice.undecided
    )


def undecided_words(rounds: Sequence[Round[M]]) -> tuple[str, ...]:
    """What may or may not have been worth adding, and what may come before what was added.

    Args:
        rounds: every comparison; the last of them counts for what was not added.
    """
    first = tuple(
        f"Whether it is {one} or {other} is undecided: both explain everything, and the second is not quite "
        "so much more plausible that it comes first."
        for one, other in _rivals(rounds)
    )
    return first + tuple(
        f"Whether {named(one.key)} is there is undecided: it gains {gain} nats, and a figure that decides is "
        "too near to its threshold for a yes or a no."
        for k, one, gain in _not_added(rounds)
        if k in rounds[-1].choice.undecided
    )


def _rivals(rounds: Sequence[Round[M]]) -> list[tuple[str, str]]:
    """What was added, and what may come before it."""
    found = [(one.comparison.models, one.choice.number, one.choice.rival) for one in rounds]
    return [
        (named(models[number].key), named(models[rival].key))
        for models, number, rival in found
        if number is not None and rival is not None
    ]


def _not_added(rounds: Sequence[Round[M]]) -> list[tuple[int, M, str]]:
    """Numbers, models and gains in words of the last comparison, if nothing was added after it."""
    if not rounds or rounds[-1].choice.number is not None:
        return []
    last = rounds[-1].comparison
    gains = ((k, f"{last.first_gain(k):.0f}".replace("-", "−")) for k in last.order if k)
    return [(k, last.models[k], gain) for k, gain in gains]
