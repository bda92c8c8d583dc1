"""One dataset 58 or 58b: framed by pyuff, with the values of a binary one put in as a block.

pyuff packs every number of a binary dataset by a call of its own, reads the whole file again after each
dataset it adds, declares half the bytes of complex values, and leaves broken files when it overwrites binary
ones. So each dataset is written alone to a fresh file, a binary one with its first two values only; then the
counts of points and bytes in its header are put right and all values take the place of the two. A dataset
whose frame is not laid out as known here is left to pyuff from end to end.
"""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

STUB = 2
"""Values that pyuff needs to write a header: it takes the step from the second."""

_END = b"    -1\n"
_FIRST = re.compile(rb"    -1\n    58b.{24}(.{12}).{36}\n")
_COUNT_LINE = 8
"""The record that holds the number of points, counted in lines from the start tag."""


def framed(dataset: dict[str, Any], piece: Path) -> bytes:
    """The bytes of one dataset.

    Args:
        dataset: as pyuff takes it.
        piece: a path for pyuff to write to; what stands there goes.
    """
    if not dataset["binary"]:
        return _by_pyuff(dataset, piece)
    stub = {**dataset, "data": dataset["data"][:STUB], "x": dataset["x"][:STUB]}
    spliced = splice(_by_pyuff(stub, piece), stub, dataset)
    return spliced or with_size(_by_pyuff(dataset, piece), dataset)


def splice(frame: bytes, stub: dict[str, Any], dataset: dict[str, Any]) -> bytes | None:
    """The frame of a stub with all values in it; None where it is not laid out as known here.

    Args:
        frame: the bytes pyuff wrote for the stub.
        stub: the dataset with its first values only.
        dataset: the whole dataset, as pyuff takes it.
    """
    few = block(stub)
    head, tail = frame[: -len(few + _END)], frame[-len(few + _END) :]
    lines = head.splitlines(keepends=True)
    if tail != few + _END or _FIRST.match(head) is None or len(lines) != 13:
        return None
    counted = lines[_COUNT_LINE]
    if counted[10:20] != b"%10d" % len(stub["data"]):
        return None
    lines[_COUNT_LINE] = counted[:10] + b"%10d" % len(dataset["data"]) + counted[20:]
    return with_size(b"".join(lines), dataset) + block(dataset) + _END


def block(dataset: dict[str, Any]) -> bytes:
    """The values as dataset 58b holds them: abscissa where uneven, real and imaginary part, in turn."""
    data = np.asarray(dataset["data"])
    columns: list[Float[np.ndarray, " value"]] = [data.real, data.imag] if np.iscomplexobj(data) else [data]
    if not dataset["abscissa_spacing"]:
        columns.insert(0, np.asarray(dataset["x"], dtype=float))
    return np.stack(columns, axis=1).astype(float).tobytes()


def with_size(piece: bytes, dataset: dict[str, Any]) -> bytes:
    """A binary dataset with the true number of bytes in its first line; pyuff counts eight a value.

    Args:
        piece: the bytes of the dataset.
        dataset: the dataset, as pyuff takes it.
    """
    numbers = 1 + int(np.iscomplexobj(dataset["data"])) + int(not dataset["abscissa_spacing"])
    size = b"%12d" % (8 * numbers * len(dataset["data"]))
    start = piece.index(b"58b") + 3 + 24
    return piece[:start] + size + piece[start + 12 :]


def _by_pyuff(dataset: dict[str, Any], piece: Path) -> bytes:
    import pyuff

    piece.unlink(missing_ok=True)
    with warnings.catch_warnings():  # after binary data pyuff leaves closing to the garbage collector
        warnings.simplefilter("ignore", ResourceWarning)
        try:
            pyuff.UFF(str(piece)).write_sets([dict(dataset)], mode="add")
        except Exception as error:
            # pyuff turns whatever happens into a bare Exception: a full disk, even Ctrl-C
            if isinstance(error.__context__, OSError | KeyboardInterrupt):
                raise error.__context__ from None
            raise
    return piece.read_bytes()
