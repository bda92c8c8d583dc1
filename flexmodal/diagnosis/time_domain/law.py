"""Torques that depend on how far a joint has moved, and on the way there.

Two laws, both zero at rest:

    dry friction (Dahl, AFOSR report 0158, 1968)    dT/dq = σ (1 − (T/T_c) sgn q̇)ⁱ,
    spring that hardens or softens                  T = a k q u²/(1 + u²),  u = q/q_r, beside k q.

The exponent i says how friction goes over from its spring to sliding: 0 at once, as Jenkins's element does,
1 little by little. Friction is integrated over the distance moved in a step, which is exact while the
direction holds and stays bounded by T_c at any step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

HARDENING, FRICTION = 0, 1
"""Codes of the laws in the kernels."""


@dataclass(frozen=True, eq=False)
class Law:
    """A torque along one row of a structure."""

    row: Float[np.ndarray, "*system dof"]
    """Elongation = row · coordinates [rad, m]."""
    kind: int
    parameters: tuple[float, float, float]

    def of_system(self, k: int) -> Law:
        """In one of the systems, if its row is not the same in all."""
        return self if self.row.ndim == 1 else replace(self, row=self.row[k])


def friction(
    row: Float[np.ndarray, "*system dof"], torque: float, presliding_stiffness: float, exponent: float = 1.0
) -> Law:
    """Dry friction.

    Args:
        row: elongation by the coordinates.
        torque: at which it slips [N·m].
        presliding_stiffness: before it does [N·m/rad].
        exponent: i.
    """
    return Law(row, FRICTION, (torque, presliding_stiffness, exponent))


def hardening(row: Float[np.ndarray, "*system dof"], stiffness: float, deflection: float) -> Law:
    """What a spring that hardens has beyond a linear one.

    Args:
        row: elongation by the coordinates.
        stiffness: that comes on top at large elongation; negative if the spring softens [N·m/rad].
        deflection: at which half of it is there, q_r [rad].
    """
    return Law(row, HARDENING, (stiffness, deflection, 0.0))
