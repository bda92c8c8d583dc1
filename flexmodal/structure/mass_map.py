"""The linear map of masses and moments of inertia to the mass matrix [Hearne 2.51–2.52].

    D(q) = Σ_i m_i J_iᵀJ_i + I_i W_iᵀ R_i Î_i R_iᵀ W_i,    vec D = [ML] μ,

with J_i the Jacobian of the mass centre, W_i of the rotation, Î_i the link's inertia tensor over the moment
I_i that names its size. Mass centres stay where the card has them. Given D at some postures, μ follows by
linear least squares; `tests/agreement` holds the map against Pinocchio's regressor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.structure.arm import Arm, carried


@dataclass(frozen=True, eq=False)
class MassMap:
    """[ML] at one posture."""

    links: tuple[str, ...]
    """Links with mass, in the order of the URDF; μ holds their masses [kg], then their moments [kg·m²]."""
    matrix: Float[np.ndarray, "entry unknown"]
    """Upper triangle of D, row by row, over μ."""
    card: Float[np.ndarray, " unknown"]
    """μ as the card says."""
    dof: int

    def mass(self, mu: Float[np.ndarray, " unknown"]) -> Float[np.ndarray, "dof dof"]:
        """D of masses and moments [kg·m²]."""
        found = np.zeros((self.dof, self.dof))
        upper = np.triu_indices(self.dof)
        found[upper] = self.matrix @ mu
        return found + np.triu(found, 1).T


def mass_map(arm: Arm) -> MassMap:
    """The map at a posture; the moment of a link is the largest of its tensor's diagonal."""
    links, masses, moments, columns = [], [], [], []
    upper = np.triu_indices(len(arm.robot.joints))
    turning = []
    for link, body in arm.bodies.items():
        axes = arm.placed[link][:3, :3]
        motion = carried(arm.maps[link], axes @ body.centre)
        moment = moment_of(body.inertia)
        shape = body.inertia / moment if moment > 0 else np.zeros((3, 3))
        links.append(link)
        masses.append(body.mass)
        moments.append(moment)
        columns.append((motion[:3].T @ motion[:3])[upper])
        turning.append((motion[3:].T @ axes @ shape @ axes.T @ motion[3:])[upper])
    matrix = np.column_stack([*columns, *turning])
    return MassMap(tuple(links), matrix, np.array([*masses, *moments]), len(arm.robot.joints))


def moment_of(inertia: Float[np.ndarray, "3 3"]) -> float:
    """The moment that a tensor is scaled by: the largest of its diagonal [kg·m²]."""
    return float(np.max(np.diag(inertia)))
