"""Receptance α_uv(ω) = j_u Z(ω)⁻¹ j_vᵀ with Z = K − ω²M + iωC, and the modal sum that must agree with it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import DefectiveModes
from flexmodal.frf.kernels.route import WORTH_A_CALL, choose, has_numba, run
from flexmodal.frf.kernels.task import SINGULAR, Task, is_damped, refuse_singular, singular
from flexmodal.modal import Hysteresis, Modes, SecondOrderSystem

_MOST_PAIRS = 36
"""Most receptances that elimination with the rows pays for; beyond, one factorisation serves them all."""

_FEW_LINES = 1000
"""Lines up to which one factorisation of the stack is quicker than elimination in numpy."""

_BLOCK = 4096
"""Frequencies solved at once there: bounds the memory for the stacked matrices."""


def dynamic_stiffness(
    system: SecondOrderSystem, frequency: Float[np.ndarray, " line"]
) -> Complex[np.ndarray, "line dof dof"]:
    """Z(ω) = K − ω²M + iωC, and what hysteretic springs add; complex symmetric [N·m/rad, N/m].

    Args:
        system: mass, damping and stiffness.
        frequency: of the lines [Hz].
    """
    omega = 2 * np.pi * frequency[:, None, None]
    z = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    if system.hysteresis is not None:
        places = np.arange(system.dof)
        z[:, places, places] += system.hysteresis.added(2j * np.pi * frequency)
    return z


def receptance(
    system: SecondOrderSystem,
    response: Float[np.ndarray, "response dof"],
    reference: Float[np.ndarray, "reference dof"],
    frequency: Float[np.ndarray, " line"],
) -> Complex[np.ndarray, "line response reference"]:
    """Receptance matrix between two sets of rows by elimination, compiled where that pays.

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
    lines = len(frequency)
    few = lines < WORTH_A_CALL or (lines < _FEW_LINES and not has_numba())
    if few or len(response) * len(reference) > _MOST_PAIRS:
        return _by_factorisation(system, response, reference, frequency)
    same = response.shape == reference.shape and np.array_equal(response, reference)
    rows = response if same else np.concatenate([response, reference])
    pairs = tuple(
        (i, j if same else len(response) + j)
        for i in range(len(response))
        for j in range(i if same else 0, len(reference))
    )
    task = Task(
        count=1,
        block=lambda _: (system.mass[None], rows[None]),
        stiffness=system.stiffness,
        damping=system.damping,
        hysteresis=np.zeros_like(system.mass),
        pairs=pairs,
        omega=2 * np.pi * frequency,
        addition=hysteretic_addition(system.hysteresis, frequency),
    )
    route = choose(task, None)
    if route.way == "LAPACK" or (route.way == "numpy" and lines < _FEW_LINES):
        return _by_factorisation(system, response, reference, frequency)
    values = run(task, route)[0]
    result = np.empty((len(frequency), len(response), len(reference)), dtype=complex)
    for place, (i, j) in enumerate(pairs):
        column = j if same else j - len(response)
        result[:, i, column] = values[:, place]
        if same:
            result[:, column, i] = values[:, place]
    return result


def hysteretic_addition(
    hysteresis: Hysteresis | None, frequency: Float[np.ndarray, " line"]
) -> Complex[np.ndarray, "line dof dof"] | None:
    """What hysteretic springs add to Z [N·m/rad, N/m]; None without any.

    Args:
        hysteresis: springs that lose energy.
        frequency: of the lines [Hz].
    """
    if hysteresis is None:
        return None
    added = hysteresis.added(2j * np.pi * frequency)
    places = np.arange(added.shape[1])
    full = np.zeros((*added.shape, added.shape[1]), dtype=complex)
    full[:, places, places] = added
    return full


def _by_factorisation(
    system: SecondOrderSystem, response: np.ndarray, reference: np.ndarray, frequency: np.ndarray
) -> np.ndarray:
    blocks = []
    for start in range(0, len(frequency), _BLOCK):
        part = frequency[start : start + _BLOCK]
        stack, omega = dynamic_stiffness(system, part), 2 * np.pi * part
        exposed = np.flatnonzero(part == 0) if is_damped(system.damping) else np.arange(len(part))
        terms = (np.diag(term) for term in (system.stiffness, system.mass, system.damping))
        size = sum(term * omega[:, None] ** power for term, power in zip(terms, (0, 2, 1), strict=True))
        refuse_singular(stack[exposed], np.asarray(size)[exposed], omega[exposed])
        blocks.append(response @ np.linalg.solve(stack, reference.T.astype(complex)[None]))
    return np.concatenate(blocks)


def modal_sum(
    modes: Modes,
    response: Float[np.ndarray, "response dof"],
    reference: Float[np.ndarray, "reference dof"],
    frequency: Float[np.ndarray, " line"],
) -> Complex[np.ndarray, "line response reference"]:
    """Receptance as the sum over all 2n poles, α = Σ φ_u φ_v / (iω − λ_p) [Hearne 2.40].

    Args:
        modes: poles and shapes.
        response: rows of the responses.
        reference: rows of the forces.
        frequency: of the lines [Hz].

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
    at_pole = np.abs(driven - poles) <= SINGULAR * np.abs(poles)
    if np.any(at_pole):
        raise singular(2 * np.pi * float(frequency[int(np.argmax(np.any(at_pole, axis=1)))]))
    return np.einsum("rp,lp,sp->lrs", response @ shapes, 1 / (driven - poles), reference @ shapes)
