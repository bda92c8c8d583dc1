"""A vibrating structure with its derivatives, and its receptance: what every fit evaluates.

    Z(s) = K + h H + s C + s² M,    α_uv = u Z⁻¹ vᵀ,    ∂α_uv = ∂u y_v + y_uᵀ ∂vᵀ − y_uᵀ ∂Z y_v,

with y = Z⁻¹ jᵀ solved once for each row [m/N for translations], at s = iω, or s = iω + σ where an exponential
window exp(−σt) was put on the records. H is hysteretic stiffness. A constant loss factor is not causal by
itself; what goes with it is a stiffness that grows with ln ω (Kramers and Kronig; see Nashif, Jones and
Henderson, Vibration Damping, 1985), so h(ω) = i + (2/π) ln(ω/ω₀) with ω₀ the middle of the band on a
logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import SingularResponse


@dataclass(frozen=True, eq=False)
class Axis:
    """Where structures are evaluated."""

    frequency: Float[np.ndarray, " line"]
    """[Hz]"""
    middle: float
    """Where hysteretic stiffness has its nominal real part [Hz]."""
    decay: float = 0.0
    """Of an exponential window on the records [1/s]."""
    length: float = 0.0
    """Of the records, from the blow to their end [s]; 0 where it is not known or does not matter."""
    power: int = 2
    """What was recorded: acceleration 2, velocity 1, displacement 0."""

    def __len__(self) -> int:
        """How many lines."""
        return len(self.frequency)

    @cached_property
    def s(self) -> Complex[np.ndarray, " line"]:
        """Complex frequency [rad/s]."""
        return 2j * np.pi * self.frequency + self.decay

    @cached_property
    def hysteresis(self) -> Complex[np.ndarray, " line"]:
        """h, the factor of H."""
        return 1j + 2 / np.pi * np.log(np.maximum(self.frequency, 1e-12) / self.middle)

    def take(self, lines: slice | np.ndarray) -> Axis:
        """Some of the lines."""
        return replace(self, frequency=self.frequency[lines])


@dataclass(frozen=True, eq=False)
class Change:
    """Derivative of a structure along one coordinate of the parameter space; None where nothing changes."""

    mass: np.ndarray | None = None
    damping: np.ndarray | None = None
    stiffness: np.ndarray | None = None
    loss: np.ndarray | None = None
    response: np.ndarray | None = None
    reference: np.ndarray | None = None

    def __add__(self, other: Change) -> Change:
        """Both."""
        pairs = (
            (getattr(self, name), getattr(other, name))
            for name in ("mass", "damping", "stiffness", "loss", "response", "reference")
        )
        return Change(*(b if a is None else a if b is None else a + b for a, b in pairs))


@dataclass(frozen=True, eq=False)
class Structure:
    """Matrices and rows in one posture."""

    coordinates: tuple[str, ...]
    mass: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    stiffness: Float[np.ndarray, "dof dof"]
    loss: Float[np.ndarray, "dof dof"]
    """H [N·m/rad]: loss factor times stiffness."""
    response: Float[np.ndarray, "response dof"]
    reference: Float[np.ndarray, "reference dof"]
    changes: Mapping[str, Change] = field(default_factory=dict)
    """Derivatives along the coordinates of parameters, by name."""

    @property
    def dof(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    def dynamic_stiffness(self, axis: Axis) -> Complex[np.ndarray, "line dof dof"]:
        """Z on a frequency axis."""
        s = axis.s[:, None, None]
        z = self.stiffness + s * (self.damping + s * self.mass)
        if self.loss.any():
            z += axis.hysteresis[:, None, None] * self.loss
        return z

    def solve(
        self, axis: Axis
    ) -> tuple[Complex[np.ndarray, "line dof response"], Complex[np.ndarray, "line dof reference"]]:
        """Solve y of every response and reference row.

        Raises:
            SingularResponse: an undamped mode is driven at its natural frequency.
        """
        rows = np.concatenate([self.response, self.reference])
        right = np.broadcast_to(rows.T.astype(complex), (len(axis), *rows.T.shape))
        try:
            y = np.linalg.solve(self.dynamic_stiffness(axis), right)
        except np.linalg.LinAlgError:
            raise SingularResponse(
                "the receptance is infinite here: an undamped mode is driven at its natural frequency"
            ) from None
        return y[:, :, : len(self.response)], y[:, :, len(self.response) :]


def receptance(
    structure: Structure, axis: Axis, pairs: np.ndarray, names: tuple[str, ...] = ()
) -> tuple[Complex[np.ndarray, "pair line"], Complex[np.ndarray, "name pair line"]]:
    """Receptances of some pairs of rows, and their derivatives along some parameters.

    Args:
        structure: in one posture.
        axis: where.
        pairs: [pair, 2], numbers of a response and a reference row.
        names: parameters; those the structure does not depend on give zeros.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    yu, yv = structure.solve(axis)
    u, v = pairs[:, 0], pairs[:, 1]
    left, right = np.moveaxis(yu, 2, 0)[u], np.moveaxis(yv, 2, 0)[v]  # [pair, line, dof]
    value = np.einsum("pd,pld->pl", structure.response[u], right)
    slopes = np.zeros((len(names), *value.shape), dtype=complex)
    if not names:
        return value, slopes
    moving = [(k, structure.changes[name]) for k, name in enumerate(names) if name in structure.changes]
    n = structure.dof
    upper = np.triu_indices(n)
    outer = left[..., upper[0]] * right[..., upper[1]]
    off = upper[0] != upper[1]
    outer[..., off] += left[..., upper[1][off]] * right[..., upper[0][off]]
    flat = outer.reshape(-1, len(upper[0]))
    factors = {
        "mass": -(axis.s**2),
        "damping": -axis.s,
        "stiffness": np.full(len(axis), -1.0 + 0j),
        "loss": -axis.hysteresis,
    }
    for kind, factor in factors.items():
        some = [(k, matrix) for k, change in moving if (matrix := getattr(change, kind)) is not None]
        if some:
            stacked = np.array([matrix[upper] for _, matrix in some]).T  # symmetric: the upper half is all
            found = (flat @ stacked.astype(complex)).reshape(*value.shape, -1)
            slopes[[k for k, _ in some]] += np.moveaxis(found, 2, 0) * factor
    for k, change in moving:
        if change.response is not None:
            slopes[k] += np.einsum("pd,pld->pl", change.response[u], right)
        if change.reference is not None:
            slopes[k] += np.einsum("pd,pld->pl", change.reference[v], left)
    return value, slopes
