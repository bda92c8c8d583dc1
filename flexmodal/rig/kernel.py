"""The inner loop of a non-linear plant, compiled. Import it only where it runs: numba is slow to load.

Codes of the laws are those of `plant`: 0 hardening, 1 friction, 2 backlash.
"""

from __future__ import annotations

from typing import no_type_check

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)
@no_type_check  # a checker's wrapper cannot be compiled
def law(kind, p, old, new, memory):
    """Force of one element at elongation `new`, coming from `old`, and its new memory.

    Args:
        kind: code of the law.
        p: its three parameters.
        old: elongation one step ago.
        new: elongation now.
        memory: force of the friction one step ago.
    """
    if kind == 0:
        ratio = new / p[1]
        return p[0] * new * ratio * ratio / (1.0 + ratio * ratio), 0.0
    if kind == 1:
        moved = new - old
        limit = p[0] if moved >= 0 else -p[0]
        force = limit + (memory - limit) * np.exp(-p[1] * abs(moved) / p[0])
        return force, force
    pressed = p[0] * new + p[2]
    gap = p[0] * p[1]
    held = pressed if pressed > 0 else (pressed + gap if pressed < -gap else 0.0)
    return held - p[2] - p[0] * new, 0.0


@numba.njit(cache=True, nogil=True)
@no_type_check  # a checker's wrapper cannot be compiled
def march(phi, early, late, pulse, origin, kinds, parameters, rows, c, d, fine):
    """March blows side by side and write what the outputs say.

    Args:
        phi: exp(A h), [state, state].
        early: weight of the elements' forces at the start of a step, [state, element].
        late: at its end.
        pulse: what the hammer adds in each step from `origin` on, [step, state, blow].
        origin: grid point at which the pulse begins.
        kinds: law of each element.
        parameters: [element, 3].
        rows: elongation of each element by the state, [element, state].
        c: outputs by the state, [channel, state].
        d: outputs by the elements' forces, [channel, element].
        fine: filled, [grid, channel, blow].
    """
    states, blows = phi.shape[0], pulse.shape[2]
    count = len(kinds)
    now = np.zeros((states, blows))
    base = np.zeros((states, blows))
    force = np.zeros((count, blows))
    guess = np.zeros((count, blows))
    memory = np.zeros((count, blows))
    fresh = np.zeros((count, blows))
    stretch = np.zeros((count, blows))
    free = np.zeros((count, blows))
    gain = rows @ late  # how the forces at the end of a step move the elongations there
    for grid in range(origin, fine.shape[0] - 1):
        for i in range(states):
            for b in range(blows):
                base[i, b] = 0.0
            for j in range(states):
                a = phi[i, j]
                for b in range(blows):
                    base[i, b] += a * now[j, b]
            for e in range(count):
                a = early[i, e]
                for b in range(blows):
                    base[i, b] += a * force[e, b]
            if grid - origin < pulse.shape[0]:
                for b in range(blows):
                    base[i, b] += pulse[grid - origin, i, b]
        for e in range(count):
            for b in range(blows):
                free[e, b] = 0.0
                guess[e, b] = force[e, b]
            for j in range(states):
                a = rows[e, j]
                if a != 0.0:
                    for b in range(blows):
                        free[e, b] += a * base[j, b]
        for _ in range(4):  # contracts by about (ω h)²/6 a round
            for e in range(count):
                for b in range(blows):
                    end = free[e, b]
                    for other in range(count):
                        end += gain[e, other] * guess[other, b]
                    taken, fresh[e, b] = law(kinds[e], parameters[e], stretch[e, b], end, memory[e, b])
                    guess[e, b] = -taken
        for e in range(count):
            for b in range(blows):
                end = free[e, b]
                for other in range(count):
                    end += gain[e, other] * guess[other, b]
                stretch[e, b] = end
                memory[e, b] = fresh[e, b]
                force[e, b] = guess[e, b]
        for i in range(states):
            for b in range(blows):
                now[i, b] = base[i, b]
            for e in range(count):
                a = late[i, e]
                for b in range(blows):
                    now[i, b] += a * force[e, b]
        for k in range(c.shape[0]):
            for b in range(blows):
                fine[grid + 1, k, b] = 0.0
            for j in range(states):
                a = c[k, j]
                for b in range(blows):
                    fine[grid + 1, k, b] += a * now[j, b]
            for e in range(count):
                a = d[k, e]
                for b in range(blows):
                    fine[grid + 1, k, b] += a * force[e, b]
