"""Receptance α_uv(ω) = j_u Z(ω)⁻¹ j_vᵀ with Z = K − ω²M + iωC, and the modal sum that must agree with it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import DefectiveModes, SingularResponse
from flexmodal.modal import Modes, SecondOrderSystem

_BLOCK = 4096
"""Frequencies solved at once: bounds the memory for the stacked matrices."""

_SINGULAR = 1e-13
"""Smallest singular value of the scaled dynamic stiffness below which the response counts as infinite."""


def dynamic_stiffness(
    system: SecondOrderSystem, frequency: Float[np.ndarray, " line"]
) -> Complex[np.ndarray, "line dof dof"]:
    """Z(ω) = K − ω²M + iωC, complex symmetric [N·m/rad, N/m]."""
    omega = 2 * np.pi * frequency[:, None, None]
    return system.stiffness - omega**2 * system.mass + 1j * omega * system.damping


def receptance(
    system: SecondOrderSystem,
    response: Float[np.ndarray, "response dof"],
    reference: Float[np.ndarray, "reference dof"],
    frequency: Float[np.ndarray, " line"],
) -> Complex[np.ndarray, "line response reference"]:
    """Receptance matrix between two sets of rows by a direct solve.

    Holds at any posture, damping and frequency, critical damping and 0 Hz included.

    Args:
        system: mass, damping, stiffness.
        response: Jacobian rows of the responses.
        reference: Jacobian rows of the forces.
        frequency: checked frequency axis [Hz].

    Returns:
        Displacement per force [m/N, rad/N, …], by line, response and reference.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency, or a free one at 0 Hz.
    """
    undamped = (
        float(np.min(np.linalg.eigvalsh(_scaled(system.damping, np.diag(system.damping))))) <= _SINGULAR
    )
    blocks = []
    for start in range(0, len(frequency), _BLOCK):
        part = frequency[start : start + _BLOCK]
        stack = dynamic_stiffness(system, part)
        exposed = len(part) if undamped else int(part[0] == 0)  # damping holds everything but 0 Hz
        _refuse_resonance(stack[:exposed], part[:exposed], system)
        blocks.append(response @ np.linalg.solve(stack, reference.T.astype(complex)[None]))
    return np.concatenate(blocks)


def _scaled(matrix: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    return matrix * scale[..., :, None] * scale[..., None, :]


def _refuse_resonance(stack: np.ndarray, frequency: np.ndarray, system: SecondOrderSystem) -> None:
    """Without full damping Z can be singular; find it before the solver returns 10¹⁰ or fails."""
    if len(frequency) == 0:
        return
    omega = 2 * np.pi * frequency[:, None]
    stiffness, mass, damping = (np.diag(part) for part in (system.stiffness, system.mass, system.damping))
    # Against its own terms at its own line, so that neither the rest of the axis, nor a stiffer joint, nor
    # all the modes meeting at one frequency changes the verdict.
    scaled = _scaled(stack, stiffness + omega**2 * mass + omega * damping)
    smallest = np.linalg.svd(scaled, compute_uv=False)[:, -1]
    worst = int(np.argmin(smallest))
    if smallest[worst] <= _SINGULAR:
        raise _infinite(frequency[worst])


def _infinite(frequency: float) -> SingularResponse:
    return SingularResponse(
        f"the receptance is infinite at {frequency:.9g} Hz: an undamped mode is driven at its "
        "natural frequency; give the joints damping or leave this frequency out"
    )


def modal_sum(
    modes: Modes,
    response: Float[np.ndarray, "response dof"],
    reference: Float[np.ndarray, "reference dof"],
    frequency: Float[np.ndarray, " line"],
) -> Complex[np.ndarray, "line response reference"]:
    """Receptance as the sum over all 2n poles, α = Σ φ_u φ_v / (iω − λ_p) [Hearne 2.40].

    Raises:
        DefectiveModes: critically damped poles, for which no such sum exists.
        SingularResponse: an undamped mode is driven at its natural frequency, or a free one at 0 Hz.
    """
    if modes.is_defective:
        raise DefectiveModes(
            "critically damped poles have no modal expansion; use the direct solve, which needs none"
        )
    poles, shapes = modes.expanded()
    driven = 2j * np.pi * frequency[:, None]
    at_pole = np.abs(driven - poles) <= _SINGULAR * np.abs(poles)
    if np.any(at_pole):
        raise _infinite(frequency[int(np.argmax(np.any(at_pole, axis=1)))])
    return np.einsum("rp,lp,sp->lrs", response @ shapes, 1 / (driven - poles), reference @ shapes)
