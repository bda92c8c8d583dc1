"""What a record that ends before the structure has come to rest leaves out of an FRF.

A blow at t = 0 is followed for a time T. What comes later is missing from the measured receptance,

    Δα(s) = −Σ_p u_p v_p (λ_p/s)^k e^{(λ_p − s)T} / (s − λ_p),

summed over all 2n poles, with k = 2 for accelerometers, 1 for velocity, 0 for displacement. It is exact for
blows that are short beside T, at any decay; at s = iω + σ under an exponential window. For a mode of 0.8 Hz
and 6 % damping in a record of 4 s it is a third of the motion. Hysteretic stiffness enters as the viscous
damping that is equal in the middle of the band.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Complex
from scipy.linalg import expm

from flexmodal.errors import SingularResponse
from flexmodal.modal import NO_MODES
from flexmodal.structure.definite import is_definite
from flexmodal.structure.poles import poles
from flexmodal.structure.solution import Solved, solved
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import Axis, Structure

NOTHING = 1e-5
"""Where every mode has decayed to less than this part, nothing is left out."""


def missing(
    structure: Structure, axis: Axis, pairs: np.ndarray, names: tuple[str, ...] = ()
) -> tuple[Complex[np.ndarray, "pair line"], Complex[np.ndarray, "name pair line"]] | None:
    """Receptance that the end of the record cuts off [m/N], and its derivatives; None where it is nothing.

    Args:
        structure: in one posture.
        axis: with the length of the records after the blow.
        pairs: [pair, 2], numbers of a response and a reference row.
        names: parameters.
    """
    if structure.loss_factor:
        lost = structure.loss_factor * structure.loss / (2 * np.pi * axis.middle)
        structure = replace(structure, damping=structure.damping + lost)
    try:
        if (_slowest(structure) - axis.decay) * axis.length < np.log(NOTHING):
            return None
        found = poles(structure, names, active=True)
    except NO_MODES:  # nothing can be said
        return None
    pole, s, length = found.pole, axis.s, axis.length
    near = s - pole[:, None]  # [pole, line]
    kept = np.where(pole == 0, 1.0, pole)[:, None]
    motion = -((pole[:, None] / s) ** axis.power) * np.exp(-near * length) / near
    slope = motion * (axis.power / kept + length + 1 / near)  # along λ
    rows, struck = structure.response[pairs[:, 0]], structure.reference[pairs[:, 1]]
    u, v = rows @ found.shape, struck @ found.shape  # [pair, pole]
    value = (u * v) @ motion
    if not names:
        return value, np.zeros((0, *value.shape), dtype=complex)
    du, dv = rows @ found.shape_slope, struck @ found.shape_slope  # [name, pair, pole]
    for number, name in enumerate(names):
        change = structure.changes.get(name)
        if change is not None and change.response is not None:
            du[number] += change.response[pairs[:, 0]] @ found.shape
        if change is not None and change.reference is not None:
            dv[number] += change.reference[pairs[:, 1]] @ found.shape
    moved = np.concatenate([du * v + u * dv, u * v * found.pole_slope[:, None]], axis=2)
    return value, moved @ np.concatenate([motion, slope])


def missing_of(found: Solved) -> Complex[np.ndarray, "entry line"] | None:
    """The same of many systems at once, without derivatives; None where it is nothing.

    From the state at the end of the record, x(T) and ẋ(T) after a blow, instead of the modes,

        Δα(s) = e^{−sT} (−y_uᵀ [M ẋ + (C + s M) x] + u x/s + u ẋ/s²),

    without the last term for a velocity sensor and the last two for one of displacement. Both are the same.

    Raises:
        SingularResponse: what rings up beyond any number within a record.
    """
    many, axis, entries = found.structures, found.axis, found.entries
    if many.loss_factor:
        if not _outlasting(many, axis).any():
            return None
        return missing_of(solved(_viscous(many, axis), axis, entries, compiled=found.compiled))
    n, length, s = many.mass.shape[1], axis.length, axis.s
    try:
        spring, damper = (np.linalg.solve(many.mass, part) for part in (many.stiffness, many.damping))
    except np.linalg.LinAlgError:
        return _one_by_one(found)
    unit = np.sqrt(np.abs(spring).max(axis=(1, 2)))[:, None, None]  # velocities in the size of elongations
    state = np.zeros((len(many), 2 * n, 2 * n))
    state[:, :n, n:], state[:, n:, :n], state[:, n:, n:] = np.eye(n) * unit, -spring / unit, -damper
    slowest = np.linalg.eigvals(state).real.max(axis=1)
    if slowest.max() > 0 and not is_definite(many.mass):
        return _one_by_one(found)
    some = (slowest - axis.decay) * length >= np.log(NOTHING)
    if not some.any():
        return None
    struck = np.linalg.solve(many.mass, np.swapaxes(many.reference, 1, 2)) / unit
    with np.errstate(over="ignore", invalid="ignore"):  # of a trial that rings up: no fit goes there
        end = (expm(state * length)[:, :, n:] @ struck) * some[:, None, None]
    x, v = end[:, :n], end[:, n:] * unit
    still, moving = many.mass @ v + many.damping @ x, many.mass @ x  # system, dof, struck
    system, u, k = entries.table.T
    y = found.y[system, u]
    load = still[system, :, k][:, :, None] + s * moving[system, :, k][:, :, None]
    value = -np.einsum("enl,enl->el", y[:, :, 0] + 1j * y[:, :, 1], load)
    rows = many.response[system, u]
    if axis.power >= 1:
        value += np.einsum("en,en->e", rows, x[system, :, k])[:, None] / s
    if axis.power == 2:
        value += np.einsum("en,en->e", rows, v[system, :, k])[:, None] / s**2
    lost = np.asarray(value * np.exp(-s * length))
    if not np.isfinite(lost).all():
        raise SingularResponse("the structure rings up beyond any number within a record")
    return lost


def _viscous(many: Structures, axis: Axis) -> Structures:
    """Hysteretic springs with the viscous damping that is equal in the middle of the band."""
    lost = many.loss_factor * many.loss / (2 * np.pi * axis.middle)
    return replace(
        many, damping=many.damping + lost, loss_factor=0.0, loss_slopes={}, names=(), slopes={}, turned={}
    )


def _one_by_one(found: Solved) -> Complex[np.ndarray, "entry line"] | None:
    lost = missing_with_slopes(found, ())
    return None if lost is None else lost[0]


def missing_with_slopes(
    found: Solved, names: tuple[str, ...]
) -> tuple[Complex[np.ndarray, "entry line"], Complex[np.ndarray, "name entry line"]] | None:
    """What the ends of the records of many systems cut off, and derivatives along parameters.

    Args:
        found: the systems, solved.
        names: parameters.
    """
    table, axis = found.entries.table, found.axis
    value = np.zeros((len(table), len(axis)), dtype=complex)
    slopes = np.zeros((len(names), *value.shape), dtype=complex)
    some = False
    for k in np.flatnonzero(_outlasting(found.structures, axis)).tolist():
        rows = np.flatnonzero(table[:, 0] == k)
        lost = missing(found.structures[k], axis, table[rows, 1:], names)
        if lost is not None:
            value[rows], slopes[:, rows], some = *lost, True
    return (value, slopes) if some else None


def _outlasting(many: Structures, axis: Axis) -> Bool[np.ndarray, " system"]:
    """Whether a system may still move at the end of a record; without shapes: nearly all records are long."""
    n = many.mass.shape[1]
    damping = _viscous(many, axis).damping
    state = np.zeros((len(many), 2 * n, 2 * n))
    state[:, :n, n:] = np.eye(n)
    try:
        state[:, n:] = -np.linalg.solve(many.mass, np.concatenate([many.stiffness, damping], axis=2))
        slowest = np.linalg.eigvals(state).real.max(axis=1)
    except np.linalg.LinAlgError:  # each for itself
        return np.ones(len(many), dtype=bool)
    return np.asarray((slowest - axis.decay) * axis.length >= np.log(NOTHING) - 1e-6)


def _slowest(structure: Structure) -> float:
    """Largest real part of a pole [1/s]; without shapes, since nearly every record is long enough."""
    n = structure.dof
    lower = -np.linalg.solve(structure.mass, np.hstack([structure.stiffness, structure.damping]))
    companion = np.vstack([np.eye(n, 2 * n, n), lower])
    return float(np.linalg.eigvals(companion).real.max())
