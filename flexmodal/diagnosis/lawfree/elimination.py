"""The functions of a ported model eliminated line by line, some of one cell each and some of all cells."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.diagnosis.lawfree.equations import Equations
from flexmodal.identification.descent import short_step

Damping = tuple[float, Float[np.ndarray, "cell each"]]
"""Of the parameters, and of the functions line by line: where a step overshoots it bars no other's way."""


def stepped(
    equations: Equations,
    damping: Damping,
    prior: tuple[Float[np.ndarray, "parameter parameter"], Float[np.ndarray, " parameter"]],
    bound: tuple[Bool[np.ndarray, " parameter"], Bool[np.ndarray, " parameter"]],
    common: Bool[np.ndarray, " function"],
) -> tuple[Float[np.ndarray, " parameter"], Complex[np.ndarray, "cell function line"]]:
    """Steps of the parameters, none where they are held, and of the functions.

    Args:
        equations: at a state.
        damping: part of the diagonals that is added, of the parameters and of each line's functions.
        prior: its precision of the parameters, and half its slope along them.
        bound: whether parameters are at their lower bound, and at their upper one.
        common: functions that are the same in all cells.
    """
    diagonal = np.einsum("clff->clf", equations.zz).real
    zz = equations.zz + damping[1][..., None, None] * diagonal[..., None] * np.eye(equations.zz.shape[-1])
    found = solved(zz, np.concatenate([equations.zp, equations.z[..., None]], axis=-1), common)
    step = np.zeros(len(equations.p))
    if len(step):
        pull = equations.p + prior[1]
        free = ~((bound[0] & (pull > 0)) | (bound[1] & (pull < 0)))
        turned = equations.zp.conj()
        schur = equations.pp + prior[0] - np.einsum("clfp,clfq->pq", turned, found[..., :-1]).real
        pull = pull - np.einsum("clfp,clf->p", turned, found[..., -1]).real
        schur = schur + np.diag(damping[0] * np.diag(schur) + 1e-12)
        if free.any():
            step[free] = short_step(schur[np.ix_(free, free)], pull[free])
    return step, -np.swapaxes(found[..., -1] + found[..., :-1] @ step, 1, 2)


def solved(
    matrix: Complex[np.ndarray, "cell line function function"],
    right: Complex[np.ndarray, "cell line function side"],
    common: Bool[np.ndarray, " function"],
) -> Complex[np.ndarray, "cell line function side"]:
    """Solve the normal equations of each line.

    Where functions are common to all cells the system of a line is an arrow: those of each cell follow from
    the common ones, whose own equations are the Schur complement, summed over the cells.

    Args:
        matrix: of each cell by itself.
        right: right-hand sides of each cell by itself.
        common: functions that are the same in all cells; each cell has its part of their equations.

    Returns:
        Every function of every cell; the common ones are repeated.

    Raises:
        numpy.linalg.LinAlgError: a matrix is singular.
    """
    if not common.any():
        return np.linalg.solve(matrix, right)
    own, shared = np.flatnonzero(~common), np.flatnonzero(common)
    beside, across = matrix[:, :, own[:, None], shared], matrix[:, :, shared[:, None], own]
    each = np.linalg.solve(
        matrix[:, :, own[:, None], own], np.concatenate([beside, right[:, :, own]], axis=-1)
    )
    led, free = each[..., : len(shared)], each[..., len(shared) :]
    schur = np.sum(matrix[:, :, shared[:, None], shared] - across @ led, axis=0)
    alike = np.linalg.solve(schur, np.sum(right[:, :, shared] - across @ free, axis=0))
    found = np.empty(right.shape, dtype=complex)
    found[:, :, shared] = alike
    found[:, :, own] = free - led @ alike
    return found
