"""How the postures of an atlas are cut into chunks, and which files a chunk is."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

Slices = tuple[slice, ...]
CHECKSUM = 4
"""Bytes of CRC-32C behind each chunk."""


@dataclass(frozen=True)
class Stored:
    """An array over the postures."""

    name: str
    tail: tuple[int, ...]
    """Lengths of its dimensions behind the postures'."""
    item: int
    """Of one number [bytes]."""


@dataclass(frozen=True)
class Layout:
    """Postures, chunks and arrays of a store."""

    shape: tuple[int, ...]
    """Of all postures."""
    chunk: tuple[int, ...]
    """Of the postures of a chunk."""
    arrays: tuple[Stored, ...]

    @property
    def counts(self) -> tuple[int, ...]:
        """How many chunks lie along each dimension."""
        return tuple(-(-whole // size) for whole, size in zip(self.shape, self.chunk, strict=True))

    @property
    def chunks(self) -> int:
        """How many there are."""
        return math.prod(self.counts)

    @property
    def size(self) -> int:
        """Of all chunks on disk; those at the ends are kept full [bytes]."""
        return self.chunks * sum(self._bytes(one) for one in self.arrays)

    def region(self, number: int) -> tuple[tuple[int, ...], Slices]:
        """Place of a chunk among the chunks, and the postures in it.

        Args:
            number: of the chunk, the last dimension fastest.
        """
        place = tuple(int(one) for one in np.unravel_index(number, self.counts))
        ends = zip(place, self.chunk, self.shape, strict=True)
        return place, tuple(slice(one * size, min((one + 1) * size, whole)) for one, size, whole in ends)

    def files(self, path: Path, number: int) -> list[tuple[Path, int]]:
        """The file of each array of a chunk, and its size [bytes].

        Args:
            path: of the store.
            number: of the chunk.
        """
        place, _ = self.region(number)
        found = []
        for one in self.arrays:
            parts = [str(index) for index in (*place, *(0 for _ in one.tail))]
            found.append((path.joinpath(one.name, "c", *parts), self._bytes(one)))
        return found

    def stands(self, path: Path, number: int) -> bool:
        """Whether a chunk is there, as far as the sizes of its files tell.

        Args:
            path: of the store.
            number: of the chunk.
        """
        for file, size in self.files(path, number):
            try:
                if os.stat(file).st_size != size:
                    return False
            except OSError:
                return False
        return True

    def _bytes(self, one: Stored) -> int:
        return math.prod((*self.chunk, *one.tail)) * one.item + CHECKSUM


def chunk_shape(shape: tuple[int, ...], most: int) -> tuple[int, ...]:
    """Shape of chunks of at most so many postures: whole along the last dimensions, then a part of one.

    Args:
        shape: of all postures.
        most: postures of a chunk.
    """
    sizes, left = [], max(1, most)
    for size in reversed(shape):
        take = min(size, left)
        if take < size:
            parts = -(-size // take)
            whole = [one for one in range(take, take // 2, -1) if size % one == 0]
            take = whole[0] if whole else -(-size // parts)
        sizes.append(take)
        left = left // take if take == size else 1
    return tuple(reversed(sizes))
