"""Receptances of many systems at once and their derivatives, by compiled loops or in numpy.

The formulas are those of `structure`: y = Z⁻¹ jᵀ solved once for each row, α = u y_v,
∂α = ∂u y_v + y_uᵀ ∂vᵀ − y_uᵀ ∂Z y_v. Derivatives come multiplied by a scale, such as a weight over the
receptance, so that the normal equations of a fit follow by one product. Both ways give the same numbers but
for rounding; lines on which the elimination without pivoting is not trusted, as may be beside negative
stiffness, are solved again with pivoting.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.errors import SingularResponse
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.structure import slope_kernel, solve_kernel
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import ROUNDING, Axis

_SECONDS, _PULL, _COMPILATION = 8e-6, 2.5e-8, 4.0
"""What numpy takes beyond compiled loops for a system and a line, and for a number among the derivatives, and
what compiling takes [s]; processor time of a core of 2020."""
PARTS = ("stiffness", "damping", "mass", "loss", "growth")
"""What multiplies a part of ∂Z: 1, s, s², h and ∂h/∂η."""


@dataclass(frozen=True, eq=False)
class Entries:
    """Which receptances are wanted of some systems."""

    table: Int[np.ndarray, "entry 3"]
    """System, response row, reference row; all different."""
    rows: tuple[int, int]
    """How many rows of either kind a system has."""

    @cached_property
    def wanted(self) -> Bool[np.ndarray, "system row"]:
        """Whether a system's row is in an entry; references stand behind responses."""
        system, u, v = self.table.T
        found = np.zeros((int(system.max(initial=-1)) + 1, sum(self.rows)), dtype=bool)
        found[system, u] = found[system, v + self.rows[0]] = True
        return found

    @cached_property
    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See `slope_kernel.pull`: ∂Z goes with the kind of row of which there are fewer."""
        system, u, v = self.table.T
        v = v + self.rows[0]
        one, other = (u, v) if self.rows[0] < self.rows[1] else (v, u)
        sides, owner = np.unique(np.column_stack([system, one]), axis=0, return_inverse=True)
        order = np.argsort(owner.ravel(), kind="stable")
        first = np.searchsorted(owner.ravel()[order], np.arange(len(sides) + 1))
        return sides, first, np.column_stack([order, other[order]])


@dataclass(frozen=True, eq=False)
class Solved:
    """Structures solved on an axis for the rows of some entries."""

    structures: Structures
    axis: Axis
    entries: Entries
    y: Float[np.ndarray, "system row dof 2 line"]
    """Z⁻¹ jᵀ, real and imaginary parts; responses, then references."""
    compiled: bool

    @cached_property
    def value(self) -> Complex[np.ndarray, "entry line"]:
        """α [m/N]; what is nothing but rounding, where a point does not move at all, is exactly zero."""
        if self.compiled:
            out = np.empty((len(self.entries.table), len(self.axis)), dtype=complex)
            flat = out.view(float).reshape(*out.shape, 2)
            shift = self.entries.rows[0]
            table, response = np.ascontiguousarray(self.entries.table), self.structures.response
            _compiled()[2](table, np.ascontiguousarray(response), self.y, shift, ROUNDING, flat)
            return out
        system, u, v = self.entries.table.T
        right = self._solution(system, v + self.entries.rows[0])
        rows = self.structures.response[system, u]
        value = (rows[:, None] @ right)[:, 0]
        size = (np.abs(rows)[:, None] @ np.abs(right))[:, 0]
        value[np.abs(value) <= ROUNDING * size] = 0.0
        return value

    def slopes(self, scale: Complex[np.ndarray, "entry line"]) -> Float[np.ndarray, "parameter entry 2 line"]:
        """Derivatives of the receptances along all parameters, times a scale; real and imaginary parts."""
        many = self.structures
        out = np.zeros((len(many.names), len(self.entries.table), 2, len(self.axis)))
        matrices, numbers, kinds = _parts(many)
        if len(numbers):
            bounds = np.searchsorted(numbers, np.arange(len(many.names) + 1))
            given = matrices, bounds, kinds, line_factors(many, self.axis), self.y
            flat = np.stack([scale.real, scale.imag], axis=1)
            if not self.compiled:
                is_worth_compiling(0, out.size)  # counts towards the next time
            pull = _compiled()[1] if self.compiled else _pull
            pull(*given, *self.entries.sides, flat, out)
        self._turned(scale, out)
        return out

    def _turned(self, scale: np.ndarray, out: np.ndarray) -> None:
        """Add ∂u y_v + y_uᵀ ∂vᵀ."""
        if not self.structures.turned:
            return
        system, u, v = self.entries.table.T
        left, right = self._solution(system, u), self._solution(system, v + self.entries.rows[0])
        for number, (response, reference) in self.structures.turned.items():
            found = (response[system, u][:, None] @ right)[:, 0]
            found = (found + (reference[system, v][:, None] @ left)[:, 0]) * scale
            out[number, :, 0] += found.real
            out[number, :, 1] += found.imag

    def _solution(self, system: np.ndarray, row: np.ndarray) -> Complex[np.ndarray, "entry dof line"]:
        some = self.y[system, row]
        return np.asarray(some[:, :, 0] + 1j * some[:, :, 1])


def solved(structures: Structures, axis: Axis, entries: Entries, *, compiled: bool | None = None) -> Solved:
    """Solve structures for the rows of some entries.

    Args:
        structures: of one size.
        axis: where.
        entries: what is wanted.
        compiled: whether by compiled loops; by default, once these are worth loading.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    use = is_worth_compiling(len(structures) * len(axis)) if compiled is None else compiled
    rows = np.concatenate([structures.response, structures.reference], axis=1)
    y = solutions(structures, axis, rows, entries.wanted, compiled=use)
    return Solved(structures, axis, entries, y, use)


def back_solved(
    structures: Structures, axis: Axis, *, compiled: bool | None = None
) -> Complex[np.ndarray, "system response dof line"]:
    """Z⁻¹ of every response row [m/N, rad/N].

    Args:
        structures: of one size.
        axis: where.
        compiled: see `solved`.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    use = is_worth_compiling(len(structures) * len(axis)) if compiled is None else compiled
    rows = structures.response
    y = solutions(structures, axis, rows, np.ones(rows.shape[:2], dtype=bool), compiled=use)
    return np.asarray(y[:, :, :, 0] + 1j * y[:, :, :, 1])


def solutions(
    structures: Structures,
    axis: Axis,
    rows: Float[np.ndarray, "system row dof"],
    wanted: Bool[np.ndarray, "some row"],
    *,
    compiled: bool,
) -> Float[np.ndarray, "system row dof 2 line"]:
    """Z⁻¹ of rows, by real and imaginary part.

    Args:
        structures: of one size.
        axis: where.
        rows: of any motions.
        wanted: which of them are solved for, in the first so many systems; compiled loops leave others 0.
        compiled: whether by compiled loops.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    out = np.zeros((*rows.shape, 2, len(axis)))
    if not compiled:
        _pivoted(structures, axis, rows, np.ones((len(rows), len(axis)), dtype=bool), out)
        return out
    matrices = np.stack([structures.stiffness, structures.damping, structures.mass, structures.loss], axis=1)
    trust = np.empty((len(rows), len(axis)))
    _compiled()[0](matrices[: len(wanted)], rows, wanted, line_factors(structures, axis)[:4], out, trust)
    doubtful = ~(trust[: len(wanted)] > 0)
    if doubtful.any():
        _pivoted(structures, axis, rows, doubtful, out)
    return out


def _pivoted(
    structures: Structures, axis: Axis, rows: np.ndarray, where: np.ndarray, out: np.ndarray
) -> None:
    """Solve some lines of some systems with pivoting."""
    system, line = np.nonzero(where)
    factors = line_factors(structures, axis)[:4]
    f = (factors[:, 0] + 1j * factors[:, 1])[:, line, None, None]
    z = structures.stiffness[system] + f[1] * structures.damping[system] + f[2] * structures.mass[system]
    if structures.loss_factor:
        z += f[3] * structures.loss[system]
    try:
        y = np.linalg.solve(z, np.swapaxes(rows, 1, 2)[system].astype(complex))
    except np.linalg.LinAlgError:
        raise SingularResponse(
            "the receptance is infinite here: an undamped mode is driven at its natural frequency"
        ) from None
    out[system, :, :, 0, line] = np.swapaxes(y.real, 1, 2)
    out[system, :, :, 1, line] = np.swapaxes(y.imag, 1, 2)


def line_factors(structures: Structures, axis: Axis) -> Float[np.ndarray, "part 2 line"]:
    """By real and imaginary part, in the order of `PARTS`.

    Args:
        structures: whose loss factor it is.
        axis: the lines.
    """
    found = np.zeros((len(PARTS), len(axis)), dtype=complex)
    found[0], found[1], found[2] = 1.0, axis.s, axis.s**2
    if structures.loss_factor or structures.loss_slopes:
        found[3], found[4] = axis.hysteresis(structures.loss_factor)
    return np.ascontiguousarray(np.stack([found.real, found.imag], axis=1))


def _parts(many: Structures) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parts of ∂Z ordered by parameter: matrices, numbers of parameters, and of what multiplies them."""
    matrices = [matrices for _, matrices in many.slopes.values()]
    numbers = [numbers for numbers, _ in many.slopes.values()]
    kinds = [np.full(len(n), PARTS.index(kind)) for kind, (n, _) in many.slopes.items()]
    for number, slope in many.loss_slopes.items():
        matrices.append(slope * many.loss[None])
        numbers.append(np.array([number]))
        kinds.append(np.array([PARTS.index("growth")]))
    if not matrices:
        return np.zeros((0, *many.mass.shape)), np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    owner = np.concatenate(numbers)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(matrices)[order], owner[order], np.concatenate(kinds)[order]


def _pull(
    matrices: np.ndarray, bounds: np.ndarray, kinds: np.ndarray, factors: np.ndarray, y: np.ndarray,
    sides: np.ndarray, first: np.ndarray, entries: np.ndarray, scale: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """See `slope_kernel.pull`."""
    full, f = y[:, :, :, 0] + 1j * y[:, :, :, 1], factors[:, 0] + 1j * factors[:, 1]
    along = full[sides[:, 0], sides[:, 1]]  # side, dof, line
    owner = np.repeat(np.arange(len(sides)), np.diff(first))
    left = full[sides[owner, 0], entries[:, 1]] * (scale[:, 0] + 1j * scale[:, 1])[entries[:, 0], None]
    for number in range(len(bounds) - 1):
        some = slice(bounds[number], bounds[number + 1])
        if some.start == some.stop:
            continue
        force = sum(
            f[kind] * (matrix[sides[:, 0]] @ along)
            for matrix, kind in zip(matrices[some], kinds[some].tolist(), strict=True)
        )
        found = -np.sum(left * np.asarray(force)[owner], axis=1)
        out[number, entries[:, 0], 0], out[number, entries[:, 0], 1] = found.real, found.imag


@cache
def _kernels() -> tuple[Kernel, Kernel, Kernel]:
    purpose = "responses of a structure"
    inner = solve_kernel.ordered, solve_kernel.fill, solve_kernel.back
    return (
        together(*inner, last=solve_kernel.solve, purpose=purpose, seconds=_COMPILATION),
        together(
            slope_kernel.push, last=slope_kernel.pull, purpose=purpose, seconds=_COMPILATION, merged=True
        ),
        together(last=slope_kernel.values, purpose=purpose, seconds=_COMPILATION),
    )


@cache
def _compiled() -> tuple[Any, Any, Any]:
    solve, pull, values = _kernels()
    return solve.compiled, pull.compiled, values.compiled


def is_worth_compiling(points: int, slopes: int = 0) -> bool:
    """Whether to work on so many systems and lines by compiled loops.

    Args:
        points: systems times lines.
        slopes: numbers among the derivatives.
    """
    if not has_numba():
        return False
    if _compiled.cache_info().currsize:
        return True
    seconds = points * _SECONDS + slopes * _PULL
    return is_worth_it(
        "structures", seconds, _COMPILATION, lambda: all(one.is_stored() for one in _kernels())
    )
