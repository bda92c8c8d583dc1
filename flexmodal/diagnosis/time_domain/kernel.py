"""The loop of an integration in time: plain functions of numbers and arrays, compiled by `integration`.

Some blows, on one system or several, are carried on and settled side by side in lanes, so that they fill
vector registers. How many must not be known when this is compiled: loops over them would be written out.
No lane feels another, each is settled by itself.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np

from flexmodal.diagnosis.time_domain.law import FRICTION
from flexmodal.diagnosis.time_domain.law_kernel import (
    BEFORE,
    END,
    FOUND,
    FREE,
    GIVEN,
    HELD,
    OLD,
    QUANTITIES,
    stuck_of,
)
from flexmodal.diagnosis.time_domain.settle_kernel import settle

LANES = (8, 16, 32)
"""Blows that are integrated together, as a tile: as many as hold all, or the most."""


@no_type_check  # a checker's wrapper cannot be compiled
def coast(turn, cross, carried, rows, now, base, w):
    """Bring states to the end of a step, as the torques held so far leave them.

    The first two laws go along with the states: what a loop over a few lanes takes is mostly its beginning.

    Args:
        turn: what of each coordinate comes of itself, [state, lane].
        cross: what comes of the other one of its pair, likewise.
        carried: see `integrate`, [law, state, lane].
        rows: see there, likewise.
        now: the state without what the torques at its time do at once, [state, lane].
        base: added to, the same one step later.
        w: quantities of the laws, see `law_kernel`, [law, quantity, lane]; what is free is filled.
    """
    (states, lanes), count = now.shape, len(w)
    for one in range(count):
        w[one, FREE] = 0.0
    second = min(1, count - 1)
    held, free, held_too, free_too = w[0, HELD], w[0, FREE], w[second, HELD], w[second, FREE]
    for i in range(states):
        a, c, x, y, out, f, r = turn[i], cross[i], now[i], now[i ^ 1], base[i], carried[0, i], rows[0, i]
        if count == 1:
            for b in range(lanes):
                at = out[b] + a[b] * x[b] + c[b] * y[b] - f[b] * held[b]
                out[b] = at
                free[b] += r[b] * at
            continue
        f_too, r_too = carried[1, i], rows[1, i]
        for b in range(lanes):
            at = out[b] + a[b] * x[b] + c[b] * y[b] - f[b] * held[b] - f_too[b] * held_too[b]
            out[b] = at
            free[b] += r[b] * at
            free_too[b] += r_too[b] * at
    for one in range(2, count):
        rest = w[one, HELD]
        for i in range(states):
            f, out = carried[one, i], base[i]
            for b in range(lanes):
                out[b] -= f[b] * rest[b]
    if count > 2:  # what the first two went by was not the whole
        for one in range(count):
            free = w[one, FREE]
            free[:] = 0.0
            for i in range(states):
                r, x = rows[one, i], base[i]
                for b in range(lanes):
                    free[b] += r[b] * x[b]


@no_type_check
def expect(gain, w):
    """Guess elongations at the end of a step from torques that go on as in the last one.

    Args:
        gain: see `settle`.
        w: see there; elongations at the end are filled.
    """
    for row in range(len(w)):
        end, free = w[row, END], w[row, FREE]
        a, held, before = gain[row, 0], w[0, HELD], w[0, BEFORE]
        for b in range(len(end)):
            end[b] = free[b] - a[b] * (2.0 * held[b] - before[b])
        for column in range(1, len(w)):
            a, held, before = gain[row, column], w[column, HELD], w[column, BEFORE]
            for b in range(len(end)):
                end[b] -= a[b] * (2.0 * held[b] - before[b])


@no_type_check
def go_on(w):
    """Make what was found at the end of a step what is known at the beginning of the next.

    Args:
        w: quantities of a law, [quantity, lane].
    """
    old, end, before, held, found = w[OLD], w[END], w[BEFORE], w[HELD], w[FOUND]
    for b in range(len(end)):
        old[b] = end[b]
        before[b] = held[b]
        held[b] = found[b]


@no_type_check
def integrate(turn, cross, carried, late, rows, gain, kinds, parameters, push, torque, last):
    """Integrate blows, tile by tile.

    Args:
        turn: what of each coordinate comes of itself in a step, [tile, state, lane].
        cross: what comes of the other one of its pair, likewise.
        carried: what torques that end a step do to the state one step later, [tile, law, state, lane].
        late: to the state at once, likewise.
        rows: elongations by the state, speeds for laws by speed, likewise.
        gain: elongations by torques at once, [tile, law, law, lane].
        kinds: code of each law.
        parameters: of the laws, [tile, law, 8, lane], see `law`; of friction speed in elongation per step and
            time in steps.
        push: what the hammer adds in each step until its pulse is over, [tile, step, state, lane].
        torque: filled, [tile, lane, law, time]; zero at the start.
        last: filled with the state at the end, [tile, state, lane].
    """
    tiles, count, states, lanes = rows.shape
    now, base = np.zeros((states, lanes)), np.zeros((states, lanes))
    w, right, scratch = (
        np.zeros((count, QUANTITIES, lanes)), np.zeros((count, lanes)), np.zeros((count, count, lanes)),
    )  # fmt: skip
    active, moving = np.zeros(lanes), np.zeros(lanes)
    for tile in range(tiles):
        now[:] = 0.0
        w[:] = 0.0
        w[:, GIVEN:] = parameters[tile]
        for k in range(torque.shape[3] - 1):
            if k < push.shape[1]:
                base[:] = push[tile, k]
            else:
                base[:] = 0.0
            coast(turn[tile], cross[tile], carried[tile], rows[tile], now, base, w)
            expect(gain[tile], w)
            settle(kinds, w, gain[tile], scratch, right, active, moving)
            for one in range(count):
                go_on(w[one])
                if kinds[one] == FRICTION:
                    stuck_of(w[one])
                for b in range(lanes):
                    torque[tile, b, one, k + 1] = w[one, HELD, b]
            now, base = base, now
        for one in range(count):
            for i in range(states):
                for b in range(lanes):
                    now[i, b] -= late[tile, one, i, b] * w[one, HELD, b]
        last[tile] = now
