"""The recursion of `flexmodal.frf.kernels.recursion` in space: twists (velocity, rotation), I of 21 entries.

I consists of A (force of a velocity), B (force of a rotation) and C (moment of a rotation). From the next
joint, a vector d away, to this one

    B ← B − A [d×],    C ← C − Bᵀ [d×] + [d×] B (the new B),    moment ← moment + d × force,

and a body of mass m, first moment c and inertia J about this joint adds m to A, −[c×] to B and J to C.
"""

from __future__ import annotations

from functools import reduce

from flexmodal.frf.kernels.emitter import Emitter, Number
from flexmodal.frf.kernels.recursion import Algebra, Inertia, Wrenches

ENTRIES = (
    "dx", "dy", "dz", "mass", "mx", "my", "mz", "xx", "xy", "yy", "xz", "yz", "zz", "k", "b", "h", "rotor",
    "diagonal", "sx", "sy", "sz",
)  # fmt: skip
"""The step to the next joint, the body's mass, mass times lever and inertia about the joint, stiffness,
damping, structural damping, rotor inertia, the joint's entry of the mass matrix, its axis; in world axes."""

_CROSS = (((1, "z", 1), (2, "y", -1)), ((0, "z", -1), (2, "x", 1)), ((0, "y", 1), (1, "x", -1)))
"""Columns of [d×]: row, component of d, sign. Its rows are the same with the other sign."""


def carry(code: Emitter, inertia: Inertia, wrenches: Wrenches, factor: Number) -> None:
    """From the next joint to this one, and the body added."""
    old = dict(inertia)
    for i in range(3):
        for j in range(3):
            for k, component, sign in _CROSS[j]:
                linear = old[min(i, k), max(i, k)]
                inertia[i, 3 + j] = _add(code, inertia[i, 3 + j], linear, f"d{component}", -sign)
    for i in range(3):
        for j in range(i, 3):
            for k, component, sign in _CROSS[j]:
                inertia[3 + i, 3 + j] = _add(
                    code, inertia[3 + i, 3 + j], old[k, 3 + i], f"d{component}", -sign
                )
            for k, component, sign in _CROSS[i]:
                inertia[3 + i, 3 + j] = _add(
                    code, inertia[3 + i, 3 + j], inertia[k, 3 + j], f"d{component}", -sign
                )
    for wrench in wrenches:
        for i in range(3):
            for k, component, sign in _CROSS[i]:
                wrench[3 + i] = _add(code, wrench[3 + i], wrench[k], f"d{component}", -sign)
    for i in range(3):
        inertia[i, i] = code.plus_times(inertia[i, i], factor, Number("mass"))
        for k, component, sign in _CROSS[i]:
            inertia[k, 3 + i] = _add(code, inertia[k, 3 + i], factor, f"m{component}", -sign)
        for j in range(i, 3):
            name = "xyz"[i] + "xyz"[j]
            inertia[3 + i, 3 + j] = code.plus_times(inertia[3 + i, 3 + j], factor, Number(name))


def project(
    code: Emitter, inertia: Inertia, wrenches: Wrenches, turning: bool
) -> tuple[list[Number], Number, list[Number]]:
    """I S, SᵀI S and Sᵀr of an axis, rotation or translation along it."""
    shift = 3 if turning else 0
    across = [
        _along(code, [inertia[min(a, b), max(a, b)] for b in range(shift, shift + 3)]) for a in range(6)
    ]
    own = _along(code, across[shift : shift + 3])
    return across, own, [_along(code, wrench[shift : shift + 3]) for wrench in wrenches]


def _along(code: Emitter, parts: list[Number]) -> Number:
    """Three components times the axis."""
    first, *rest = zip(parts, ("sx", "sy", "sz"), strict=True)
    start = code.times(first[0], Number(first[1]))
    return reduce(lambda total, part: code.plus_times(total, part[0], Number(part[1])), rest, start)


def _add(code: Emitter, total: Number, part: Number, name: str, sign: int) -> Number:
    add = code.plus_times if sign > 0 else code.minus_times
    return add(total, part, Number(name))


SPATIAL = Algebra("spatial", 6, ENTRIES, carry, project)
"""For `flexmodal.frf.kernels.recursion.write_step`."""
