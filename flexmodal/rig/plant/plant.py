"""The structure as it stands in one posture: what the hammer strikes and the sensors ride on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

HARDENING, FRICTION, BACKLASH = 0, 1, 2
"""Kinds of non-linear element; see `kernel`."""


@dataclass(frozen=True)
class Branch:
    """A spring and a damper in a row, beside other springs: one Maxwell element."""

    row: Float[np.ndarray, " dof"]
    """Elongation = row · x."""
    stiffness: float
    """[N/m, N·m/rad]"""
    time: float
    """Relaxation time, damper over spring [s]."""


@dataclass(frozen=True)
class NonlinearElement:
    """A force that depends on an elongation and its history."""

    row: Float[np.ndarray, " dof"]
    kind: int
    parameters: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Plant:
    """M ẍ + C ẋ + K x + branches + non-linear elements = forces; small motions about the posture."""

    coordinates: tuple[str, ...]
    mass: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    stiffness: Float[np.ndarray, "dof dof"]
    branches: tuple[Branch, ...]
    elements: tuple[NonlinearElement, ...]
    motion: Callable[[str, Float[np.ndarray, "3"]], Float[np.ndarray, "6 dof"]]
    """Motion of a point of a link, by link name and place in its frame [m]; world axes."""
    orientation: Callable[[str], Float[np.ndarray, "3 3"]]
    """Axes of a link in the world."""

    @property
    def dof(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    def row(
        self, link: str, place: Float[np.ndarray, "3"], direction: Float[np.ndarray, "3"]
    ) -> Float[np.ndarray, " dof"]:
        """Motion of a point along a world direction, as a row over the coordinates.

        Args:
            link: which.
            place: in its frame [m].
            direction: unit vector in the world.
        """
        return direction @ self.motion(link, place)[:3]

    @cached_property
    def branch_rows(self) -> Float[np.ndarray, "branch dof"]:
        """Elongations of the Maxwell elements."""
        return np.array([branch.row for branch in self.branches]).reshape(-1, self.dof)

    @cached_property
    def element_rows(self) -> Float[np.ndarray, "element dof"]:
        """Elongations of the non-linear elements."""
        return np.array([element.row for element in self.elements]).reshape(-1, self.dof)

    @cached_property
    def state_matrix(self) -> Float[np.ndarray, "state state"]:
        """A of ṡ = A s + …, with s = coordinates, velocities, damper elongations of the branches.

        A branch pulls with k_b (row·x − r) where its damper's elongation r follows ṙ = (row·x − r)/τ.
        """
        n, rows = self.dof, self.branch_rows
        k = np.array([branch.stiffness for branch in self.branches])
        rate = np.array([1 / branch.time for branch in self.branches])
        stiffness = self.stiffness + rows.T @ (k[:, None] * rows)
        a = np.zeros((2 * n + len(k), 2 * n + len(k)))
        a[:n, n : 2 * n] = np.eye(n)
        a[n : 2 * n] = np.linalg.solve(self.mass, np.hstack([-stiffness, -self.damping, rows.T * k]))
        a[2 * n :, :n] = rate[:, None] * rows
        a[2 * n :, 2 * n :] = -np.diag(rate)
        return a

    def input_column(self, row: Float[np.ndarray, "*many dof"]) -> Float[np.ndarray, "*many state"]:
        """How a force along `row` enters the state: M⁻¹ rowᵀ among the velocities."""
        column = np.zeros((*row.shape[:-1], len(self.state_matrix)))
        column[..., self.dof : 2 * self.dof] = np.linalg.solve(
            self.mass, row.reshape(-1, self.dof).T
        ).T.reshape(row.shape)
        return column

    def output_row(self, row: Float[np.ndarray, "*many dof"]) -> Float[np.ndarray, "*many state"]:
        """Acceleration along `row` by the state; a force adds its own share, row M⁻¹ rowᵀ."""
        return row @ self.state_matrix[self.dof : 2 * self.dof]

    def inertance(
        self,
        response: Float[np.ndarray, "response dof"],
        reference: Float[np.ndarray, "reference dof"],
        frequency: Float[np.ndarray, " line"],
    ) -> Complex[np.ndarray, "line response reference"]:
        """Acceleration per force by a direct solve, the non-linear elements left out [m/(s²·N)].

        Args:
            response: rows of the responses.
            reference: rows of the forces.
            frequency: of the lines [Hz].
        """
        omega = 2 * np.pi * frequency[:, None, None]
        z = self.stiffness - omega**2 * self.mass + 1j * omega * self.damping
        for branch in self.branches:
            lag = 1j * omega * branch.time
            z = z + branch.stiffness * lag / (1 + lag) * np.outer(branch.row, branch.row)
        return -(omega**2) * (response @ np.linalg.solve(z, reference.T.astype(complex)[None]))
