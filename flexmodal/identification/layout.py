"""Which observations share a structure, an axis and a receptance; found once for some observations."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int, Shaped

from flexmodal.structure.solution import Entries


@dataclass(frozen=True, eq=False)
class Part:
    """Observations on one axis: systems, a structure each, and receptances of them."""

    level: int
    """Kind of blow whose axis they are measured on."""
    posture: Int[np.ndarray, " system"]
    """Number of the posture of each system."""
    blow: Int[np.ndarray, " system"]
    """Kind of blow, for structures that depend on it."""
    reference: Int[np.ndarray, "system 2"]
    """Hammer point and direction, likewise."""
    response: Int[np.ndarray, "system 2"]
    """Response point and direction, for structures that depend on it."""
    where: Int[np.ndarray, "row 2"]
    """Point id and direction of the response rows."""
    struck: Int[np.ndarray, "struck 2"]
    """The same of the blows."""
    responses: Int[np.ndarray, "system own"] | None
    """Which rows of `where` each system has, some perhaps twice; all of them if None."""
    references: Int[np.ndarray, "system own"] | None
    """The same of `struck`."""
    entries: Entries
    """Receptances; those of several kinds of blow are one where the structure is."""
    observations: Int[np.ndarray, " observation"]
    """Their numbers."""
    entry: Int[np.ndarray, " observation"]
    """The receptance of each."""

    @cached_property
    def read(self) -> Int[np.ndarray, "entry 2"]:
        """Response point and direction of each entry."""
        system, u, _ = self.entries.table.T
        return self.where[u if self.responses is None else self.responses[system, u]]

    @property
    def key(self) -> tuple[Hashable, ...]:
        """What structures in these postures, seen and struck there, are known by."""
        tables = (self.posture, self.where, self.struck, self.responses, self.references)
        return tuple(None if table is None else table.tobytes() for table in tables)

    def seen(self, rows: Float[np.ndarray, "system row dof"]) -> Float[np.ndarray, "system own dof"]:
        """Of every row of `where` in every system, those that it has."""
        return rows if self.responses is None else np.take_along_axis(rows, self.responses[:, :, None], 1)

    def hit(self, rows: Float[np.ndarray, "system struck dof"]) -> Float[np.ndarray, "system own dof"]:
        """Of every row of `struck` in every system, those that it has."""
        return rows if self.references is None else np.take_along_axis(rows, self.references[:, :, None], 1)

    @cached_property
    def members(self) -> tuple[Int[np.ndarray, " some"], ...]:
        """Of each system, which of the observations."""
        system = self.entries.table[self.entry, 0]
        return tuple(np.flatnonzero(system == k) for k in range(len(self.posture)))


def unmeasured(
    count: int, responses: Int[np.ndarray, "row 2"], references: Int[np.ndarray, "struck 2"]
) -> Part:
    """A system for each of so many postures with nothing measured on it.

    Args:
        count: of postures.
        responses: point and direction of the rows.
        references: point and direction of the blows.
    """
    none = np.zeros(0, dtype=int)
    blank = np.zeros((count, 2), dtype=int)
    entries = Entries(np.zeros((0, 3), dtype=int), (len(responses), len(references)))
    still = np.zeros(count, dtype=int)
    return Part(
        0, np.arange(count), still, blank, blank, responses, references, None, None, entries, none, none
    )


@dataclass(frozen=True, eq=False)
class Layout:
    """What observations are of."""

    posture: Int[np.ndarray, " observation"]
    response: Int[np.ndarray, "observation 2"]
    reference: Int[np.ndarray, "observation 2"]
    level: Int[np.ndarray, " observation"]
    axes: tuple[tuple[float, float], ...]
    """Decay of the window and length of the records of each kind of blow."""

    def parts(self, variants: Collection[str] = ()) -> tuple[Part, ...]:
        """For structures that depend, besides the posture, on "blow", "response", both or neither."""
        return self._made[frozenset(variants) & {"blow", "response"}]

    @cached_property
    def _made(self) -> Mapping[frozenset[str], tuple[Part, ...]]:
        kinds = (
            frozenset[str](),
            frozenset({"blow"}),
            frozenset({"response"}),
            frozenset({"blow", "response"}),
        )
        return {kind: self._parts(kind) for kind in kinds}

    def _parts(self, variants: frozenset[str]) -> tuple[Part, ...]:
        axis = np.array([sorted({*self.axes}).index(one) for one in self.axes], dtype=int)[self.level]
        return tuple(self._part(np.flatnonzero(axis == one), variants) for one in np.unique(axis))

    def _part(self, rows: Int[np.ndarray, " some"], variants: frozenset[str]) -> Part:
        posture, response = self.posture[rows], self.response[rows]
        reference, level = self.reference[rows], self.level[rows]
        key = [posture[:, None]]
        if "blow" in variants:
            key += [level[:, None], reference]
        if "response" in variants:
            key.append(response[:, :1])
        _, first, system = np.unique(np.hstack(key), axis=0, return_index=True, return_inverse=True)
        where, u = np.unique(response, axis=0, return_inverse=True)
        struck, v = np.unique(reference, axis=0, return_inverse=True)
        system, u, v = system.ravel(), u.ravel(), v.ravel()
        responses, u = _own(system, u) if "response" in variants else (None, u)
        references, v = _own(system, v) if "blow" in variants else (None, v)
        every = np.column_stack([system, u, v])
        table, entry = np.unique(every, axis=0, return_inverse=True)
        return Part(
            level=int(level[0]),
            posture=posture[first],
            blow=level[first],
            reference=reference[first],
            response=response[first],
            where=where,
            struck=struck,
            responses=responses,
            references=references,
            entries=Entries(table, (_width(responses, where), _width(references, struck))),
            observations=rows,
            entry=entry.ravel(),
        )


def _own(
    system: Int[np.ndarray, " observation"], row: Int[np.ndarray, " observation"]
) -> tuple[Int[np.ndarray, "system own"], Int[np.ndarray, " observation"]]:
    """The rows of each system, the first again where others have more, and each observation's among them."""
    pairs, number = np.unique(np.column_stack([system, row]), axis=0, return_inverse=True)
    first = np.searchsorted(pairs[:, 0], np.arange(pairs[:, 0].max() + 1))
    place = np.arange(len(pairs)) - first[pairs[:, 0]]
    own = np.repeat(pairs[first, 1][:, None], place.max() + 1, axis=1)
    own[pairs[:, 0], place] = pairs[:, 1]
    return own, place[number.ravel()]


def _width(own: Int[np.ndarray, "system own"] | None, every: Int[np.ndarray, "row 2"]) -> int:
    """How many rows a system has."""
    return len(every) if own is None else own.shape[1]


def summed(
    value: Shaped[np.ndarray, "observation line"], entry: Int[np.ndarray, " observation"], count: int
) -> Shaped[np.ndarray, "entry line"]:
    """Sums over the observations of each entry.

    Args:
        value: of every observation.
        entry: to which each of them belongs.
        count: of entries.
    """
    if len(entry) == count:  # one each
        found = np.empty_like(value)
        found[entry] = value
        return found
    order = np.argsort(entry, kind="stable")
    first = np.searchsorted(entry[order], np.arange(count))  # every entry has an observation
    return np.add.reduceat(value[order], first, axis=0)
