"""Torques that depend on how far a joint has moved, and on the way there.

Four laws, all zero at rest:

    dry friction (Dahl, AFOSR report 0158, 1968)    dT/dq = σ (1 − (T/T_c) sgn q̇)ⁱ,
    friction that is viscous when slow              T = T_v tanh(q̇/v_t)  (Andersson and others, 2007),
    spring that hardens or softens                  T = a k q u²/(1 + u²),  u = q/q_r, beside k q,
    spring with another slope beyond a deflection   T = A q (1 − 2 d/(√((q − d)² + e²) + √((q + d)² + e²))).

The exponent i says how friction goes over from its spring to sliding: 0 at once, as Jenkins's element does,
1 little by little. Friction is integrated over the distance moved in a step, which is exact while the
direction and the speed hold and stays bounded by T_c at any step. What it slips at may fall with speed,

    T_c(v) = T_c (1 + r exp(−(v/v_s)²))

(Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30, 1994, with Stribeck's speed v_s), and grow with
what the joint carries, by μ k |q + u₀| (Hamon, Gautier and Garrec, IEEE/RSJ IROS, 2010), u₀ what a load at
rest winds its spring up by. What sticks may damp as it bends, T + τ dT/dt: bristles with a stiffness σ and a
damping σ τ (LuGre, Canudas de Wit, Olsson, Åström and Lischinsky, IEEE Trans. Automatic Control 40, 1995). A
spring may be loaded at rest, so that it is wound up by u₀ about which it is not odd: the torque is then the
difference from that at rest, and k stays the stiffness there. The last law is a knee at d, both ways, rounded
over e: nothing before d and A beyond for e = 0, a cubic spring where e is large.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

HARDENING, FRICTION, SLOW, KNEE = 0, 1, 2, 3
"""Codes of the laws in the kernels."""
NUMBERS = 8
"""The most that a law takes."""


@dataclass(frozen=True, eq=False)
class Law:
    """A torque along one row of a structure."""

    row: Float[np.ndarray, "*system dof"]
    """Elongation = row · coordinates [rad, m]."""
    kind: int
    parameters: tuple[float, ...]
    """Of friction T_c, σ, i, r, v_s, τ, μ k, u₀; of a spring a k, q_r, q_r u₀, the linear part on top; of
    what is viscous when slow T_v, v_t; of a knee A, d, u₀, the linear part, e; then zeros."""
    wound: Float[np.ndarray, " system"] | None = None
    """u₀ of a knee where it is not the same in all systems."""

    def of_system(self, k: int) -> Law:
        """In one of the systems, if it is not the same in all.

        Args:
            k: number of the system.
        """
        row, given = self.row if self.row.ndim == 1 else self.row[k], self.parameters
        if self.wound is not None:
            given = (*given[:2], float(self.wound[k]), *given[3:])
        return Law(row, self.kind, given)


def _law(row: Float[np.ndarray, "*system dof"], kind: int, *given: float) -> Law:
    """With zeros for what it does not take."""
    return Law(row, kind, (*given, *(0.0 for _ in range(NUMBERS - len(given)))))


def friction(
    row: Float[np.ndarray, "*system dof"],
    torque: float,
    presliding_stiffness: float,
    exponent: float = 1.0,
    stiction: float = 0.0,
    speed: float = 1.0,
    lag: float = 0.0,
    growing: float = 0.0,
    wound: float = 0.0,
) -> Law:
    """Dry friction.

    Args:
        row: elongation by the coordinates.
        torque: at which it slips when it moves fast [N·m].
        presliding_stiffness: before it does [N·m/rad].
        exponent: i.
        stiction: part of the torque that comes on top at rest, r.
        speed: at which that has fallen to 1/e, v_s [rad/s].
        lag: damping of what sticks over its stiffness, τ [s].
        growing: by how much the limit grows with the elongation from no load, μ k [N·m/rad].
        wound: how far a load has wound the joint up at rest, u₀ [rad].
    """
    given = torque, presliding_stiffness, exponent, stiction, speed, lag, growing, wound
    return _law(row, FRICTION, *given)


def slow_friction(row: Float[np.ndarray, "*system dof"], torque: float, speed: float) -> Law:
    """Friction that grows with speed and levels off.

    Args:
        row: elongation by the coordinates.
        torque: that it comes to [N·m].
        speed: at which three quarters of it are there, v_t [rad/s].
    """
    return _law(row, SLOW, torque, speed)


def linear(row: Float[np.ndarray, "*system dof"], stiffness: float) -> Law:
    """A spring that comes on top of the joint's, whatever the size.

    Args:
        row: elongation by the coordinates.
        stiffness: negative for a joint that is softer [N·m/rad].
    """
    return _law(row, HARDENING, 0.0, 1.0, 0.0, stiffness)


def hardening(
    row: Float[np.ndarray, "*system dof"],
    stiffness: float,
    deflection: float,
    wound: float = 0.0,
    at_rest: float | None = None,
) -> Law:
    """What a spring that hardens has beyond a linear one.

    Args:
        row: elongation by the coordinates.
        stiffness: that comes on top at large elongation; negative if the spring softens [N·m/rad].
        deflection: at which half of it is there, q_r [rad].
        wound: how far a load has wound it up at rest [rad].
        at_rest: stiffness about the point of rest, which is that of the linear spring beside it; where it
            is wound up the whole spring is scaled to have that there [N·m/rad].
    """
    share = (wound / deflection) ** 2
    part = share * (3 + share) / (1 + share) ** 2
    if at_rest is None or part == 0.0:
        return _law(row, HARDENING, stiffness, deflection, wound, -stiffness * part)
    scale = 1 / (1 + stiffness / at_rest * part)
    return _law(row, HARDENING, scale * stiffness, deflection, wound, (scale - 1) * at_rest)


def knee(
    row: Float[np.ndarray, "*system dof"],
    stiffness: float,
    deflection: float,
    softness: float,
    wound: float,
    at_rest: float,
) -> Law:
    """What a spring that has another slope beyond a deflection has beyond a linear one.

    Args:
        row: elongation by the coordinates.
        stiffness: that comes on top far out; negative if the spring softens [N·m/rad].
        deflection: d [rad].
        softness: over how many deflections the knee is rounded, e/d; above 0.
        wound: how far a load has wound it up at rest [rad].
        at_rest: stiffness about the point of rest, as of `hardening` [N·m/rad].
    """
    round_off = float(np.hypot(1.0, softness))
    top, begins = stiffness * round_off, 1 - 1 / round_off  # slope of the law at no load over A
    ends = [
        (wound + way * deflection) / np.hypot(wound + way * deflection, softness * deflection)
        for way in (-1, 1)
    ]
    rise = top * (1 + (ends[0] - ends[1]) / 2 - begins)
    scale = 1 / (1 + rise / at_rest)
    linear = -scale * top * begins + (scale - 1) * at_rest
    return _law(row, KNEE, scale * top, deflection, wound, linear, softness * deflection)


def loaded_knee(
    row: Float[np.ndarray, "*system dof"],
    stiffness: float,
    deflection: float,
    softness: float,
    wound: Float[np.ndarray, " system"],
) -> Law:
    """The same where the linear spring beside it is that at no load, and the load another one in each system.

    Args:
        row: elongation by the coordinates.
        stiffness: that comes on top far out; negative if the spring softens [N·m/rad].
        deflection: d [rad].
        softness: over how many deflections the knee is rounded.
        wound: how far a load has wound it up at rest [rad].
    """
    round_off = float(np.hypot(1.0, softness))
    top = stiffness * round_off
    law = _law(row, KNEE, top, deflection, 0.0, -top * (1 - 1 / round_off), softness * deflection)
    return replace(law, wound=wound)
