"""The inner loop of a non-linear plant: plain functions of numbers and arrays, compiled by `nonlinear`.

Codes of the laws are those of `plant`, the laws themselves those of `laws`. All blows go side by side; in the
first three laws in loops that the compiler works on several at a time, so that nothing in them may branch or
call a library. Divisions follow numpy, which does not look for zeros. `no_type_check` keeps a checker's
wrapper off, which could not be compiled.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np


@no_type_check
def add(total, weights, values):
    """Total += weights @ values, [row, blow] += [row, column] @ [column, blow]."""
    for j in range(weights.shape[1]):
        for i in range(weights.shape[0]):
            weight = weights[i, j]
            for b in range(total.shape[1]):
                total[i, b] += weight * values[j, b]


@no_type_check
def hardening(p, new, force):
    """Torque of a spring that hardens, beside the linear one: p = k a, q_r."""
    for b in range(len(new)):
        ratio = new[b] / p[1]
        square = ratio * ratio
        force[b] = -p[0] * new[b] * square / (1.0 + square)


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


@no_type_check
def backlash(p, new, force):
    """Dead zone beside a preloaded contact: p = k, gap, preload."""
    gap = p[0] * p[1]
    for b in range(len(new)):
        pressed = p[0] * new[b] + p[2]
        held = pressed if pressed > 0 else (pressed + gap if pressed < -gap else 0.0)
        force[b] = p[0] * new[b] + p[2] - held


@no_type_check
def elastic(kind, p, new, force):
    """Torques that only the elongation sets: polynomial (3), piecewise, saturating, sinh, Hertz's (7)."""
    for b in range(len(new)):
        u = new[b]
        size = abs(u)
        if kind == 3:
            force[b] = -(p[0] + p[1] * u) * u * u
        elif kind == 4:
            torque = p[0] * max(size - p[1], 0.0) + p[2] * max(size - p[3], 0.0)
            force[b] = -torque if u > 0 else torque
        elif kind == 5:
            force[b] = -(p[0] * np.tanh(u / p[1]) + p[2] * u)
        elif kind == 7:
            pressed = max(1.0 + u / p[1], 0.0) ** 1.5 - max(1.0 - u / p[1], 0.0) ** 1.5
            force[b] = -p[0] * (p[1] / 3.0 * pressed - u)
        else:
            ratio = size / p[1]
            inner = min(ratio, p[2])
            torque = p[0] * p[1] * (np.sinh(inner) + np.cosh(inner) * (ratio - inner) - ratio)
            force[b] = -torque if u > 0 else torque


@no_type_check
def wound(p, new, force):
    """Torque of a spring that hardens, from where it is wound up already: p = k a, q_r, that place."""
    rest = (p[2] / p[1]) ** 2
    held = p[2] * rest / (1.0 + rest)
    for b in range(len(new)):
        place = new[b] + p[2]
        square = (place / p[1]) ** 2
        force[b] = p[0] * (held - place * square / (1.0 + square))


@no_type_check
def sliding(kind, p, speed, old, new, memory, fresh, force, ease):
    """Torques that the rate sets, Stribeck's (8) and the bristles' (9); `ease` of the last guess stays."""
    for b in range(len(speed)):
        v, moved = speed[b], new[b] - old[b]
        if kind == 8:
            torque = (p[0] + (p[1] - p[0]) * np.exp(-((v / p[2]) ** 2))) * np.tanh(v / p[3])
        else:
            limit = p[2] + (p[3] - p[2]) * np.exp(-((v / p[4]) ** 2))
            end = (limit if moved >= 0 else -limit) / p[0]
            bristle = end + (memory[b] - end) * np.exp(-p[0] * abs(moved) / limit)
            fresh[b] = bristle
            torque = p[0] * bristle + p[1] * (v - p[0] * abs(v) * bristle / limit)
        force[b] += (-torque - force[b]) / (1.0 + ease)


@no_type_check
def yielding(kind, p, old, new, memory, fresh, force):
    """Torques by the distance moved: a slipping spring (10), by load (12), over play (13), Bouc-Wen (11)."""
    place = 0.0
    for b in range(len(new)):
        moved = new[b] - old[b]
        if kind == 10:
            torque = min(max(memory[b] + p[0] * moved, -p[1]), p[1])
        elif kind == 12:
            limit = p[1] + p[2] * abs(new[b] + p[3])
            torque = min(max(memory[b] + p[0] * moved, -limit), limit)
        elif kind == 13:
            far = p[2] + p[1] / p[0]
            place = min(max(memory[b], new[b] - far), new[b] + far)
            off = new[b] - place
            torque = p[0] * max(abs(off) - p[2], 0.0)
            if off < 0:
                torque = -torque
        else:
            way = 1.0 if moved >= 0 else -1.0
            far = p[0] / p[1] * abs(moved)
            part = way * memory[b] / p[1]
            back = min(far, max(-part, 0.0))
            part += back
            gone = np.tanh(far - back)
            torque = way * p[1] * (part + gone) / (1.0 + part * gone)
        fresh[b] = place if kind == 13 else torque
        force[b] = -torque


@no_type_check
def act(kind, p, old, new, speed, before, memory, fresh, force, ease):
    """The force of one element at the end of a step; what it remembers goes to `fresh`."""
    if kind == 0:
        hardening(p, new, force)
    elif kind == 1:
        friction(p, old, new, before, force)
    elif kind == 2:
        backlash(p, new, force)
    elif kind <= 7:
        elastic(kind, p, new, force)
    elif kind <= 9:
        sliding(kind, p, speed, old, new, memory, fresh, force, ease)
    elif kind <= 13:
        yielding(kind, p, old, new, memory, fresh, force)
    else:
        wound(p, new, force)


@no_type_check
def search(
    kinds, parameters, gain, swift, free, coast, stretch, before, memory, fresh, force, ease, rounds, end,
    speed,
):  # fmt: skip
    """The forces at the end of a step: contracts by about (ω h)²/6 a round, or by what `ease` says."""
    for _ in range(rounds):
        for e in range(len(kinds)):
            for b in range(free.shape[1]):
                end[e, b] = free[e, b]
                speed[e, b] = coast[e, b]
        add(end, gain, force)
        add(speed, swift, force)
        for e in range(len(kinds)):
            act(
                kinds[e], parameters[e], stretch[e], end[e], speed[e], before[e], memory[e], fresh[e],
                force[e], ease[e],
            )  # fmt: skip


@no_type_check
def step_through(
    phi, early, late, pulse, origin, kinds, parameters, rows, rates, ease, rounds, c, d, fine
):  # fmt: skip
    """Integrate blows side by side and write what the outputs say.

    Args:
        phi: exp(A h), [state, state].
        early: weight of the elements' forces at the start of a step, [state, element].
        late: at its end.
        pulse: what the hammer adds in each step from `origin` on, [step, state, blow].
        origin: grid point at which the pulse begins.
        kinds: law of each element.
        parameters: [element, number].
        rows: elongation of each element by the state, [element, state].
        rates: rate of elongation by the state, [element, state].
        ease: how much of the last guess stays in a round, over what is new [element].
        rounds: of the search for the forces at the end of a step.
        c: outputs by the state, [channel, state].
        d: outputs by the elements' forces, [channel, element].
        fine: filled, [blow, channel, grid].
    """
    states, blows, count = phi.shape[0], pulse.shape[2], len(kinds)
    now, base = np.zeros((states, blows)), np.zeros((states, blows))
    force, before = np.zeros((count, blows)), np.zeros((count, blows))
    memory, fresh = np.zeros((count, blows)), np.zeros((count, blows))
    stretch, free = np.zeros((count, blows)), np.zeros((count, blows))
    speed, coast = np.zeros((count, blows)), np.zeros((count, blows))
    end, out = np.zeros((count, blows)), np.zeros((len(c), blows))
    gain, swift = rows @ late, rates @ late  # how the forces at the end of a step move the elongations there
    for grid in range(origin, fine.shape[2] - 1):
        base[:] = 0.0
        add(base, phi, now)
        add(base, early, force)
        if grid - origin < pulse.shape[0]:
            base += pulse[grid - origin]
        free[:] = 0.0
        add(free, rows, base)
        coast[:] = 0.0
        add(coast, rates, base)
        before[:] = force
        search(
            kinds, parameters, gain, swift, free, coast, stretch, before, memory, fresh, force, ease, rounds,
            end, speed,
        )  # fmt: skip
        memory[:] = fresh
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
