"""What an explanation of modes has to gain; with a margin, so that no rounding turns it into a name."""

from __future__ import annotations

from flexmodal.diagnosis.selection.comparison import TIED, Comparison
from flexmodal.diagnosis.selection.selection import SIGNIFICANT
from flexmodal.diagnosis.selection.variants import FittedModes

MARGIN = 1.0
"""On both sides of what an explanation that was asked for by its place has to gain: inside, it is undecided,
and no rounding turns that into a name [nat]."""


def needed(comparison: Comparison[FittedModes], number: int) -> bool:
    """Whether a candidate gains enough under the first beliefs, and more than a tie under all."""
    return comparison.first_gain(number) >= SIGNIFICANT and comparison.gain(number) >= TIED


def more_than_tied(gain: float) -> bool:
    """Whether what was asked for by its place gains clearly more than a tie under the first beliefs [nat]."""
    return gain > TIED + MARGIN


def undecided(gain: float) -> bool:
    """Whether that gain is too near to a tie's for a yes or a no."""
    return abs(gain - TIED) <= MARGIN


def significant(comparison: Comparison[FittedModes]) -> bool:
    """Whether anything at all gains enough."""
    return any(needed(comparison, k) for k in range(1, len(comparison.models)))
