"""Twists, momenta and inertias of six numbers and ten: written for the compiler.

Twists hold the velocity at a common origin before the angular velocity, momenta the linear one before the
angular one about it.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations


def apply_inertia(inertia, twist, out):
    """Momentum of a twist; `inertia` holds the mass, mass times centre, and xx, xy, xz, yy, yz, zz."""
    m, x, y, z = inertia[0], inertia[1], inertia[2], inertia[3]
    a, b, c, d, e, f = twist[0], twist[1], twist[2], twist[3], twist[4], twist[5]
    out[0], out[1], out[2] = m * a + e * z - f * y, m * b + f * x - d * z, m * c + d * y - e * x
    out[3] = inertia[4] * d + inertia[5] * e + inertia[6] * f + y * c - z * b
    out[4] = inertia[5] * d + inertia[7] * e + inertia[8] * f + z * a - x * c
    out[5] = inertia[6] * d + inertia[8] * e + inertia[9] * f + x * b - y * a


def gather_inertias(mass, centres, inertias, out):
    """Inertia of all bodies from each joint outwards, about the first joint's origin."""
    out[:] = 0.0
    for k in range(len(mass) - 1, -1, -1):
        x, y, z = centres[k, 0], centres[k, 1], centres[k, 2]
        m = mass[k]
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = m, m * x, m * y, m * z
        out[k, 4] = inertias[k, 0, 0] + m * (y * y + z * z)
        out[k, 5] = inertias[k, 0, 1] - m * x * y
        out[k, 6] = inertias[k, 0, 2] - m * x * z
        out[k, 7] = inertias[k, 1, 1] + m * (x * x + z * z)
        out[k, 8] = inertias[k, 1, 2] - m * y * z
        out[k, 9] = inertias[k, 2, 2] + m * (x * x + y * y)
        if k + 1 < len(mass):
            for e in range(10):
                out[k, e] += out[k + 1, e]
