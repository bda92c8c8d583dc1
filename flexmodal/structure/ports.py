"""Structures with a dynamic stiffness or compliance of any law at a port, one complex number a line.

A stiffness port adds z(s) P to Z, P = b bᵀ for a joint or a direction at a point, or any symmetric matrix. A
compliance port is a coordinate e whose spring 1/c(s) stands beside what Z has there already,

    Z′ = Z + e eᵀ/c,    [Z diag(1, …, c, …, 1) + e eᵀ] x = jᵀ,    y = diag(1, …, c, …, 1) x,

in which x_e = f is the force through the port; this form is regular at c = 0, where the port is rigid.
Several such coordinates may share a symmetric matrix of compliances in place of the diagonal. With
y = Z′⁻¹ jᵀ of the rows u and v

    ∂α/∂z = −y_uᵀ P y_v,    ∂α/∂c = f_u f_v,    ∂α/∂c_ij = f_ui f_vj + f_uj f_vi,
    ∂α/∂p = −y_uᵀ (∂Z + z ∂P) y_v + ∂u y_v + y_uᵀ ∂vᵀ,

exact at any z and c. Substructuring by frequency: de Klerk, Rixen and Voormeeren, AIAA Journal 46, 2008.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import SingularResponse
from flexmodal.structure.solution import Entries, Solved, is_worth_compiling, line_factors
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import Axis


@dataclass(frozen=True, eq=False)
class StiffnessPort:
    """A dynamic stiffness on a fixed pattern."""

    pattern: Float[np.ndarray, "system dof dof"]
    """P, symmetric."""
    value: Complex[np.ndarray, "#system line"]
    """z, the same in every system or one for each [N/m, N·m/rad for a pattern without unit]."""
    moved: tuple[Int[np.ndarray, " changed"], Float[np.ndarray, "changed system dof dof"]] | None = None
    """Numbers of the parameters that the pattern depends on, and ∂P along them."""


@dataclass(frozen=True, eq=False)
class CompliancePort:
    """A compliance behind a coordinate that is rigid without it."""

    coordinate: int
    value: Complex[np.ndarray, "#system line"]
    """c, the same in every system or one for each [m/N, rad/(N·m)]."""
    other: int | None = None
    """Another such coordinate, for what the force through one does to both; itself if None."""


Port = StiffnessPort | CompliancePort


@dataclass(frozen=True, eq=False)
class Ported:
    """Structures with ports, solved."""

    solved: Solved
    """Its value holds the receptances [m/N]."""
    ports: Sequence[Port]
    force: Complex[np.ndarray, "system row dof line"]
    """x: the motion of every coordinate, the force through those with a compliance."""

    def along(self, port: int) -> Complex[np.ndarray, "entry line"]:
        """Derivatives along z or c of a port, by its number; each line depends on its own alone."""
        one, (system, left, right) = self.ports[port], self._rows
        if isinstance(one, CompliancePort):
            i, force = one.coordinate, self.force
            j = i if one.other is None else one.other
            found = force[system, left, i] * force[system, right, j]
            return np.asarray(found if i == j else found + force[system, left, j] * force[system, right, i])
        return -self._between(one.pattern)

    def slopes(self, scale: Complex[np.ndarray, "entry line"]) -> Float[np.ndarray, "parameter entry 2 line"]:
        """Derivatives along the parameters times a scale; see `Solved.slopes`."""
        found = self.solved.slopes(scale)
        system = self._rows[0]
        for one in self.ports:
            if isinstance(one, StiffnessPort) and one.moved is not None:
                z = np.broadcast_to(one.value, (len(one.pattern), scale.shape[1]))[system]
                for number, change in zip(one.moved[0].tolist(), one.moved[1], strict=True):
                    more = -self._between(change) * z * scale
                    found[number] += np.stack([more.real, more.imag], axis=1)
        return found

    @property
    def _rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        system, u, v = self.solved.entries.table.T
        return system, u, v + self.solved.entries.rows[0]

    @cached_property
    def _motion(self) -> Complex[np.ndarray, "system row dof line"]:
        return np.asarray(self.solved.y[..., 0, :] + 1j * self.solved.y[..., 1, :])

    def _between(self, matrix: Float[np.ndarray, "system dof dof"]) -> Complex[np.ndarray, "entry line"]:
        """The product y_uᵀ A y_v."""
        system, left, right = self._rows
        shift = self.solved.entries.rows[0]
        pulled = matrix[:, None] @ self._motion[:, shift:]  # of all references
        return np.asarray(np.sum(self._motion[system, left] * pulled[system, right - shift], axis=1))


def solved_with(structures: Structures, axis: Axis, entries: Entries, ports: Sequence[Port]) -> Ported:
    """Solve structures with ports, with pivoting.

    Args:
        structures: the believed ones.
        axis: where.
        entries: receptances that are wanted.
        ports: with their stiffness or compliance.

    Raises:
        SingularResponse: Z′ is singular on a line.
    """
    matrix = _stiffened(structures, axis, ports)
    factor = None
    if any(isinstance(one, CompliancePort) for one in ports):
        factor, rigid = _compliances(ports, matrix.shape)
        matrix = matrix @ factor + np.diag(rigid)
    rows = np.concatenate([structures.response, structures.reference], axis=1)
    right = np.broadcast_to(np.swapaxes(rows, 1, 2)[:, None], (*matrix.shape[:3], rows.shape[1]))
    try:
        x = np.linalg.solve(matrix, right.astype(complex))
    except np.linalg.LinAlgError:
        raise SingularResponse("the receptance is infinite here: with its ports Z is singular") from None
    force = np.moveaxis(x, (3, 2), (1, 2))  # system, row, dof, line
    y = force if factor is None else np.moveaxis(factor @ x, (3, 2), (1, 2))
    parts_of_y = np.ascontiguousarray(np.stack([y.real, y.imag], axis=3))
    solved = Solved(structures, axis, entries, parts_of_y, is_worth_compiling(len(structures) * len(axis)))
    return Ported(solved, tuple(ports), force)


def _stiffened(
    structures: Structures, axis: Axis, ports: Sequence[Port]
) -> Complex[np.ndarray, "system line dof dof"]:
    """Z with what the ports add to it that have a stiffness."""
    parts = np.stack([structures.stiffness, structures.damping, structures.mass, structures.loss])
    systems, dofs = parts.shape[1:3]
    factors = line_factors(structures, axis)[:4]
    found = np.empty((systems, len(axis), dofs, dofs), dtype=complex)
    flat = parts.reshape(4, -1)
    found.real, found.imag = (
        np.swapaxes((factors[:, k].T @ flat).reshape(len(axis), systems, dofs, dofs), 0, 1) for k in (0, 1)
    )
    stiff = [one for one in ports if isinstance(one, StiffnessPort)]
    if stiff:
        patterns = np.stack([one.pattern.reshape(systems, -1) for one in stiff], axis=1)
        value = np.stack([np.broadcast_to(one.value, (systems, len(axis))) for one in stiff], axis=2)
        found.real += (value.real @ patterns).reshape(found.shape)
        found.imag += (value.imag @ patterns).reshape(found.shape)
    return found


def _compliances(
    ports: Sequence[Port], shape: tuple[int, ...]
) -> tuple[Complex[np.ndarray, "system line dof dof"], Float[np.ndarray, " dof"]]:
    """What turns forces through the ports into motions, 1 elsewhere; and which coordinates have a port."""
    factor = np.zeros(shape, dtype=complex)
    factor[...] = np.eye(shape[-1])
    rigid = np.zeros(shape[-1])
    for one in ports:
        if isinstance(one, CompliancePort):
            i, j = one.coordinate, one.coordinate if one.other is None else one.other
            factor[:, :, i, j] = factor[:, :, j, i] = one.value
            rigid[[i, j]] = 1.0
    return factor, rigid
