"""The structure as it stands in one posture: what the hammer strikes and the sensors ride on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

HARDENING, FRICTION, BACKLASH, POLYNOMIAL, PIECEWISE, SATURATING, SINH, HERTZ = range(8)
STRIBECK, LUGRE, SLIDER, BOUC_WEN, LOADED, DRAGGED, WOUND = range(8, 15)
"""Kinds of non-linear element; see `laws`."""
NUMBERS = 5
"""The most that a law takes."""


@dataclass(frozen=True)
class Branch:
    """A spring and a damper in a row, beside other springs: one Maxwell element."""

    row: Float[np.ndarray, " dof"]
    """Elongation = row · x."""
    stiffness: float
    """[N/m, N·m/rad]"""
    time: float
    """Relaxation time, damper over spring [s]."""


@dataclass(frozen=True, eq=False)
class Feedback:
    """A linear force with a memory of its own, such as a control loop.

    With u = sensed · x: ż = A z + b u + b_rate u̇, and − (c · z + d u + d_rate u̇) acts along `driven`.
    """

    sensed: Float[np.ndarray, " dof"]
    driven: Float[np.ndarray, " dof"]
    a: Float[np.ndarray, "inner inner"]
    b: Float[np.ndarray, " inner"]
    b_rate: Float[np.ndarray, " inner"]
    c: Float[np.ndarray, " inner"]
    d: float = 0.0
    d_rate: float = 0.0

    def stiffness(self, omega: Float[np.ndarray, " line"]) -> Complex[np.ndarray, " line"]:
        """Force over elongation at angular frequencies [rad/s]."""
        s = 1j * omega
        inner = np.linalg.solve(
            s[:, None, None] * np.eye(len(self.a)) - self.a, (self.b + s[:, None] * self.b_rate)[..., None]
        )[..., 0]
        return inner @ self.c + self.d + s * self.d_rate


@dataclass(frozen=True)
class NonlinearElement:
    """A force that depends on an elongation and its history."""

    row: Float[np.ndarray, " dof"]
    kind: int
    parameters: tuple[float, ...]
    """At most `NUMBERS` of them, as its law takes them."""


@dataclass(frozen=True, eq=False)
class Plant:
    """M ẍ + C ẋ + K x + branches + non-linear elements = forces; small motions about the posture."""

    coordinates: tuple[str, ...]
    mass: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    stiffness: Float[np.ndarray, "dof dof"]
    branches: tuple[Branch, ...]
    feedbacks: tuple[Feedback, ...]
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
        """A of ṡ = A s + …: coordinates, velocities, damper elongations of the branches, then feedbacks.

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
        return self._fed_back(a) if self.feedbacks else a

    def _fed_back(self, a: np.ndarray) -> np.ndarray:
        """The same with the states of the feedbacks after the others."""
        n, have = self.dof, len(a)
        inner = sum(len(feedback.a) for feedback in self.feedbacks)
        a = np.pad(a, [(0, inner), (0, inner)])
        for feedback in self.feedbacks:
            own = slice(have, have + len(feedback.a))
            a[own, own] = feedback.a
            a[own, :n] = np.outer(feedback.b, feedback.sensed)
            a[own, n : 2 * n] = np.outer(feedback.b_rate, feedback.sensed)
            pushed = np.linalg.solve(self.mass, feedback.driven)
            a[n : 2 * n, :n] -= feedback.d * np.outer(pushed, feedback.sensed)
            a[n : 2 * n, n : 2 * n] -= feedback.d_rate * np.outer(pushed, feedback.sensed)
            a[n : 2 * n, own] -= np.outer(pushed, feedback.c)
            have = own.stop
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
        for feedback in self.feedbacks:
            force = feedback.stiffness(omega[:, 0, 0])[:, None, None]
            z = z + force * np.outer(feedback.driven, feedback.sensed)
        return -(omega**2) * (response @ np.linalg.solve(z, reference.T.astype(complex)[None]))
