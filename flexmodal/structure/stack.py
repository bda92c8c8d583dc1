"""Structures of one size side by side, a system for each posture or blow, with stacked derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from flexmodal.structure.structure import Change, Structure

Slopes = dict[str, tuple[np.ndarray, np.ndarray]]
"""By kind: numbers of parameters, and derivatives along them [parameter system dof dof]."""


@dataclass(frozen=True, eq=False)
class Structures:
    """Matrices and rows of several systems with the same coordinates."""

    coordinates: tuple[str, ...]
    mass: Float[np.ndarray, "system dof dof"]
    damping: Float[np.ndarray, "system dof dof"]
    stiffness: Float[np.ndarray, "system dof dof"]
    loss: Float[np.ndarray, "system dof dof"]
    """H [N·m/rad]: stiffness of the hysteretic springs, which is in `stiffness` too."""
    response: Float[np.ndarray, "system response dof"]
    reference: Float[np.ndarray, "system reference dof"]
    names: tuple[str, ...] = ()
    """Parameters."""
    slopes: Slopes = field(default_factory=dict)
    turned: Mapping[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    """Derivatives of the response and reference rows along parameters by number, where they move."""
    loss_factor: float = 0.0
    """η of the hysteretic springs."""
    loss_slopes: Mapping[int, float] = field(default_factory=dict)
    """Its derivatives along parameters by number."""

    def __len__(self) -> int:
        """How many systems."""
        return len(self.mass)

    def __getitem__(self, k: int) -> Structure:
        """One of them."""
        parts: dict[int, dict[str, np.ndarray | float]] = {}
        for kind, (numbers, matrices) in self.slopes.items():
            for number, matrix in zip(numbers.tolist(), matrices[:, k], strict=True):
                if matrix.any():
                    part = parts.setdefault(number, {})
                    part[kind] = part.get(kind, 0.0) + matrix
        for number, (response, reference) in self.turned.items():
            for name, rows in (("response", response[k]), ("reference", reference[k])):
                if rows.any():
                    parts.setdefault(number, {})[name] = rows
        for number, slope in self.loss_slopes.items():
            parts.setdefault(number, {})["loss_factor"] = slope
        changes = {self.names[number]: Change(**part) for number, part in parts.items()}  # type: ignore[arg-type]
        return Structure(
            self.coordinates, self.mass[k], self.damping[k], self.stiffness[k], self.loss[k],
            self.response[k], self.reference[k], changes, self.loss_factor,
        )  # fmt: skip


def joined(parts: Sequence[Slopes]) -> Slopes:
    """Derivatives one after the other; a parameter may stand in several."""
    found: Slopes = {}
    for part in parts:
        for kind, (numbers, matrices) in part.items():
            if kind in found:
                one, other = found[kind]
                found[kind] = np.concatenate([one, numbers]), np.concatenate([other, matrices])
            else:
                found[kind] = numbers, matrices
    return found
