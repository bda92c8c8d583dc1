"""Structures solved once for their rows and for the motions of ports, whose values are not known yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.structure import port_solution
from flexmodal.structure.port import CompliancePort, Port, StiffnessPort
from flexmodal.structure.ports import PortedStructures
from flexmodal.structure.solution import Entries, Solved, is_worth_compiling, solutions
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import Axis

RANK = 1e-10
"""Part of a pattern below which a motion is none."""


def with_ports(
    structures: Structures,
    axis: Axis,
    entries: Entries,
    ports: Sequence[Port],
    *,
    compiled: bool | None = None,
) -> PortedStructures:
    """Solve structures for their rows and the motions of ports.

    Args:
        structures: the believed ones.
        axis: where.
        entries: receptances that are wanted.
        ports: whose values follow.
        compiled: whether by compiled loops; by default, once these are worth loading.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    systems, dofs = structures.mass.shape[:2]
    coordinates = tuple(sorted({k for one in ports if isinstance(one, CompliancePort) for k in one.both}))
    unit = np.broadcast_to(np.eye(dofs)[:, list(coordinates)], (systems, dofs, len(coordinates)))
    patterns = [one.pattern for one in ports if isinstance(one, StiffnessPort)]
    basis = np.concatenate([unit, _spanning(patterns, unit)], axis=2)
    held = np.zeros((systems, basis.shape[2]))
    stiffness = structures.stiffness
    if coordinates:
        diagonal = np.einsum("sdd->sd", structures.mass)[:, list(coordinates)]
        held[:, : len(coordinates)] = diagonal * float(np.max(np.abs(axis.s)) ** 2)
        stiffness = stiffness + unit @ (held[:, : len(coordinates), None] * np.swapaxes(unit, 1, 2))
    rows = np.concatenate([structures.response, structures.reference, np.swapaxes(basis, 1, 2)], axis=1)
    wanted = np.zeros(rows.shape[:2], dtype=bool)
    wanted[:, sum(entries.rows) :] = True
    wanted[: len(entries.wanted), : sum(entries.rows)] = entries.wanted
    points = systems * len(axis)
    solve = is_worth_compiling(points) if compiled is None else compiled
    follow = port_solution.is_worth_compiling(points) if compiled is None else compiled
    y = solutions(replace(structures, stiffness=stiffness), axis, rows, wanted, compiled=solve)
    solved = Solved(structures, axis, entries, y, solve)
    return PortedStructures(tuple(ports), solved, basis, held, coordinates, follow and bool(ports))


def _spanning(
    patterns: Sequence[Float[np.ndarray, "system dof dof"]], unit: Float[np.ndarray, "system dof own"]
) -> Float[np.ndarray, "system dof port"]:
    """Motions that span patterns, as many in every system."""
    if not patterns:
        return np.zeros((*unit.shape[:2], 0))
    each = [pattern / (np.max(np.abs(pattern)) or 1.0) for pattern in patterns]
    left, size, _ = np.linalg.svd(np.concatenate(each, axis=2), full_matrices=False)
    return left[:, :, : max(1, int(np.max(np.sum(size > RANK * size[:, :1], axis=1))))]
