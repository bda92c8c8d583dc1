"""Torques at the end of a step of time, found by Newton's method in all lanes side by side (`kernel`)."""

from __future__ import annotations

from typing import no_type_check

from flexmodal.diagnosis.time_domain.law import FRICTION, HARDENING, KNEE
from flexmodal.diagnosis.time_domain.law_kernel import (
    END,
    FOUND,
    FREE,
    GUESS,
    SIZE,
    SLOPE,
    hardened,
    knee,
    limits,
    rubbed,
    slow,
)

ROUNDS = 40
"""Newton steps at most in one step of time; one or two are usual."""
STUBBORN = 8
"""After so many they are halved."""
CLOSE = 1e-5
"""Newton's last correction of an elongation, over the largest so far; what it leaves is its square."""


@no_type_check  # a checker's wrapper cannot be compiled
def torques_of(kinds, w):
    """Torques at the elongations that are guessed, and their slopes.

    Args:
        kinds: code of each law.
        w: see `settle`.
    """
    for one in range(len(kinds)):
        if kinds[one] == HARDENING:
            hardened(w[one])
        elif kinds[one] == FRICTION:
            limits(w[one])
            rubbed(w[one])
        elif kinds[one] == KNEE:
            knee(w[one])
        else:
            slow(w[one])


@no_type_check
def correct(w, gain, system, change):
    """Newton's correction of elongations.

    Args:
        w: see `settle`.
        gain: see there.
        system: see there.
        change: filled, [law, lane].
    """
    count, lanes = change.shape
    for row in range(count):
        out, end, free = change[row], w[row, END], w[row, FREE]
        for b in range(lanes):
            out[b] = free[b] - end[b]
        for column in range(count):
            entry, g = system[row, column], gain[row, column]
            guess, slope = w[column, GUESS], w[column, SLOPE]
            own = 1.0 if row == column else 0.0
            for b in range(lanes):
                entry[b] = own + g[b] * slope[b]
                out[b] -= g[b] * guess[b]
    for k in range(count):  # Gauss's elimination; the diagonal is never small here
        pivot = system[k, k]
        for i in range(count):
            if i != k:
                factor = system[i, k]
                for b in range(lanes):
                    factor[b] /= pivot[b]
                for j in range(k + 1, count):
                    a, x = system[i, j], system[k, j]
                    for b in range(lanes):
                        a[b] -= factor[b] * x[b]
                a, x = change[i], change[k]
                for b in range(lanes):
                    a[b] -= factor[b] * x[b]
    for k in range(count):
        pivot, x = system[k, k], change[k]
        for b in range(lanes):
            x[b] /= pivot[b]


@no_type_check
def correct_one(gain, w, change):
    """`correct` for a single law.

    Args:
        gain: of it, [lane].
        w: its quantities, [quantity, lane].
        change: filled, [lane].
    """
    free, end, guess, slope = w[FREE], w[END], w[GUESS], w[SLOPE]
    for b in range(len(end)):
        change[b] = (free[b] - end[b] - gain[b] * guess[b]) / (1.0 + gain[b] * slope[b])


@no_type_check
def correct_two(gain, first, second, change, other):
    """`correct` for two laws, in closed form.

    Args:
        gain: of both, [law, law, lane].
        first: quantities of the first law, [quantity, lane].
        second: of the second.
        change: of the first, filled, [lane].
        other: of the second, likewise.
    """
    a, c, d, e = gain[0, 0], gain[0, 1], gain[1, 0], gain[1, 1]
    free, end, guess, slope = first[FREE], first[END], first[GUESS], first[SLOPE]
    free_too, end_too, guess_too, slope_too = second[FREE], second[END], second[GUESS], second[SLOPE]
    for b in range(len(change)):
        x = free[b] - end[b] - a[b] * guess[b] - c[b] * guess_too[b]
        y = free_too[b] - end_too[b] - d[b] * guess[b] - e[b] * guess_too[b]
        p, q = 1.0 + a[b] * slope[b], c[b] * slope_too[b]
        r, s = d[b] * slope[b], 1.0 + e[b] * slope_too[b]
        whole = p * s - q * r
        change[b] = (s * x - q * y) / whole
        other[b] = (p * y - r * x) / whole


@no_type_check
def take(w, change, active, moving, factor):
    """Correct elongations and torques of lanes that are not settled, and count those that still are not.

    Args:
        w: see `settle`.
        change: of the elongations, [law, lane].
        active: 1 for lanes that are not settled, else 0; kept up.
        moving: scratch, [lane].
        factor: of the change.
    """
    moving[:] = 0.0
    for one in range(len(change)):
        step, end, found, size = change[one], w[one, END], w[one, FOUND], w[one, SIZE]
        guess, slope = w[one, GUESS], w[one, SLOPE]
        for b in range(len(step)):
            c = factor * step[b] if active[b] > 0.0 else 0.0
            end[b] += c
            found[b] = guess[b] + slope[b] * c if active[b] > 0.0 else found[b]
            large = abs(end[b])
            large = large if large > size[b] else size[b]
            size[b] = large
            moving[b] = 1.0 if abs(c) > CLOSE * large else moving[b]
    left = 0
    for b in range(len(active)):
        active[b] *= moving[b]
        left += 1 if active[b] > 0.0 else 0
    return left


@no_type_check
def settle(kinds, w, gain, system, right, active, moving):
    """Find the elongations at the end of a step by Newton's method, for all laws at once.

    Args:
        kinds: code of each law.
        w: quantities, see `law_kernel`, [law, quantity, lane]; elongations and torques end as those found.
        gain: what torques at the end of a step take from elongations there, [law, law, lane].
        system: scratch, [law, law, lane].
        right: scratch, [law, lane].
        active: scratch, [lane].
        moving: scratch, [lane].
    """
    count = len(right)
    active[:] = 1.0
    for turn in range(ROUNDS):
        torques_of(kinds, w)
        if count == 1:
            correct_one(gain[0, 0], w[0], right[0])
        elif count == 2:
            correct_two(gain, w[0], w[1], right[0], right[1])
        else:
            correct(w, gain, system, right)
        if take(w, right, active, moving, 0.5 if turn >= STUBBORN else 1.0) == 0:
            break
