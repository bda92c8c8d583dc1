"""Observations in slices: those of one posture that share a structure."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from flexmodal.identification import Observations


@dataclass(frozen=True, eq=False)
class Slice:
    """Observations of one posture that share a structure."""

    posture: int
    rows: np.ndarray
    where: np.ndarray
    struck: np.ndarray
    pairs: np.ndarray
    points: tuple[str, ...]
    """Name of the response point of each row of `where`."""
    read: tuple[str, ...]
    """The same of each observation."""
    level: int
    reference: tuple[int, int]
    response: tuple[int, int]


def slices(observations: Observations, wanted: Collection[str]) -> list[Slice]:
    """Slices of all observations, posture by posture.

    Args:
        observations: to be divided.
        wanted: what structures depend on besides the posture: "blow", "response" (`Effect.variants`).
    """
    return [
        _slice(observations, posture, rows)
        for posture in range(len(observations.postures))
        for rows in _split(observations, np.flatnonzero(observations.posture == posture), wanted)
    ]


def _split(observations: Observations, rows: np.ndarray, wanted: Collection[str]) -> list[np.ndarray]:
    """Observations of a posture that share a structure and a window."""
    if not rows.size:
        return []
    columns = [np.array(observations.decays)[observations.level[rows]][:, None]]
    if "blow" in wanted:
        columns += [observations.level[rows][:, None], observations.reference[rows]]
    if "response" in wanted:
        columns.append(observations.response[rows][:, :1])
    table = np.hstack([np.asarray(column, dtype=float) for column in columns])
    _, label = np.unique(table, axis=0, return_inverse=True)
    return [rows[label.ravel() == k] for k in range(int(label.max()) + 1)]


def _slice(observations: Observations, posture: int, rows: np.ndarray) -> Slice:
    where, response = np.unique(observations.response[rows], axis=0, return_inverse=True)
    struck, reference = np.unique(observations.reference[rows], axis=0, return_inverse=True)
    names = {p.id: p.name for p in observations.campaign.points}
    hit, felt = observations.reference[rows[0]].tolist(), observations.response[rows[0]].tolist()
    return Slice(
        posture=posture,
        rows=rows,
        where=where,
        struck=struck,
        pairs=np.stack([response.ravel(), reference.ravel()], axis=1),
        points=tuple(names[int(number)] for number, _ in where.tolist()),
        read=tuple(names[int(number)] for number in observations.response[rows, 0].tolist()),
        level=int(observations.level[rows[0]]),
        reference=(hit[0], hit[1]),
        response=(felt[0], felt[1]),
    )
