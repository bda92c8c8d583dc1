"""Many systems at many frequencies as one task: what is known of them, and how a block is solved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import SingularResponse
from flexmodal.frf.kernels.factor import LANES, LARGEST, Pairs, Shape, pack
from flexmodal.frf.kernels.numpy_form import ldlt_receptances

Block = Callable[[slice], tuple[Float[np.ndarray, "system dof dof"], Float[np.ndarray, "system row dof"]]]
"""Mass matrices and rows of some of the systems."""

SINGULAR = 1e-13
"""Smallest singular value of the scaled dynamic stiffness below which the response counts as infinite."""

_POINTS = 512
"""Points that the numpy form works on together: few enough for the second-level cache."""

_MOST_PAIRS = 21
"""Most receptances of a kernel with n fixed: all of a symmetric 6 × 6 matrix."""


@dataclass(frozen=True, eq=False)
class Task:
    """Receptances of systems that share K, B and the frequencies."""

    count: int
    """Systems."""
    block: Block
    stiffness: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    hysteresis: Float[np.ndarray, "dof dof"]
    """Imaginary part of Z that does not grow with the frequency, such as η K."""
    pairs: Pairs
    omega: Float[np.ndarray, " line"]
    addition: Complex[np.ndarray, "line dof dof"] | None = None
    recursion: Callable[[slice, slice, np.ndarray], int] | None = None
    """Fills some systems and lines along a chain and counts the points it does not trust; none where the
    systems are no such chains."""
    chain: str = ""
    """The kind of chain, "planar" or "spatial", if there is one."""

    @property
    def dof(self) -> int:
        """Coordinates of a system."""
        return len(self.stiffness)

    @property
    def points(self) -> int:
        """Systems times frequencies."""
        return self.count * len(self.omega)

    @cached_property
    def shape(self) -> Shape:
        """What a kernel would have to be made for."""
        parts = (self.stiffness, self.damping, self.hysteresis)
        diagonal = self.addition is None and all(
            np.count_nonzero(part - np.diag(np.diag(part))) == 0 for part in parts
        )
        return Shape(self.dof, self.pairs, diagonal, self.addition is not None)

    @property
    def fits_fixed(self) -> bool:
        """Whether a kernel with n fixed when compiled exists."""
        return self.dof <= LARGEST and len(self.pairs) <= _MOST_PAIRS

    @cached_property
    def shared(self) -> Float[np.ndarray, " entry"]:
        """K, B and hysteresis as a kernel's tile holds them."""
        parts = (self.stiffness, self.damping, self.hysteresis)
        if self.shape.diagonal:
            return np.concatenate([np.diag(part) for part in parts])
        return pack(np.stack(parts)).ravel()

    def solve_compiled(self, systems: slice, lines: slice, sweep: Any, repair: Any, out: np.ndarray) -> None:
        """Fill `out` for some systems and lines with a compiled sweep, and repair what it did not trust.

        Args:
            systems: which of them.
            lines: which frequencies.
            sweep: the compiled loops.
            repair: compiled, for the points not trusted.
            out: of these systems and lines.
        """
        masses, rows = self.block(systems)
        omega = self.omega[lines]
        own, here = len(masses), len(omega)
        along = -(-own // LANES) * here < own * -(-here // LANES)
        padding = 0 if along else -here % LANES
        extra = np.zeros((0, here + padding))
        if self.addition is not None:
            packed = pack(self.addition[lines]).T
            extra = np.concatenate([packed.real, packed.imag])
            extra = np.pad(extra, ((0, 0), (0, padding)), mode="edge") if padding else extra
        given = (
            pack(masses),
            self.shared,
            np.ascontiguousarray(rows).reshape(own, -1),
            np.pad(omega, (0, padding), mode="edge") if padding else omega,
            extra,
            np.array(self.pairs),
        )
        if sweep(*given, along, out) and repair(*given, out):
            self.solve_pivoting(systems, lines, out)

    def solve_numpy(self, systems: slice, lines: slice, out: np.ndarray) -> None:
        """Fill `out` for some systems and lines with the numpy form.

        Args:
            systems: which of them.
            lines: which frequencies.
            out: of these systems and lines.
        """
        masses, rows = self.block(systems)
        here = len(self.omega[lines])
        masses, rows = np.moveaxis(masses, 0, -1), np.moveaxis(rows, 0, -1)
        for start in range(0, len(out) * here, _POINTS):
            which, line = np.divmod(np.arange(start, min(start + _POINTS, len(out) * here)), here)
            matrix, size = self._entries(masses[..., which], line + (lines.start or 0))
            values, trusted = ldlt_receptances(matrix, size, rows[..., which], self.pairs)
            values[:, ~trusted] = np.nan
            out[which, line] = values.T
        if np.any(np.isnan(out[..., 0])):
            self.solve_pivoting(systems, lines, out)

    def solve_lapack(self, systems: slice, lines: slice, out: np.ndarray) -> None:
        """Fill `out` for some systems and lines one matrix at a time, with pivoting.

        Args:
            systems: which of them.
            lines: which frequencies.
            out: of these systems and lines.
        """
        out[...] = np.nan
        self.solve_pivoting(systems, lines, out)

    def _entries(self, mass: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The upper half of Z by row, column and point, and |K_kk| + ω²M_kk + ωB_kk."""
        omega = self.omega[line]
        square = omega**2
        matrix = np.empty(mass.shape, dtype=complex)
        loss = 1j * omega
        for i in range(self.dof):
            matrix[i, i:] = loss * self.damping[i, i:, None]
            matrix[i, i:] += self.stiffness[i, i:, None] + 1j * self.hysteresis[i, i:, None]
            matrix[i, i:] -= square * mass[i, i:]
        places = range(self.dof)
        size = np.abs(np.diag(self.stiffness))[:, None] + square * mass[places, places]
        if self.addition is not None:
            added = np.moveaxis(self.addition[line], 0, -1)
            for i in range(self.dof):
                matrix[i, i:] += added[i, i:]
            size = size + np.abs(added.real[places, places])
        return matrix, size + np.abs(matrix.imag[places, places])

    def solve_pivoting(
        self,
        systems: slice,
        lines: slice,
        out: np.ndarray,
        posed: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> None:
        """Solve the points that stand as NaN with pivoting; `posed` if mass matrices and rows are known.

        Args:
            systems: which of them.
            lines: which frequencies.
            out: of these systems and lines.
            posed: mass matrices and rows, where they are known.

        Raises:
            SingularResponse: Z is singular at one of them.
        """
        masses, rows = self.block(systems) if posed is None else posed
        which, line = np.nonzero(np.isnan(out[..., 0]))
        damped = is_damped(self.damping + self.hysteresis)
        for start in range(0, len(which), _POINTS):
            w, f = which[start : start + _POINTS], line[start : start + _POINTS]
            place = f + (lines.start or 0)
            omega = self.omega[place]
            matrix = np.empty(masses[w].shape, dtype=complex)
            np.multiply(masses[w], -(omega[:, None, None] ** 2), out=matrix.real)
            np.multiply(self.damping, omega[:, None, None], out=matrix.imag)
            matrix.real += self.stiffness
            matrix.imag += self.hysteresis
            if self.addition is not None:
                matrix += self.addition[place]
            exposed = np.flatnonzero(omega == 0) if damped else np.arange(len(omega))
            loss = omega[:, None] * np.diag(self.damping) + np.diag(self.hysteresis)
            inertia = omega[:, None] ** 2 * np.diagonal(masses, axis1=1, axis2=2)[w]
            size = np.abs(np.diag(self.stiffness)) + inertia + loss
            refuse_singular(matrix[exposed], size[exposed], omega[exposed])
            try:
                solved = np.linalg.solve(matrix, np.swapaxes(rows[w], 1, 2).astype(complex))
            except np.linalg.LinAlgError:
                raise singular(float(omega[0])) from None
            values = np.asarray(rows[w] @ solved)
            out[w, f] = values[:, [u for u, _ in self.pairs], [v for _, v in self.pairs]]
            bad = ~np.isfinite(out[w, f]).all(axis=-1)
            if np.any(bad):
                raise singular(float(omega[np.argmax(bad)]))


def refuse_singular(
    matrix: Complex[np.ndarray, "point dof dof"],
    size: Float[np.ndarray, "point dof"],
    omega: Float[np.ndarray, " point"],
) -> None:
    """Without full damping Z can be singular; find it before a solver returns 10¹⁰ or fails.

    Z is held against its own terms at its own frequency, so that neither the rest of the axis nor a stiffer
    joint changes the verdict.

    Args:
        matrix: Z.
        size: sum of the magnitudes of the terms of its diagonal.
        omega: angular frequency [rad/s].

    Raises:
        SingularResponse: at the point nearest to singular.
    """
    if len(omega) == 0:
        return
    scale = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    scaled = matrix * scale[:, :, None] * scale[:, None, :]
    smallest = np.linalg.svd(scaled, compute_uv=False)[:, -1]
    worst = int(np.argmin(smallest))
    if smallest[worst] <= SINGULAR:
        raise singular(float(omega[worst]))


def singular(omega: float) -> SingularResponse:
    """The error for an infinite response at an angular frequency [rad/s]."""
    return SingularResponse(
        f"the receptance is infinite at {omega / (2 * np.pi):.9g} Hz: an undamped mode is driven at its "
        "natural frequency; give the joints damping or leave this frequency out"
    )


def is_damped(loss: Float[np.ndarray, "dof dof"]) -> bool:
    """Whether the damping, being positive definite, keeps Z regular above 0 Hz."""
    diagonal = np.diag(loss)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    return float(np.min(np.linalg.eigvalsh(loss * scale[:, None] * scale))) > SINGULAR
