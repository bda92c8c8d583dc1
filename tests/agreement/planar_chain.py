"""A planar chain with no library behind it: cumulative angles and M = Σ m JᵀJ + I. Takes complex angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PlanarChain:
    """Bars in a plane; joint angles are relative, positive from the first axis (x) to the second (z)."""

    lengths: Sequence[float]
    masses: Sequence[float]
    inertias: Sequence[float]
    coms: Sequence[float]

    def rows(self, angles: np.ndarray, bar: int, along: float) -> np.ndarray:
        """∂(x, z, angle)/∂q of the point `along` the bar of that number, counted from 0.

        x = Σ l cos θ and z = Σ l sin θ with θ_b = q_0 + … + q_b, so that turning q_k moves the point by
        what lies between joint k and the point.
        """
        theta = np.cumsum(angles)
        reach = [*self.lengths[:bar], along]
        found = np.zeros((3, len(angles)), dtype=np.asarray(angles).dtype)
        for k in range(bar + 1):
            found[0, k] = -sum(reach[b] * np.sin(theta[b]) for b in range(k, bar + 1))
            found[1, k] = sum(reach[b] * np.cos(theta[b]) for b in range(k, bar + 1))
            found[2, k] = 1.0
        return found

    def position(self, angles: np.ndarray, bar: int, along: float) -> np.ndarray:
        """(x, z) of a point of a bar."""
        theta = np.cumsum(angles)
        reach = [*self.lengths[:bar], along]
        x = sum(length * np.cos(turn) for length, turn in zip(reach, theta, strict=False))
        return np.array([x, sum(length * np.sin(turn) for length, turn in zip(reach, theta, strict=False))])

    def tool(self, angles: np.ndarray) -> np.ndarray:
        """Rows x, z and angle of the end of the last bar."""
        return self.rows(angles, len(self.lengths) - 1, self.lengths[-1])

    def mass_matrix(self, angles: np.ndarray) -> np.ndarray:
        """Σ m JᵀJ + I ttᵀ over the bars. Transposes, never conjugates: a complex step passes through."""
        total = np.zeros((len(angles), len(angles)), dtype=np.asarray(angles).dtype)
        for bar, (mass, inertia, com) in enumerate(zip(self.masses, self.inertias, self.coms, strict=True)):
            j = self.rows(angles, bar, com)
            total += mass * j[:2].T @ j[:2] + inertia * np.outer(j[2], j[2])
        return total


# Table 3.7 with unit lengths and mass centres at half length.
SIX_LINK = PlanarChain([1.0] * 6, [10.0] * 6, [0.83] * 6, [0.5] * 6)
SIX_LINK_STIFFNESS = np.array([30000.0, 20000.0, 15000.0, 15000.0, 10000.0, 10000.0])
SIX_LINK_DAMPING = np.full(6, 500.0)

# Table 2.9 with the inferred lengths, joints q1, q2, rho (the pseudo-joint), q3.
FANUC = PlanarChain(
    [0.85, 0.29, 0.78, 0.23], [1.19, 1.0, 1.0, 1.37], [2.0, 3.12, 1.16, 1.37], [0.425, 0.145, 0.39, 0.115]
)
FANUC_STIFFNESS = np.array([559000.0, 20000.0, 199000.0, 202000.0])
FANUC_DAMPING = np.array([1.0, 94.03, 107.58, 1.0])
