"""The recursion of `flexmodal.frf.kernels.recursion` in a plane: twists (x, y, angle), I of six entries."""

from __future__ import annotations

from flexmodal.frf.kernels.emitter import Emitter, Number
from flexmodal.frf.kernels.recursion import Algebra, Inertia, Wrenches

ENTRIES = ("dx", "dy", "mass", "mx", "my", "inertia", "k", "b", "h", "rotor", "diagonal", "sx", "sy")
"""The step to the next joint, the body's mass, mass times lever and inertia about the joint, stiffness,
damping, structural damping, rotor inertia, the joint's entry of the mass matrix, the direction if it
slides."""


def carry(code: Emitter, inertia: Inertia, wrenches: Wrenches, factor: Number) -> None:
    """From the next joint to this one, and the body added."""
    dx, dy = Number("dx"), Number("dy")
    xx, xy, yy, xw, yw, ww = (inertia[p] for p in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)))
    old_xw, old_yw = xw, yw
    xw = code.plus_times(code.minus_times(xw, xx, dy), xy, dx)
    yw = code.plus_times(code.minus_times(yw, xy, dy), yy, dx)
    ww = code.plus_times(code.minus_times(ww, old_xw, dy), old_yw, dx)
    ww = code.plus_times(code.minus_times(ww, xw, dy), yw, dx)
    inertia[0, 0] = code.plus_times(xx, factor, Number("mass"))
    inertia[1, 1] = code.plus_times(yy, factor, Number("mass"))
    inertia[0, 2] = code.minus_times(xw, factor, Number("my"))
    inertia[1, 2] = code.plus_times(yw, factor, Number("mx"))
    inertia[2, 2] = code.plus_times(ww, factor, Number("inertia"))
    for wrench in wrenches:
        wrench[2] = code.plus_times(code.minus_times(wrench[2], wrench[0], dy), wrench[1], dx)


def project(
    code: Emitter, inertia: Inertia, wrenches: Wrenches, turning: bool
) -> tuple[list[Number], Number, list[Number]]:
    """I S, SᵀI S and Sᵀr; a revolute S is (0, 0, 1)."""
    if turning:
        across = [inertia[0, 2], inertia[1, 2], inertia[2, 2]]
        return across, across[2], [wrench[2] for wrench in wrenches]
    sx, sy = Number("sx"), Number("sy")
    pairs = [(inertia[0, 0], inertia[0, 1]), (inertia[0, 1], inertia[1, 1]), (inertia[0, 2], inertia[1, 2])]
    across = [code.plus_times(code.times(a, sx), b, sy) for a, b in pairs]
    own = code.plus_times(code.times(across[0], sx), across[1], sy)
    return across, own, [code.plus_times(code.times(w[0], sx), w[1], sy) for w in wrenches]


PLANAR = Algebra("planar", 3, ENTRIES, carry, project)
"""For `flexmodal.frf.kernels.recursion.write_step`."""
