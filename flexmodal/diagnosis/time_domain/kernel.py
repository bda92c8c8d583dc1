"""The loop of an integration in time: plain functions of numbers and arrays, compiled by `integration`.

`LANES` blows on one system are integrated side by side, so that the products with its matrices fill a vector
register.
Codes of the laws are those of `law`: 0 hardening, 1 friction, 2 friction by speed.
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
def law(kind, p, old, new, memory):
    """Torque at an elongation and its derivative, the limit of friction taken as that of the step's speed.

    Where a torque falls back to a lower limit its derivative is given as 0: the equations of a step then stay
    far from singular, and settle all the same.

    Args:
        kind: code of the law.
        p: its five parameters, the last one of friction in elongation per step.
        old: elongation one step ago; of a law by speed that speed, likewise below.
        new: elongation now.
        memory: torque one step ago.
    """
    if kind == 2:
        share = np.tanh(new / p[1])
        return p[0] * share, p[0] / p[1] * (1.0 - share * share)
    if kind == 0:
        ratio = (new + p[2]) / p[1]
        ratio *= ratio
        part = ratio / (1.0 + ratio)
        torque = p[0] * (new + p[2]) * part + p[3] * new
        if p[2] != 0.0:
            rest = (p[2] / p[1]) ** 2
            torque -= p[0] * p[2] * rest / (1.0 + rest)
        return torque, p[0] * part * (3.0 + ratio) / (1.0 + ratio) + p[3]
    moved = new - old
    most = p[0]
    if p[3] > 0.0:
        most *= 1.0 + p[3] * np.exp(-((moved / p[4]) ** 2))
    limit = most if moved >= 0.0 else -most
    share = 1.0 - memory / limit  # of the way to sliding that is left; negative where the limit has fallen
    way = p[1] * abs(moved) / most
    power = 1.0 - p[2]
    if abs(power) < 1e-9:
        share *= np.exp(-way)
        return limit - limit * share, max(p[1] * share, 0.0)
    size = abs(share)
    left = size**power - power * way if size > 0.0 else 0.0
    if left <= 0.0:
        return limit, 0.0
    size = left ** (1.0 / power)
    if share < 0.0:
        size = -size
    return limit - limit * size, max(p[1] * size / left, 0.0)


@no_type_check
def coast(phi, carried, rows, gain, now, held, base, free, end):
    """Bring a state to the end of a step, as the torques held so far leave it.

    Args:
        phi: see `integrate`, of one system as all below.
        carried: see there.
        rows: see there.
        gain: what torques at the end of a step take from elongations there, [law, law].
        now: the state without what the torques at its time do at once, [state, lane].
        held: those torques, [law, lane].
        base: filled, the same one step later.
        free: filled, elongations one step later without torques there, [law, lane].
        end: filled, those with the torques held.
    """
    count, states = rows.shape
    for i in range(states):
        b0 = b1 = b2 = b3 = 0.0
        for j in range(states):
            p = phi[i, j]
            b0 += p * now[j, 0]
            b1 += p * now[j, 1]
            b2 += p * now[j, 2]
            b3 += p * now[j, 3]
        base[i, 0] += b0
        base[i, 1] += b1
        base[i, 2] += b2
        base[i, 3] += b3
    for one in range(count):
        for i in range(states):
            p = carried[one, i]
            for b in range(LANES):
                base[i, b] -= p * held[one, b]
    for one in range(count):
        for b in range(LANES):
            free[one, b] = 0.0
        for i in range(states):
            p = rows[one, i]
            for b in range(LANES):
                free[one, b] += p * base[i, b]
        for b in range(LANES):
            end[one, b] = free[one, b]
        for other in range(count):
            p = gain[one, other]
            for b in range(LANES):
                end[one, b] -= p * held[other, b]


@no_type_check
def eliminate(system, count):
    """Solve a linear system in place, by Gauss's elimination; its diagonal is never small here.

    Args:
        system: matrix and, in the last column, right side; that ends as the solution, [law, law + 1].
        count: of unknowns.
    """
    for k in range(count):
        for i in range(count):
            if i != k:
                factor = system[i, k] / system[k, k]
                for j in range(k, count):
                    system[i, j] -= factor * system[k, j]
                system[i, count] -= factor * system[k, count]
    for k in range(count):
        system[k, count] /= system[k, k]


@no_type_check
def settle(kinds, parameters, gain, free, old, held, end, guess, size, system):
    """Find the elongations at the end of a step by Newton's method, for all laws at once.

    Args:
        kinds: code of each law.
        parameters: of the laws, [law, 5].
        gain: see `coast`.
        free: see there.
        old: elongations at the beginning, [law, lane].
        held: torques there, [law, lane].
        end: elongations, from a first guess to the last.
        guess: torques, likewise.
        size: the largest elongations so far, kept up.
        system: scratch, matrix, right side and slopes, [law, law + 2].
    """
    count = len(kinds)
    for b in range(LANES):
        for turn in range(ROUNDS):
            for one in range(count):
                guess[one, b], system[one, count + 1] = law(
                    kinds[one], parameters[one], old[one, b], end[one, b], held[one, b]
                )
            for one in range(count):
                miss = free[one, b] - end[one, b]
                for other in range(count):
                    system[one, other] = gain[one, other] * system[other, count + 1]
                    miss -= gain[one, other] * guess[other, b]
                system[one, one] += 1.0
                system[one, count] = miss
            eliminate(system, count)
            settled = True
            for one in range(count):
                change = system[one, count]
                if turn >= STUBBORN:
                    change *= 0.5
                end[one, b] += change
                guess[one, b] += system[one, count + 1] * change
                size[one, b] = max(size[one, b], abs(end[one, b]))
                if abs(change) > CLOSE * size[one, b]:
                    settled = False
            if settled:
                break


@no_type_check
def integrate(phi, carried, late, rows, kinds, parameters, system, push, torque, last):
    """Integrate blows, `LANES` of one system together.

    Args:
        phi: exp(A h), [system, state, state].
        carried: what torques that end a step do to the state one step later, [system, law, state].
        late: to the state at once.
        rows: elongations by the state, speeds for laws by speed, [system, law, state].
        kinds: code of each law.
        parameters: of the laws, [system, law, 5], see `law`.
        system: which one each group of blows strikes, [group].
        push: what the hammer adds in each step until its pulse is over, [group, step, state, lane].
        torque: filled, [group, lane, law, time]; zero at the start.
        last: filled with the state at the end, [group, lane, state].
    """
    count, states = rows.shape[1], rows.shape[2]
    now, base = np.zeros((states, LANES)), np.zeros((states, LANES))
    gain = np.zeros((count, count))
    old, end, free = np.zeros((count, LANES)), np.zeros((count, LANES)), np.zeros((count, LANES))
    size, guess, held = np.zeros((count, LANES)), np.zeros((count, LANES)), np.zeros((count, LANES))
    scratch = np.zeros((count, count + 2))
    for group in range(len(system)):
        m = system[group]
        now[:] = 0.0
        old[:] = 0.0
        size[:] = 0.0
        held[:] = 0.0
        for one in range(count):
            for other in range(count):
                gain[one, other] = np.sum(rows[m, one] * late[m, other])
        for k in range(torque.shape[3] - 1):
            if k < push.shape[1]:
                base[:] = push[group, k]
            else:
                base[:] = 0.0
            coast(phi[m], carried[m], rows[m], gain, now, held, base, free, end)
            guess[:] = held
            settle(kinds, parameters[m], gain, free, old, held, end, guess, size, scratch)
            old[:] = end
            held[:] = guess
            for one in range(count):
                for b in range(LANES):
                    torque[group, b, one, k + 1] = guess[one, b]
            now, base = base, now
        for i in range(states):
            for b in range(LANES):
                last[group, b, i] = now[i, b]
                for one in range(count):
                    last[group, b, i] -= late[m, one, i] * held[one, b]
