"""The point of a link at which something is attached, by free functions of its motions and turns.

What is attached at a point p with the dynamic stiffness Z is, seen from another point, C = −Z [p]× between
the motions there and the turns, whatever stands against turning besides.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.effects.added_mass import SHORTEST
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import along
from flexmodal.diagnosis.effects.free_function import FreeFunction

MIDDLE = 0.5
"""Of the length of a link: where such functions are taken."""


def lever_of(context: Context, where: str) -> float:
    """The length of a link, which turns are multiplied by so that all functions are in N/m [m].

    Args:
        context: of the diagnosis.
        where: the link.
    """
    return max(along(context, where)[0], SHORTEST)


def at_its_point(
    context: Context, where: str, free: FreeFunction
) -> tuple[FreeFunction, Complex[np.ndarray, "line turn turn"]]:
    """The functions of the motions at the point where they are attached, and those of the turns there.

    Args:
        context: of the diagnosis.
        where: the link.
        free: of motions at the middle of the link, along it and across it, and of turns about these, times
            `lever_of`; in the plane about its normal.

    Returns:
        The first, and what stands against turning about that point [N·m/rad].
    """
    ways, lever = 2 if context.normal is not None else 3, lever_of(context, where)
    tensor = free.tensor.copy()
    tensor[:, ways:] *= lever
    tensor[:, :, ways:] *= lever
    some = (free.frequency > 0) & np.isfinite(free.value).all(axis=0)
    each = tensor[some] / (2 * np.pi * free.frequency[some, None, None]) ** 2
    place = point_of(each[:, :ways, :ways], each[:, :ways, ways:])
    told = dict(zip(("along", "beside", "above"), place.tolist(), strict=False))
    row, column = np.triu_indices(ways)
    swept = np.tensordot(place, _swept(ways), axes=1)
    moves = tensor[:, :ways, :ways]
    turns = tensor[:, ways:, ways:] - swept.T @ moves @ swept
    found = replace(
        free,
        value=moves[:, row, column].T,
        geometry={**told, "along": MIDDLE + told["along"] / lever},
        turns=False,
        information=None,
    )
    return found, turns


def _swept(ways: int) -> Float[np.ndarray, "way each turn"]:
    """Motions of a point by turns, for each coordinate of the point."""
    if ways == 2:
        return np.array([[[0.0], [1.0]], [[-1.0], [0.0]]])
    return np.stack([np.cross(np.eye(3), unit).T for unit in np.eye(3)])


def point_of(
    moves: Complex[np.ndarray, "line way way"], turns: Complex[np.ndarray, "line way turn"]
) -> Float[np.ndarray, " way"]:
    """Where p is [m], from the origin, by least squares.

    Args:
        moves: Z, of motions.
        turns: C, between motions and turns: three in space, one in the plane.
    """
    columns = np.stack([(moves @ one).ravel() for one in _swept(moves.shape[-1])], axis=1)
    found = np.linalg.lstsq(
        np.concatenate([columns.real, columns.imag]), np.concatenate([turns.real.ravel(), turns.imag.ravel()])
    )
    return np.asarray(found[0])
