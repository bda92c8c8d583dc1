"""The inner loop of a non-linear plant, compiled. Import it only where it runs: numba is slow to load.

Codes of the laws are those of `plant`: 0 hardening, 1 friction, 2 backlash. All blows go side by side, in
loops that the compiler works on several at a time; so nothing in them may branch or call a library, and
divisions follow numpy, which does not look for zeros. `no_type_check` keeps a checker's wrapper off, which
could not be compiled.
"""

from __future__ import annotations

from typing import no_type_check

import numba
import numpy as np


@numba.njit(cache=True, nogil=True, error_model="numpy")
@no_type_check
def add(total, weights, values):
    """Total += weights @ values, [row, blow] += [row, column] @ [column, blow]."""
    for j in range(weights.shape[1]):
        for i in range(weights.shape[0]):
            weight = weights[i, j]
            for b in range(total.shape[1]):
                total[i, b] += weight * values[j, b]


@numba.njit(cache=True, nogil=True, error_model="numpy")
@no_type_check
def hardening(p, new, force):
    """Torque of a spring that hardens, beside the linear one: p = k a, q_r."""
    for b in range(len(new)):
        ratio = new[b] / p[1]
        square = ratio * ratio
        force[b] = -p[0] * new[b] * square / (1.0 + square)


@numba.njit(cache=True, nogil=True, error_model="numpy")
@no_type_check
def friction(p, old, new, before, force):
    """Dahl's law over one step: p = F_c, σ. The force decays towards ±F_c with the distance moved.

    exp(−y) = exp(−y/256)^256 by a Taylor polynomial of degree 10: to 4e-14, and 1e-19 for all y above 43.5.
    """
    limit = p[0]
    rate = p[1] / p[0] / 256.0
    for b in range(len(new)):
        moved = new[b] - old[b]
        y = min(abs(moved) * rate, 0.17)
        left = 1.0
        for power in range(10, 0, -1):
            left = 1.0 - y / power * left
        for _ in range(8):
            left = left * left
        end = -limit if moved >= 0 else limit
        force[b] = end + (before[b] - end) * left


@numba.njit(cache=True, nogil=True, error_model="numpy")
@no_type_check
def backlash(p, new, force):
    """Dead zone beside a preloaded contact: p = k, gap, preload."""
    gap = p[0] * p[1]
    for b in range(len(new)):
        pressed = p[0] * new[b] + p[2]
        held = pressed if pressed > 0 else (pressed + gap if pressed < -gap else 0.0)
        force[b] = p[0] * new[b] + p[2] - held


@numba.njit(cache=True, nogil=True, error_model="numpy")
@no_type_check
def step_through(phi, early, late, pulse, origin, kinds, parameters, rows, c, d, fine):
    """Integrate blows side by side and write what the outputs say.

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
        fine: filled, [blow, channel, grid].
    """
    states, blows, count = phi.shape[0], pulse.shape[2], len(kinds)
    now, base = np.zeros((states, blows)), np.zeros((states, blows))
    force, before = np.zeros((count, blows)), np.zeros((count, blows))
    stretch, free = np.zeros((count, blows)), np.zeros((count, blows))
    end, out = np.zeros((count, blows)), np.zeros((len(c), blows))
    gain = rows @ late  # how the forces at the end of a step move the elongations there
    for grid in range(origin, fine.shape[2] - 1):
        base[:] = 0.0
        add(base, phi, now)
        add(base, early, force)
        if grid - origin < pulse.shape[0]:
            base += pulse[grid - origin]
        free[:] = 0.0
        add(free, rows, base)
        before[:] = force
        for _ in range(4):  # contracts by about (ω h)²/6 a round
            end[:] = free
            add(end, gain, force)
            for e in range(count):
                if kinds[e] == 0:
                    hardening(parameters[e], end[e], force[e])
                elif kinds[e] == 1:
                    friction(parameters[e], stretch[e], end[e], before[e], force[e])
                else:
                    backlash(parameters[e], end[e], force[e])
        stretch[:] = free
        add(stretch, gain, force)
        now[:] = base
        add(now, late, force)
        out[:] = 0.0
        add(out, c, now)
        add(out, d, force)
        for k in range(len(c)):
            for b in range(blows):
                fine[b, k, grid + 1] = out[k, b]
