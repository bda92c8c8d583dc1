"""Modes of a system with hysteretic springs: (λ²M + λC + K(λ)) u = 0.

K(λ) is held while a quadratic pencil is solved, and taken again at the pole found, until that stays. Shapes
are scaled to uᵀ(2λM + C + ∂K/∂λ)u = 1, so that the product of what two rows see of u is the residue at the
pole. Poles are not all there is to the receptance of such a system; near a light resonance they are.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.modal.hysteresis import Hysteresis
from flexmodal.modal.system import SecondOrderSystem

_ROUNDS = 60
_SETTLED = 1e-12
"""Relative change of a pole that ends the rounds."""


def with_hysteresis(
    system: SecondOrderSystem,
    pole: Complex[np.ndarray, " mode"],
    shape: Complex[np.ndarray, "dof mode"],
    condition: Float[np.ndarray, " mode"],
) -> tuple[Complex[np.ndarray, " mode"], Complex[np.ndarray, "dof mode"], Float[np.ndarray, " mode"]]:
    """Modes with the loss of hysteretic springs, from those without, in the order of |pole|.

    A mode that does not settle, as may happen to an overdamped one, stays as it is and counts as defective.

    Args:
        system: the matrices, and the springs that lose energy if it has any.
        pole: poles without the loss [rad/s].
        shape: their displacement shapes.
        condition: how much a relative change of the matrices is amplified in each pole.

    Returns:
        Poles, shapes and conditions with the loss.
    """
    hysteresis = system.hysteresis
    if hysteresis is None or not np.any(hysteresis.loss_factor):
        return pole, shape, condition
    pole, shape, condition = pole.copy(), shape.copy(), condition.copy()
    for mode in range(len(pole)):
        found = _settle(system, hysteresis, complex(pole[mode]), shape[:, mode])
        if found is None:
            condition[mode] = np.inf
        else:
            pole[mode], shape[:, mode] = found
    order = np.lexsort((pole.real, np.abs(pole)))
    return pole[order], shape[:, order], condition[order]


def _settle(
    system: SecondOrderSystem, hysteresis: Hysteresis, pole: complex, shape: np.ndarray
) -> tuple[complex, np.ndarray] | None:
    """One pole with its shape; None where it does not settle in the upper half plane."""
    mass, damping, count = system.mass, system.damping, system.dof
    inverse = np.linalg.inv(mass)
    for _ in range(_ROUNDS):
        stiffness = system.stiffness + np.diag(hysteresis.added(np.array([pole]))[0])
        upper = np.hstack([np.zeros((count, count)), np.eye(count)])
        values, vectors = np.linalg.eig(np.vstack([upper, -inverse @ np.hstack([stiffness, damping])]))
        found, own = _sized(vectors[:count], mass), _sized(shape[:, None], mass)[:, 0]
        # orthogonality of a quadratic pencil singles the mode out, however near the next pole is
        felt = np.abs((own @ mass @ found) * (pole + values) + own @ damping @ found)
        felt = np.where(values.imag > 0, felt / (np.abs(values) + abs(pole)), -1.0)
        best = int(np.argmax(felt))
        if felt[best] < 0:
            return None
        change = abs(values[best] - pole)
        pole, shape = complex(values[best]), found[:, best]
        if change <= _SETTLED * abs(pole):
            turned = np.diag(hysteresis.slope(np.array([pole]))[0])
            size = complex(shape @ (2 * pole * mass + damping + turned) @ shape)
            return (pole, shape / np.sqrt(size)) if abs(size) > 0 else None
    return None


def _sized(shapes: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Shapes scaled to uᴴMu = 1."""
    size = np.sqrt(np.einsum("im,ij,jm->m", shapes.conj(), mass, shapes).real)
    return shapes / np.where(size > 0, size, 1.0)
