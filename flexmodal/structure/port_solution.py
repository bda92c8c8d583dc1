"""Structures with ports by compiled loops; the formulas, and the way without them, are in `ports`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import SingularResponse
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.structure import port_kernel
from flexmodal.structure.structure import ROUNDING

_SECONDS, COMPILATION = 3e-6, 4.0
"""What numpy takes beyond compiled loops for a system and a line, asked for a few times (measured: nothing
with one port; 0.5 µs for values and 1.1 µs for derivatives with three), and what compiling takes (measured:
2.9) [s]; processor time of a core of 2020."""
SINGULAR = "the receptance is infinite here: with its ports Z is singular"


@dataclass(frozen=True, eq=False)
class CompiledPorts:
    """Ports of structures that are solved for the rows and the motions of the ports."""

    pairs: Int[np.ndarray, "port 2"]
    """Numbers of the motions that a compliance lies between; −1 of a stiffness."""
    small: Float[np.ndarray, "port system motion motion"]
    """Patterns of stiffness between the motions that span these."""
    held: Float[np.ndarray, "system motion"]
    """k₀; 0 for stiffness."""
    pulled: Complex[np.ndarray, "system line motion row"]
    """Bᵀ Z⁻¹ of every row, those of the ports last."""
    table: Int[np.ndarray, "entry 3"]
    """System, response row and reference row."""
    rows: tuple[int, int]
    """How many response and reference rows there are."""

    def forces(
        self, values: Complex[np.ndarray, "port #system line"], begin: int
    ) -> Complex[np.ndarray, "system line motion row"]:
        """W Bᵀ y of the rows from a number on; 0 of those before it.

        Args:
            values: z or c of each port, the same in every system or one for each.
            begin: number of the first row.

        Raises:
            SingularResponse: Z′ is singular on a line.
        """
        every = sum(self.rows)
        found = np.zeros((*self.pulled.shape[:3], every), dtype=complex)
        given = np.ascontiguousarray(values, dtype=complex)
        if not _compiled()[0](given, self.pairs, self.small, self.held, self.pulled, begin, every, found):
            raise SingularResponse(SINGULAR)
        return found

    def value(
        self, plain: Complex[np.ndarray, "entry line"], force: Complex[np.ndarray, "system line motion row"]
    ) -> Complex[np.ndarray, "entry line"]:
        """α′ of every entry [m/N].

        Args:
            plain: without the ports.
            force: of the references at least.
        """
        found = np.empty_like(plain)
        _compiled()[1](self.table, self.rows[0], plain, self.pulled, force, ROUNDING, found)
        return found

    def left_over(
        self, force: Complex[np.ndarray, "system line motion row"]
    ) -> Complex[np.ndarray, "system line motion row"]:
        """y_b′: motion of the ports that is left under a force at each row.

        Args:
            force: of all rows.
        """
        found = np.empty_like(force)
        _compiled()[2](self.pulled, force, sum(self.rows), found)
        return found

    def along(
        self,
        force: Complex[np.ndarray, "system line motion row"],
        left: Complex[np.ndarray, "system line motion row"],
    ) -> Complex[np.ndarray, "entry line port"]:
        """Derivatives of every entry along the value of every port.

        Args:
            force: of all rows.
            left: motion of the ports that is left.
        """
        found = np.empty((len(self.table), self.pulled.shape[1], len(self.pairs)), dtype=complex)
        _compiled()[3](self.table, self.rows[0], self.pairs, self.small, self.held, force, left, found)
        return found


@cache
def kernels() -> tuple[Kernel, ...]:
    """The compiled loops: forces, receptances, motion that is left, derivatives."""
    given: dict[str, Any] = {"purpose": "responses of a structure with ports", "seconds": COMPILATION}
    inner = port_kernel.eliminate, port_kernel.fill
    return (
        together(*inner, last=port_kernel.forces, **given),
        together(last=port_kernel.receptances, allocates=False, **given),
        together(last=port_kernel.left_over, allocates=False, **given),
        together(last=port_kernel.along, allocates=False, **given),
    )


@cache
def _compiled() -> tuple[Any, ...]:
    return tuple(one.compiled for one in kernels())


def is_worth_compiling(points: int) -> bool:
    """Whether to work on the ports of so many systems and lines by compiled loops.

    Args:
        points: systems times lines.
    """
    if not has_numba():
        return False
    if _compiled.cache_info().currsize:
        return True
    return is_worth_it(
        "ports", points * _SECONDS, COMPILATION, lambda: all(one.is_stored() for one in kernels())
    )
