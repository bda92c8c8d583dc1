"""A vibrating structure with its derivatives, and its receptance: what every fit evaluates.

    Z(s) = K + h(s) H + s C + s² M,    α_uv = u Z⁻¹ vᵀ,    ∂α_uv = ∂u y_v + y_uᵀ ∂vᵀ − y_uᵀ ∂Z y_v,

with y = Z⁻¹ jᵀ solved once for each row [m/N for translations], at s = iω, or s = iω + σ where an exponential
window exp(−σt) was put on the records. H is the stiffness of hysteretic springs. K (1 + iη) with the
same η at every frequency is not causal unless the real part grows with frequency (Kramers and Kronig). The
causal spring of constant loss factor is a power law (Bagley and Torvik, J. Rheology 27, 1983),

    K(s) = K (s/ω₀)^β / cos(βπ/2),   β = (2/π) arctan η,   h = K(s)/K − 1,

whose real part is K at ω₀, here the middle of the band on a logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import SingularResponse

ROUNDING = 1e-12
"""Part of the sum of its terms' sizes from which on a receptance is not zero."""


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
    cut_slopes: bool = True
    """Whether derivatives look at what the end of a record cuts off; values always do."""

    def __len__(self) -> int:
        """How many lines."""
        return len(self.frequency)

    @cached_property
    def s(self) -> Complex[np.ndarray, " line"]:
        """Complex frequency [rad/s]."""
        return 2j * np.pi * self.frequency + self.decay

    def hysteresis(
        self, loss_factor: float
    ) -> tuple[Complex[np.ndarray, " line"], Complex[np.ndarray, " line"]]:
        """h, the factor of H, and its derivative along the loss factor."""
        exponent = 2 / np.pi * np.arctan(loss_factor)
        log = np.log(self.s / (2 * np.pi * self.middle))
        size = np.exp(exponent * log) / np.cos(exponent * np.pi / 2)
        slope = size * (log + np.pi / 2 * loss_factor) * (2 / np.pi) / (1 + loss_factor**2)
        return size - 1, slope

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
    loss_factor: float | None = None

    def __add__(self, other: Change) -> Change:
        """Both."""
        pairs = (
            (getattr(self, name), getattr(other, name))
            for name in ("mass", "damping", "stiffness", "loss", "response", "reference", "loss_factor")
        )
        return Change(*(b if a is None else a if b is None else a + b for a, b in pairs))


def changed(slots: Mapping[str, np.ndarray], loss_factor: float | None = None) -> Change:
    """A change from matrices and rows by name.

    Args:
        slots: derivatives of the matrices and rows that change, by their name in `Change`.
        loss_factor: derivative of η; None where it does not change.
    """
    return Change(
        slots.get("mass"),
        slots.get("damping"),
        slots.get("stiffness"),
        slots.get("loss"),
        slots.get("response"),
        slots.get("reference"),
        loss_factor,
    )


@dataclass(frozen=True, eq=False)
class Structure:
    """Matrices and rows in one posture."""

    coordinates: tuple[str, ...]
    mass: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    stiffness: Float[np.ndarray, "dof dof"]
    loss: Float[np.ndarray, "dof dof"]
    """H [N·m/rad]: stiffness of the hysteretic springs, which is in `stiffness` too."""
    response: Float[np.ndarray, "response dof"]
    reference: Float[np.ndarray, "reference dof"]
    changes: Mapping[str, Change] = field(default_factory=dict)
    """Derivatives along the coordinates of parameters, by name."""
    loss_factor: float = 0.0
    """η of the hysteretic springs."""

    @property
    def dof(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    def dynamic_stiffness(self, axis: Axis) -> Complex[np.ndarray, "line dof dof"]:
        """Z on a frequency axis."""
        s = axis.s[:, None, None]
        z = self.stiffness + s * (self.damping + s * self.mass)
        if self.loss_factor:
            z += axis.hysteresis(self.loss_factor)[0][:, None, None] * self.loss
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

    What is nothing but rounding, where a point does not move along its axis at all, is exactly zero.

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
    right = _by_pair(yv, v)  # [dof, pair, line]
    rows = structure.response[u]
    value = np.einsum("pd,dpl->pl", rows, right)
    size = np.einsum("pd,dpl->pl", np.abs(rows), np.abs(right))
    value[np.abs(value) <= ROUNDING * size] = 0.0
    slopes = np.zeros((len(names), *value.shape), dtype=complex)
    moving = [(k, structure.changes[name]) for k, name in enumerate(names) if name in structure.changes]
    if not moving:
        return value, slopes
    index = np.array([k for k, _ in moving])
    few, many, across, along = (v, u, yv, yu) if yv.shape[2] <= yu.shape[2] else (u, v, yu, yv)
    pulls = _pulls(structure, axis, [change for _, change in moving])
    for row in np.unique(few):  # dZ goes with the side that has fewer rows
        y, where = np.ascontiguousarray(across[:, :, row]), np.flatnonzero(few == row)
        force = np.zeros((len(axis), len(moving) * structure.dof), dtype=complex)
        for factor, columns, matrices in pulls:
            force[:, columns] += (y @ matrices) * factor
        found = force.reshape(len(axis), len(moving), -1) @ along[:, :, many[where]]
        slopes[index[:, None], where] = found.transpose(1, 2, 0)
    if any(change.reference is not None for _, change in moving):
        left = _by_pair(yu, u)
    for k, change in moving:
        if change.response is not None:
            slopes[k] += np.einsum("pd,dpl->pl", change.response[u], right)
        if change.reference is not None:
            slopes[k] += np.einsum("pd,dpl->pl", change.reference[v], left)
    return value, slopes


def _by_pair(solved: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Solutions [line, dof, row] of some rows as [dof, pair, line]."""
    return np.ascontiguousarray(solved.transpose(1, 2, 0))[:, rows]


def _pulls(
    structure: Structure, axis: Axis, changes: Sequence[Change]
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """−∂Z of all changes, kind by kind: factors by line, columns (change · dof), matrices side by side."""
    n = structure.dof
    grown, growth = axis.hysteresis(structure.loss_factor)
    factors = {"mass": axis.s**2, "damping": axis.s, "stiffness": np.ones(len(axis)), "loss": grown}
    found = []
    for kind, factor in factors.items():
        some = [(k, matrix) for k, one in enumerate(changes) if (matrix := getattr(one, kind)) is not None]
        if some:
            columns = (np.array([k for k, _ in some])[:, None] * n + np.arange(n)).ravel()
            stacked = np.concatenate([matrix for _, matrix in some])  # symmetric, one below the other
            found.append((-factor[:, None], columns, stacked.T.astype(complex)))
    for k, one in enumerate(changes):
        if one.loss_factor is not None:
            factor = -one.loss_factor * growth[:, None]
            found.append((factor, k * n + np.arange(n), structure.loss.astype(complex)))
    return found
