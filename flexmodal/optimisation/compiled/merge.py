"""Ends of many descents told apart: written for the compiler."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

SAME = 1e-3
"""Two optima whose joints all agree within this are one [rad, m]."""


def merge(values, turning, order, group, hits):
    """Number the distinct postures, best first; whole turns apart are the same.

    Args:
        values: posture × commanded.
        turning: whether a joint turns.
        order: the postures, best first.
        group: receives for each posture in that order which distinct one it is.
        hits: receives how often each distinct one came.

    Returns:
        How many are distinct.
    """
    first = order.copy()
    count = 0
    for place in range(len(order)):
        here = values[order[place]]
        found = -1
        for g in range(count):
            same = True
            for k in range(len(here)):
                gap = here[k] - values[first[g], k]
                if turning[k]:
                    gap -= 2.0 * math.pi * math.floor(gap / (2.0 * math.pi) + 0.5)
                if abs(gap) > SAME:
                    same = False
                    break
            if same:
                found = g
                break
        if found < 0:
            found = count
            first[count] = order[place]
            hits[count] = 0
            count += 1
        group[place] = found
        hits[found] += 1
    return count
