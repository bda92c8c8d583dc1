"""Structures with a dynamic stiffness or compliance of any law at a port, one complex number a line.

A stiffness port adds z(s) P to Z, P = b bᵀ for a joint or a direction at a point, or any symmetric matrix. A
compliance port is a coordinate e whose spring 1/c(s) stands beside what Z has there already; it is rigid at
c = 0. Several such coordinates may share a symmetric matrix of compliances.

What the ports add has a low rank, so Z is solved once, for the rows and for the motions B of the ports, and
any values follow by the identity of Woodbury (Hager, SIAM Review 31, 1989): with G = Bᵀ Z⁻¹ B and ΔZ = B Δ Bᵀ

    α′ = α − (Bᵀ y_u)ᵀ W Bᵀ y_v,    y′ = y − Z⁻¹B W Bᵀ y,    W = (Δ⁻¹ + G)⁻¹ = (C + A G)⁻¹ A.

For stiffness C = 1 and A is the matrix z of the functions. A coordinate of a compliance is held by a spring
k₀ while Z is solved, which keeps Z regular; there C is the matrix c of the functions and A = 1 − c k₀, so
that nothing is singular at c = 0. With y_b′ = Bᵀ y′ and the force f = W Bᵀ y + k₀ y_b′ through a compliance

    ∂α/∂z = −y_u′ᵀ P y_v′,    ∂α/∂c = f_u f_v,    ∂α/∂c_ij = f_ui f_vj + f_uj f_vi,
    ∂α/∂p = −y_u′ᵀ (∂Z + z ∂P) y_v′ + ∂u y_v′ + y_u′ᵀ ∂vᵀ,

exact at any z and c. Substructuring by frequency: de Klerk, Rixen and Voormeeren, AIAA Journal 46, 2008.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import SingularResponse
from flexmodal.structure.port import CompliancePort, Port, StiffnessPort
from flexmodal.structure.port_solution import SINGULAR, CompiledPorts
from flexmodal.structure.solution import Solved
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import ROUNDING

Values = Complex[np.ndarray, "port #system line"]
"""z or c of each port, the same in every system or one for each."""
Moved = Mapping[int, tuple[Int[np.ndarray, " changed"], Float[np.ndarray, "changed system dof dof"]]]
"""By port: numbers of the parameters that its pattern depends on, and ∂P along them."""


@dataclass(frozen=True, eq=False)
class PortedStructures:
    """Structures solved for their rows and for the motions of ports, which may take any value."""

    ports: tuple[Port, ...]
    solved: Solved
    """Without the ports' own values, compliances held by k₀; the motions B stand behind the rows."""
    basis: Float[np.ndarray, "system dof port"]
    """B: coordinates with a compliance, then what spans the patterns of stiffness."""
    held: Float[np.ndarray, "system port"]
    """k₀; 0 for stiffness."""
    coordinates: tuple[int, ...]
    """Those with a compliance."""
    compiled: bool
    """Whether values of the ports are followed by compiled loops."""

    def at(self, values: Values) -> Ported:
        """The structures with their ports.

        Args:
            values: of the ports.
        """
        return Ported(self, values)

    def system(self, values: Values) -> tuple[np.ndarray, np.ndarray]:
        """C + A G, and A.

        Args:
            values: of the ports.
        """
        count, stiff = self.basis.shape[2], len(self.coordinates)
        shape = len(self.basis), len(self.solved.axis)
        c, a = np.zeros((2, *shape, count, count), dtype=complex)
        c[..., range(stiff, count), range(stiff, count)] = 1.0
        for number, (port, value) in enumerate(zip(self.ports, values, strict=True)):
            if isinstance(port, CompliancePort):
                i, j = (self.coordinates.index(one) for one in port.both)
                c[..., i, j] += value
                if i != j:
                    c[..., j, i] += value
            elif value.any():
                a += value[..., None, None] * self.small[number][:, None]
        a[..., :stiff, :stiff] -= c[..., :stiff, :stiff] * self.held[:, None, None, :stiff]
        a[..., range(stiff), range(stiff)] += 1.0
        return c + a @ self.own, a

    @cached_property
    def small(self) -> dict[int, Float[np.ndarray, "system port port"]]:
        """The pattern of each stiffness between the motions that span these, by the number of the port."""
        span = self.basis.copy()
        span[:, :, : len(self.coordinates)] = 0.0
        turned = np.swapaxes(span, 1, 2)
        ports = enumerate(self.ports)
        return {k: turned @ one.pattern @ span for k, one in ports if isinstance(one, StiffnessPort)}

    @cached_property
    def motion(self) -> Complex[np.ndarray, "system line row dof"]:
        """Z⁻¹ of every row, the motions of the ports last."""
        y = self.solved.y
        return np.ascontiguousarray(np.moveaxis(y[..., 0, :] + 1j * y[..., 1, :], -1, 1))

    @cached_property
    def _pulled(self) -> Complex[np.ndarray, "system line port row"]:
        return np.ascontiguousarray(np.swapaxes(self.motion @ self.basis[:, None], 2, 3))

    @cached_property
    def loops(self) -> CompiledPorts:
        """Loops over systems and lines, compiled."""
        pairs = np.full((len(self.ports), 2), -1)
        small = np.zeros((len(self.ports), len(self.basis), *self.own.shape[2:]))
        for number, port in enumerate(self.ports):
            if isinstance(port, CompliancePort):
                pairs[number] = [self.coordinates.index(one) for one in port.both]
            else:
                small[number] = self.small[number]
        entries = self.solved.entries
        return CompiledPorts(pairs, small, self.held, self._pulled, entries.table, entries.rows)

    @property
    def rows(self) -> int:
        """How many rows a system has, those of the ports left out."""
        return sum(self.solved.entries.rows)

    @property
    def seen(self) -> Complex[np.ndarray, "system line port row"]:
        """Motion of the ports under a force at each row."""
        return self._pulled[..., : self.rows]

    @property
    def own(self) -> Complex[np.ndarray, "system line port port"]:
        """G: motion of the ports under forces at the ports."""
        return self._pulled[..., self.rows :]

    def between(self, left: np.ndarray, right: np.ndarray) -> Complex[np.ndarray, "entry line"]:
        """Products over the ports, of responses with references, for every entry.

        Args:
            left: of every row [system line port row].
            right: the same, or of the references only.
        """
        entries = self.solved.entries
        responses, references = entries.rows
        full = np.swapaxes(left[..., :responses], 2, 3) @ right[..., -references:]
        system, u, v = entries.table.T
        return np.asarray(full[system, :, u, v])


@dataclass(frozen=True, eq=False)
class Ported:
    """Structures with ports of some value."""

    base: PortedStructures
    values: Values

    @cached_property
    def value(self) -> Complex[np.ndarray, "entry line"]:
        """α′ [m/N]; what is nothing but rounding is exactly zero.

        Raises:
            SingularResponse: Z′ is singular on a line.
        """
        base = self.base
        plain = base.solved.value
        if base.compiled:
            return base.loops.value(plain, self._taken)
        taken = base.between(base.seen, self._taken)
        found = plain - taken
        found[np.abs(found) <= ROUNDING * (np.abs(plain) + np.abs(taken))] = 0.0
        return found

    @cached_property
    def along(self) -> Complex[np.ndarray, "entry line port"]:
        """Derivatives along z or c of every port; each line depends on its own alone."""
        base = self.base
        if base.compiled:
            return base.loops.along(self._every, self._left)
        found = np.empty((*base.solved.value.shape, len(base.ports)), dtype=complex)
        for number, one in enumerate(base.ports):
            if isinstance(one, CompliancePort):
                i, j = (base.coordinates.index(k) for k in one.both)
                f, g = (self._force[:, :, k : k + 1] for k in (i, j))
                found[..., number] = base.between(f, g) + (base.between(g, f) if i != j else 0.0)
            else:
                found[..., number] = -base.between(self._left, base.small[number][:, None] @ self._left)
        return found

    def with_more(self, port: int, z: Float[np.ndarray, " line"]) -> Complex[np.ndarray, "entry line"]:
        """α with a stiffness more at a port whose pattern has rank one, P = b bᵀ [m/N].

        By the formula of Sherman and Morrison, α″ = α′ − z (y_u′ᵀ b)(bᵀ y_v′) / (1 + z bᵀ Z′⁻¹ b).

        Args:
            port: its number, of a stiffness.
            z: what is added to its value.
        """
        base = self.base
        own = np.einsum("sij,slji->sl", base.small[port], self._own)
        system = base.solved.entries.table[:, 0]
        return np.asarray(self.value + z * self.along[..., port] / (1 + z * own)[system])

    def slopes(
        self,
        scale: Complex[np.ndarray, "entry line"],
        structures: Structures | None = None,
        moved: Moved | None = None,
    ) -> Float[np.ndarray, "parameter entry 2 line"]:
        """Derivatives along the parameters times a scale; see `Solved.slopes`.

        Args:
            scale: of each entry.
            structures: the same ones with derivatives; by default they have them.
            moved: derivatives of the ports' patterns, where these depend on parameters.
        """
        solved, motion = self.base.solved, self._motion
        turned = np.moveaxis(motion, 1, -1)
        parts = np.empty((*turned.shape[:3], 2, turned.shape[3]))
        parts[..., 0, :], parts[..., 1, :] = turned.real, turned.imag
        found = replace(solved, structures=structures or solved.structures, y=parts).slopes(scale)
        responses, references = solved.entries.rows
        system, u, v = solved.entries.table.T
        for port, (numbers, changes) in (moved or {}).items():
            z = np.broadcast_to(self.values[port], (len(motion), scale.shape[1]))
            for number, change in zip(numbers.tolist(), changes, strict=True):
                pulled = motion[:, :, :responses] @ change[:, None]
                full = pulled @ np.swapaxes(motion[:, :, -references:], 2, 3) * z[..., None, None]
                more = -full[system, :, u, v] * scale
                found[number] += np.stack([more.real, more.imag], axis=1)
        return found

    @cached_property
    def _system(self) -> tuple[np.ndarray, np.ndarray]:
        return self.base.system(self.values)

    def _forced(self, rows: slice) -> Complex[np.ndarray, "system line port row"]:
        """W Bᵀ y of some rows."""
        matrix, factor = self._system
        right = factor @ self.base.seen[..., rows]
        if matrix.shape[-1] == 1:
            with np.errstate(divide="ignore", invalid="ignore"):
                found = right / matrix
        else:
            try:
                found = np.linalg.solve(matrix, right)
            except np.linalg.LinAlgError:
                found = np.full(right.shape, np.nan)
        if not np.isfinite(found).all():
            raise SingularResponse(SINGULAR)
        return found

    @cached_property
    def _taken(self) -> Complex[np.ndarray, "system line port reference"]:
        if self.base.compiled:
            return self.base.loops.forces(self.values, self.base.solved.entries.rows[0])
        return self._forced(slice(-self.base.solved.entries.rows[1], None))

    @cached_property
    def _every(self) -> Complex[np.ndarray, "system line port row"]:
        if self.base.compiled:
            return self.base.loops.forces(self.values, 0)
        first = self._forced(slice(self.base.solved.entries.rows[0]))
        return np.concatenate([first, self._taken], axis=3)

    @cached_property
    def _left(self) -> Complex[np.ndarray, "system line port row"]:
        """y_b′: motion of the ports that is left."""
        if self.base.compiled:
            return self.base.loops.left_over(self._every)
        return self.base.seen - self.base.own @ self._every

    @cached_property
    def _own(self) -> Complex[np.ndarray, "system line port port"]:
        """Bᵀ Z′⁻¹ B."""
        own, (matrix, factor) = self.base.own, self._system
        return np.asarray(own - own @ np.linalg.solve(matrix, factor @ own))

    @cached_property
    def _force(self) -> Complex[np.ndarray, "system line port row"]:
        return self._every + self.base.held[:, None, :, None] * self._left

    @cached_property
    def _motion(self) -> Complex[np.ndarray, "system line row dof"]:
        """y′ of every row."""
        motion, rows = self.base.motion, self.base.rows
        return motion[:, :, :rows] - np.swapaxes(self._every, 2, 3) @ motion[:, :, rows:]
