"""The second-order system M ẍ + C ẋ + K x = f, checked once and read-only ever after."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidSystem
from flexmodal.modal.hysteresis import Hysteresis
from flexmodal.text.shown import Shown, several

_SYMMETRY = 1e-9
"""Largest asymmetry, relative to the largest entry, that counts as rounding."""


@dataclass(frozen=True, eq=False, repr=False)
class SecondOrderSystem(Shown):
    """Mass, damping and stiffness of a passive vibrating system about an equilibrium.

    To hold one is proof that the matrices are finite and symmetric, that the mass matrix is positive
    definite and that damping and stiffness are positive semidefinite. The arrays are private,
    read-only copies.

    Raises:
        InvalidSystem: a matrix is not finite, not square, not symmetric or has the wrong signs; all
            faults at once. The coordinate that carries most of the offending eigenvector is named.
    """

    mass: Float[np.ndarray, "dof dof"]
    """M [kg·m² for angles, kg for lengths]."""
    damping: Float[np.ndarray, "dof dof"]
    """C [N·m·s/rad, N·s/m]."""
    stiffness: Float[np.ndarray, "dof dof"]
    """K [N·m/rad, N/m]."""
    coordinates: tuple[str, ...]
    """What each row and column is called."""
    hysteresis: Hysteresis | None = None
    """Loss of the springs on single coordinates, if any."""

    def __post_init__(self) -> None:
        count = len(self.coordinates)
        faults: list[Fault] = []
        for name in ("mass", "damping", "stiffness"):
            given = np.array(getattr(self, name), dtype=float)
            fault = _form_fault(name, given, count)
            if fault is None:
                matrix = (given + given.T) / 2
                matrix.flags.writeable = False
                object.__setattr__(self, name, matrix)
                fault = _sign_fault(name, matrix, self.coordinates, strict=name == "mass")
            if fault is not None:
                faults.append(fault)
        loss = self.hysteresis
        if loss is not None and (len(loss.stiffness), len(loss.loss_factor)) != (count, count):
            faults.append(Fault("system", "hysteresis", f"{len(loss.stiffness)} springs", f"{count} springs"))
        if faults:
            raise InvalidSystem(faults)

    def _facts(self) -> Mapping[str, object]:
        loss = "none" if self.hysteresis is None else "yes"
        return {"coordinates": several(self.coordinates), "hysteresis": loss}

    @property
    def dof(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)


def _form_fault(name: str, matrix: np.ndarray, count: int) -> Fault | None:
    if count == 0 or matrix.shape != (count, count):
        return Fault("system", name, f"shape {matrix.shape}", f"{count} × {count}, at least 1 × 1")
    if not np.all(np.isfinite(matrix)):
        return Fault("system", name, "an entry that is not finite", "finite numbers")
    asymmetry = float(np.max(np.abs(matrix - matrix.T)))
    if asymmetry > _SYMMETRY * float(np.max(np.abs(matrix))):
        return Fault("system", name, f"asymmetry of {asymmetry:.3g}", "a symmetric matrix")
    return None


def _sign_fault(name: str, matrix: np.ndarray, coordinates: tuple[str, ...], *, strict: bool) -> Fault | None:
    """Judge definiteness after scaling the diagonal to one, so that units and decades do not matter."""
    allowed = "a positive definite matrix" if strict else "a positive semidefinite matrix"
    diagonal = np.diag(matrix)
    worst = int(np.argmin(diagonal))
    if diagonal[worst] < 0 or (strict and diagonal[worst] == 0):
        return Fault("system", f"{name} of {coordinates[worst]}", f"{diagonal[worst]:.6g}", allowed)
    scale = np.where(diagonal > 0, 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1)), 1.0)
    values, vectors = np.linalg.eigh(matrix * scale[:, None] * scale)
    rounding = 8 * len(coordinates) * float(np.finfo(float).eps)
    if values[0] > rounding or (not strict and values[0] >= -max(rounding, _SYMMETRY)):
        return None
    worst = int(np.argmax(np.abs(vectors[:, 0])))
    return Fault(
        "system", f"{name} of {coordinates[worst]}", f"a relative eigenvalue of {values[0]:.3g}", allowed
    )
