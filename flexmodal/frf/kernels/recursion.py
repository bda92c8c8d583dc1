"""Long chains: the receptance in a number of operations that grows with n, not with its cube.

With K and B diagonal, Z y = jᵀ is the equation of motion of the chain at one frequency, and eliminating the
joints from the tip to the base needs only what hangs behind a joint: an articulated inertia I, symmetric and
complex (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7, here with −ω²M for the bodies and
k + iωb for the joints). It is the LDLᵀ of Z from its last row to its first, without Z:

    U = I S, δ = Sᵀ U + k + iωb, t_u = Sᵀ r_u, α_uv ← α_uv + t_u t_v / δ, I ← I − U Uᵀ/δ, r_u ← r_u − U t_u/δ.

I and the wrenches r of the rows are kept about the joint at hand, so that nothing large cancels. In a plane I
is 3 × 3 (`flexmodal.frf.kernels.planar`), in space 6 × 6 (`flexmodal.frf.kernels.spatial`).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodal.frf.kernels.emitter import Emitter, Number
from flexmodal.frf.kernels.factor import GROWTH, LANES, SMALLEST_PIVOT, Pairs, row_count

TURNING, SLIDING, RIGID = "turning", "sliding", "rigid"
KINDS = (RIGID, TURNING, SLIDING)
"""Of a joint, in the order of its last entry: without flexibility, revolute, prismatic."""

Inertia = dict[tuple[int, int], Number]
"""Entries (a, b), a ≤ b, of the articulated inertia."""

Wrenches = list[list[Number]]

step_turning: Any = None
step_sliding: Any = None
step_rigid: Any = None
spread: Any = None
"""Stand for the generated functions, and for the compiled `flexmodal.frf.kernels.sweep.spread`."""


@dataclass(frozen=True)
class Algebra:
    """What a recursion in a plane or in space consists of."""

    name: str
    width: int
    """Components of a twist."""
    entries: tuple[str, ...]
    """Numbers of a joint, for the generated code; its kind comes after them."""
    carry: Callable[[Emitter, Inertia, Wrenches, Number], None]
    """From the next joint to this one, and the body added, times −ω²."""
    project: Callable[[Emitter, Inertia, Wrenches, bool], tuple[list[Number], Number, list[Number]]]
    """I S, SᵀI S and Sᵀr of a joint, revolute or prismatic."""

    @property
    def places(self) -> list[tuple[int, int]]:
        """Entries of the inertia in the order in which they are kept."""
        return [(a, b) for b in range(self.width) for a in range(b + 1)]

    def before(self, rows: int) -> int:
        """Complex numbers of the state before the receptances."""
        return len(self.places) + self.width * rows


def write_step(algebra: Algebra, pairs: Pairs, kind: str) -> str:
    """Source of `step(state, omega, joint, wrench, least)`: one joint, for one tile of frequencies.

    `state` holds I, then the wrench of each row, all complex in two parts; then the receptances in two
    parts, and the trust. `joint` and `wrench` are what belongs to the joint; `least` is the smallest trusted
    share of its pivot, squared.
    """
    code = Emitter()
    rows, width, places = row_count(pairs), algebra.width, algebra.places
    head = [f"    {name} = joint[{place}]" for place, name in enumerate(algebra.entries)]
    head += [f"    w{r}_{a} = wrench[{width * r + a}]" for r in range(rows) for a in range(width)]
    inertia = {place: _load(code, number) for number, place in enumerate(places)}
    wrenches = [[_load(code, len(places) + width * r + a) for a in range(width)] for r in range(rows)]
    omega = code.scalar("omega[p]")
    minus = code.scalar(f"-{omega} * {omega}")
    algebra.carry(code, inertia, wrenches, Number(minus))
    wrenches = [
        [Number(code.scalar(f"{part.re} + w{r}_{a}"), part.im) for a, part in enumerate(wrench)]
        for r, wrench in enumerate(wrenches)
    ]
    if kind != RIGID:
        across, own, drives = algebra.project(code, inertia, wrenches, kind == TURNING)
        inverse = _pivot(code, own, omega, minus, algebra.before(rows) + len(pairs))
        for place, (u, v) in enumerate(pairs):
            total = _load(code, algebra.before(rows) + place)
            total = code.plus_times(total, code.times(drives[u], inverse), drives[v])
            _store(code, total, algebra.before(rows) + place)
        shares = [code.times(part, inverse) for part in across]
        for a, b in places:
            inertia[a, b] = code.minus_times(inertia[a, b], shares[a], across[b])
        wrenches = [
            [code.minus_times(part, shares[a], drives[r]) for a, part in enumerate(wrench)]
            for r, wrench in enumerate(wrenches)
        ]
    for number, entry in enumerate(places):
        _store(code, inertia[entry], number)
    for r, wrench in enumerate(wrenches):
        for a, part in enumerate(wrench):
            _store(code, part, len(places) + width * r + a)
    body = "\n".join(f"        {line}" for line in code.lines)
    start = "def step(state, omega, joint, wrench, least):\n"
    return start + "\n".join(head) + f"\n    for p in range({LANES}):\n{body}\n"


def _pivot(code: Emitter, own: Number, omega: str, minus: str, last: int) -> Number:
    """1/δ; lessens the trust where δ grew beyond its terms, or vanishes where it must not."""
    pivot = Number(code.scalar(f"{own.re} + k + {minus} * rotor"), code.scalar(f"{own.im} + h + {omega} * b"))
    inverse, square = code.inverse(pivot)
    size = code.scalar(f"k - {minus} * diagonal + h + {omega} * b")
    limit = code.scalar(f"{size} * {size}")
    room = code.scalar(f"{GROWTH**2!r} * {limit} - {square}")
    trust = code.scalar(f"state[{2 * last * LANES}+p]")
    trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
    room = code.scalar(f"{square} - least * {limit}")
    trust = code.scalar(f"{room} if {room} < {trust} else {trust}")
    code.lines.append(f"state[{2 * last * LANES}+p] = {trust}")
    return inverse


def _load(code: Emitter, place: int) -> Number:
    parts = (code.scalar(f"state[{(2 * place + part) * LANES}+p]") for part in (0, 1))
    return Number(*parts)


def _store(code: Emitter, value: Number, place: int) -> None:
    code.lines.append(f"state[{2 * place * LANES}+p] = {value.re}")
    code.lines.append(f"state[{(2 * place + 1) * LANES}+p] = {value.im}")


def sweep_along(joints, wrenches, omega, before, out):
    """Receptances of some postures of a chain.

    Args:
        joints: entries of each joint and its kind; posture × joint × entry.
        wrenches: what a unit force of each row is about the joint that carries its point; posture × joint ×
            row·width.
        omega: angular frequencies [rad/s], their number a multiple of `LANES`.
        before: complex numbers of the state before the receptances.
        out: receives posture × frequency × pair.

    Returns:
        How many points are not trusted; they are NaN.
    """
    postures, lines, pairs = out.shape
    state = np.empty((2 * (before + pairs) + 1) * LANES)
    results = state[2 * before * LANES :]
    kind = joints.shape[2] - 1
    doubtful = 0
    for s in range(postures):
        first = 0  # the joint eliminated last, of whose pivot little is asked
        while joints[s, first, kind] == 0.0:
            first += 1
        for start in range(0, lines, LANES):
            state[:] = 0.0
            state[len(state) - LANES :] = 1.0
            tile = omega[start : start + LANES]
            for i in range(joints.shape[1] - 1, -1, -1):
                joint, wrench = joints[s, i], wrenches[s, i]
                least = SMALLEST_PIVOT**2 if i == first else 0.0
                if joint[kind] == 1.0:
                    step_turning(state, tile, joint, wrench, least)
                elif joint[kind] == 2.0:
                    step_sliding(state, tile, joint, wrench, least)
                else:
                    step_rigid(state, tile, joint, wrench, least)
            doubtful += spread(results, s, start, False, out)
    return doubtful
