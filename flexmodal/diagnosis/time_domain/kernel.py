"""The loop of an integration in time: plain functions of numbers and arrays, compiled by `integration`.

`LANES` blows on one system are integrated side by side, so that the products with its matrices fill a vector
register.
Codes of the laws are those of `law`: 0 hardening, 1 friction.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np

LANES = 4
"""Blows that are integrated together."""
ROUNDS = 40
"""Newton steps at most in one step of time; two are usual."""
STUBBORN = 8
"""After so many they are halved."""
CLOSE = 1e-6
"""Newton's last correction of an elongation, over the largest so far; what it leaves is its square."""


@no_type_check  # a checker's wrapper cannot be compiled
def law(kind, first, second, third, old, new, memory):
    """Torque at an elongation and its derivative.

    Args:
        kind: code of the law.
        first: its parameters.
        second: likewise.
        third: likewise.
        old: elongation one step ago.
        new: elongation now.
        memory: torque one step ago.
    """
    if kind == 0:
        ratio = new / second
        ratio *= ratio
        part = ratio / (1.0 + ratio)
        return first * new * part, first * part * (3.0 + ratio) / (1.0 + ratio)
    moved = new - old
    limit = first if moved >= 0.0 else -first
    share = max(1.0 - memory / limit, 0.0)  # of the way to sliding that is left
    way = second * abs(moved) / first
    power = 1.0 - third
    if abs(power) < 1e-9:
        share *= np.exp(-way)
        return limit - limit * share, second * share
    left = share**power - power * way if share > 0.0 else 0.0
    if left <= 0.0:
        return limit, 0.0
    share = left ** (1.0 / power)
    return limit - limit * share, second * share / left


@no_type_check  # a checker's wrapper cannot be compiled
def integrate(phi, carried, late, rows, kinds, parameters, system, push, torque, last):
    """Integrate blows, `LANES` of one system together.

    Args:
        phi: exp(A h), [system, state, state].
        carried: what torques that end a step do to the state one step later, [system, law, state].
        late: to the state at once.
        rows: elongations by the state, [system, law, state].
        kinds: code of each law.
        parameters: of the laws, [system, law, 3].
        system: which one each group of blows strikes, [group].
        push: what the hammer adds in each step until its pulse is over, [group, step, state, lane].
        torque: filled, [group, lane, law, time]; zero at the start.
        last: filled with the state at the end, [group, lane, state].
    """
    count, states = rows.shape[1], rows.shape[2]
    steps, struck = torque.shape[3] - 1, push.shape[1]
    now = np.zeros((states, LANES))
    base = np.zeros((states, LANES))
    gain = np.zeros((count, count))
    old = np.zeros((count, LANES))
    end = np.zeros((count, LANES))
    free = np.zeros((count, LANES))
    size = np.zeros((count, LANES))
    guess = np.zeros((count, LANES))
    held = np.zeros((count, LANES))
    for group in range(len(system)):
        m = system[group]
        a, before, after, seen = phi[m], carried[m], late[m], rows[m]
        now[:] = 0.0  # the state without what the torques at the end of the last step do at once
        old[:] = 0.0
        size[:] = 0.0
        held[:] = 0.0
        for one in range(count):  # how torques at the end of a step move elongations there
            for other in range(count):
                gain[one, other] = np.sum(seen[one] * after[other])
        for k in range(steps):
            for i in range(states):
                b0 = b1 = b2 = b3 = 0.0
                for j in range(states):
                    p = a[i, j]
                    b0 += p * now[j, 0]
                    b1 += p * now[j, 1]
                    b2 += p * now[j, 2]
                    b3 += p * now[j, 3]
                base[i, 0], base[i, 1], base[i, 2], base[i, 3] = b0, b1, b2, b3
            for one in range(count):
                for i in range(states):
                    p = before[one, i]
                    for b in range(LANES):
                        base[i, b] -= p * held[one, b]
            if k < struck:
                for i in range(states):
                    for b in range(LANES):
                        base[i, b] += push[group, k, i, b]
            for one in range(count):
                for b in range(LANES):
                    free[one, b] = 0.0
                for i in range(states):
                    p = seen[one, i]
                    for b in range(LANES):
                        free[one, b] += p * base[i, b]
                for b in range(LANES):
                    end[one, b] = free[one, b]
                    guess[one, b] = held[one, b]
                for other in range(count):
                    p = gain[one, other]
                    for b in range(LANES):
                        end[one, b] -= p * held[other, b]
            for b in range(LANES):
                for turn in range(ROUNDS):
                    settled = True
                    for one in range(count):
                        value, slope = law(
                            kinds[one], parameters[m, one, 0], parameters[m, one, 1], parameters[m, one, 2],
                            old[one, b], end[one, b], held[one, b],
                        )  # fmt: skip
                        own = gain[one, one]
                        miss = end[one, b] - free[one, b] + own * value
                        for other in range(count):
                            if other != one:
                                miss += gain[one, other] * guess[other, b]
                        change = -miss / (1.0 + own * slope)
                        if turn >= STUBBORN:
                            change *= 0.5
                        end[one, b] += change
                        guess[one, b] = value + slope * change
                        size[one, b] = max(size[one, b], abs(end[one, b]))
                        if abs(change) > CLOSE * size[one, b]:
                            settled = False
                    if settled:
                        break
            for one in range(count):
                for b in range(LANES):
                    old[one, b] = end[one, b]
                    held[one, b] = guess[one, b]
                    torque[group, b, one, k + 1] = guess[one, b]
            now, base = base, now
        for i in range(states):
            for b in range(LANES):
                last[group, b, i] = now[i, b]
                for one in range(count):
                    last[group, b, i] -= after[one, i] * held[one, b]
