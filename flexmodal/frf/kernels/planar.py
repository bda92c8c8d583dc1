"""Long planar chains: the receptance in a number of operations that grows with n, not with its cube.

With K and B diagonal, Z y = jᵀ is the equation of motion of the chain at one frequency, and eliminating the
joints from the tip to the base needs only what hangs behind a joint: an articulated inertia, 3 × 3 and
complex, of x, y and the angle (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7, here with
−ω²M for the bodies and k + iωb for the joints). It is the LDLᵀ of Z from its last row to its first,
without Z:

    U = I S, δ = Sᵀ U + k + iωb, t_u = Sᵀ r_u, α_uv ← α_uv + t_u t_v / δ, I ← I − U Uᵀ/δ, r_u ← r_u − U t_u/δ.

I and the wrenches r are kept about the joint at hand, so a revolute S is (0, 0, 1) and nothing large cancels.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.frf.kernels.emitter import Emitter, Number
from flexmodal.frf.kernels.factor import GROWTH, LANES, SMALLEST_PIVOT, Pairs, row_count

ENTRIES = 14
"""Numbers of a joint: the step to the next joint (x, y), its body's mass, mass times lever (x, y) and
inertia about the joint, k, b, structural damping, rotor inertia, its entry of the mass matrix, the
direction if it slides (x, y), and its kind: 0 rigid, 1 revolute, 2 prismatic."""

step_turning: Any = None
step_sliding: Any = None
"""Stand for the generated functions."""


def write_step(pairs: Pairs, *, turning: bool, lanes: int = LANES) -> str:
    """Source of the elimination of one joint, for one tile of frequencies.

    `state` holds I (xx, xy, yy, xw, yw, ww), then the wrench of each row (x, y, w), all complex in two
    parts; then the receptances in two parts, and the trust. `joint` and `wrench` are what belongs to the
    joint; `least` is the smallest trusted share of its pivot, squared.
    """
    code = Emitter()
    rows = row_count(pairs)
    names = ("dx", "dy", "mass", "mx", "my", "inertia", "k", "b", "h", "rotor", "diagonal", "sx", "sy")
    head = [f"    {name} = joint[{place}]" for place, name in enumerate(names)]
    head += [f"    w{r}_{a} = wrench[{3 * r + a}]" for r in range(rows) for a in range(3)]
    dx, dy = Number("dx"), Number("dy")
    state = [_load(code, place, lanes) for place in range(6 + 3 * rows)]
    omega = code.scalar("omega[p]")
    minus = code.scalar(f"-{omega} * {omega}")
    xx, xy, yy, xw, yw, ww = state[:6]
    old_xw, old_yw = xw, yw  # carried from the next joint to this one
    xw = code.plus_times(code.minus_times(xw, xx, dy), xy, dx)
    yw = code.plus_times(code.minus_times(yw, xy, dy), yy, dx)
    ww = code.plus_times(code.minus_times(ww, old_xw, dy), old_yw, dx)
    ww = code.plus_times(code.minus_times(ww, xw, dy), yw, dx)
    factor = Number(minus)  # the body itself
    xx, yy = (code.plus_times(part, factor, Number("mass")) for part in (xx, yy))
    xw = code.minus_times(xw, factor, Number("my"))
    yw = code.plus_times(yw, factor, Number("mx"))
    ww = code.plus_times(ww, factor, Number("inertia"))
    wrenches = []
    for r in range(rows):
        x, y, w = state[6 + 3 * r : 9 + 3 * r]
        w = code.plus_times(code.minus_times(w, x, dy), y, dx)
        wrenches.append(
            [Number(code.scalar(f"{part.re} + w{r}_{a}"), part.im) for a, part in enumerate((x, y, w))]
        )
    inertia = [xx, xy, yy, xw, yw, ww]
    if turning:
        across = [xw, yw, ww]
        own, drives = ww, [wrench[2] for wrench in wrenches]
    else:
        sx, sy = Number("sx"), Number("sy")
        across = [code.plus_times(code.times(a, sx), b, sy) for a, b in ((xx, xy), (xy, yy), (xw, yw))]
        own = code.plus_times(code.times(across[0], sx), across[1], sy)
        drives = [code.plus_times(code.times(wrench[0], sx), wrench[1], sy) for wrench in wrenches]
    pivot = Number(code.scalar(f"{own.re} + k + {minus} * rotor"), code.scalar(f"{own.im} + h + {omega} * b"))
    inverse, square = code.inverse(pivot)
    size = code.scalar(f"k - {minus} * diagonal + h + {omega} * b")
    limit = code.scalar(f"{size} * {size}")
    room = code.scalar(f"{GROWTH**2!r} * {limit} - {square}")
    last = (6 + 3 * rows + len(pairs)) * 2
    trust = code.scalar(f"state[{last * lanes}+p]")
    trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
    room = code.scalar(f"{square} - least * {limit}")
    trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
    for place, (u, v) in enumerate(pairs):
        total = _load(code, 6 + 3 * rows + place, lanes)
        total = code.plus_times(total, code.times(drives[u], inverse), drives[v])
        _store(code, total, 6 + 3 * rows + place, lanes)
    shares = [code.times(part, inverse) for part in across]
    for place, (a, b) in enumerate(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))):
        _store(code, code.minus_times(inertia[place], shares[a], across[b]), place, lanes)
    for r, wrench in enumerate(wrenches):
        for a in range(3):
            _store(code, code.minus_times(wrench[a], shares[a], drives[r]), 6 + 3 * r + a, lanes)
    code.lines.append(f"state[{last * lanes}+p] = {trust}")
    body = "\n".join(f"        {line}" for line in code.lines)
    start = "def step(state, omega, joint, wrench, least):\n"
    return start + "\n".join(head) + f"\n    for p in range({lanes}):\n{body}\n"


def _load(code: Emitter, place: int, lanes: int) -> Number:
    parts = (code.scalar(f"state[{(2 * place + part) * lanes}+p]") for part in (0, 1))
    return Number(*parts)


def _store(code: Emitter, value: Number, place: int, lanes: int) -> None:
    code.lines.append(f"state[{2 * place * lanes}+p] = {value.re}")
    code.lines.append(f"state[{(2 * place + 1) * lanes}+p] = {value.im}")


def step_rigid(state, joint, wrench, omega, rows):
    """A joint without flexibility: what is behind it is carried on to the joint before, with its body."""
    for p in range(LANES):
        m = -omega[p] * omega[p]
        for part in range(2):
            o = part * LANES + p
            real = m if part == 0 else 0.0
            xx, xy, yy = state[o], state[2 * LANES + o], state[4 * LANES + o]
            xw, yw = state[6 * LANES + o], state[8 * LANES + o]
            new_xw = xw - xx * joint[1] + xy * joint[0]
            new_yw = yw - xy * joint[1] + yy * joint[0]
            state[10 * LANES + o] += (yw + new_yw) * joint[0] - (xw + new_xw) * joint[1] + real * joint[5]
            state[o] = xx + real * joint[2]
            state[4 * LANES + o] = yy + real * joint[2]
            state[6 * LANES + o] = new_xw - real * joint[4]
            state[8 * LANES + o] = new_yw + real * joint[3]
            for r in range(rows):
                x, y = state[(12 + 6 * r) * LANES + o], state[(14 + 6 * r) * LANES + o]
                state[(16 + 6 * r) * LANES + o] += y * joint[0] - x * joint[1]
                if part == 0:
                    for a in range(3):
                        state[(12 + 6 * r + 2 * a) * LANES + o] += wrench[3 * r + a]


def sweep_planar(joints, wrenches, omega, rows, out):
    """Receptances of some postures of a planar chain.

    Args:
        joints: posture × joint × `ENTRIES`.
        wrenches: what a unit force of each row is about the joint that carries its point; posture × joint ×
            3·row.
        omega: angular frequencies [rad/s], their number a multiple of `LANES`.
        rows: how many rows.
        out: receives posture × frequency × pair.

    Returns:
        How many points are not trusted; they are NaN.
    """
    postures, lines, pairs = out.shape
    state = np.empty((2 * (6 + 3 * rows + pairs) + 1) * LANES)
    results = state[2 * (6 + 3 * rows) * LANES :]
    doubtful = 0
    for s in range(postures):
        first = 0  # the joint eliminated last, of whose pivot little is asked
        while joints[s, first, 13] == 0.0:
            first += 1
        for start in range(0, lines, LANES):
            state[:] = 0.0
            state[len(state) - LANES :] = 1.0
            tile = omega[start : start + LANES]
            for i in range(joints.shape[1] - 1, -1, -1):
                joint, wrench = joints[s, i], wrenches[s, i]
                least = SMALLEST_PIVOT**2 if i == first else 0.0
                if joint[13] == 1.0:
                    step_turning(state, tile, joint, wrench, least)
                elif joint[13] == 2.0:
                    step_sliding(state, tile, joint, wrench, least)
                else:
                    step_rigid(state, joint, wrench, tile, rows)
            doubtful += spread(results, s, start, False, out)
    return doubtful


spread: Any = None
"""Stands for `flexmodal.frf.kernels.sweep.spread`, compiled."""
