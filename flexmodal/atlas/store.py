"""The Zarr store of an atlas: made whole with everything but its chunks, then filled chunk by chunk.

A chunk is a file of each array. It is written beside its place and renamed, so that it is there whole or not
at all; CRC-32C behind it tells one that a power cut has spoilt. Nothing else says what is done: what
stands is.
"""

from __future__ import annotations

import json
import os
import uuid
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmodal.atlas.direct import memory_for, write_file
from flexmodal.atlas.layout import CHECKSUM, Layout
from flexmodal.atlas.plan import Plan, versions
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest, MissingExtra
from flexmodal.files import whole_folder

if TYPE_CHECKING:
    import zarr

KEY = "flexmodal"
"""Attribute of the group that says what the store is."""
MARK = "zarr.json"
PARTIAL = ".partial"
"""How the name of a file ends that is still being written."""
_PIECE = 1 << 18
"""Bytes copied at a time: they stay in the cache while their checksum is made."""
_MOST_TEXT = 64_000_000
"""Bytes of the group's attributes that are read; grids of millions of values are all in it."""


def zarr_library() -> Any:
    """The zarr library.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        import zarr
    except ImportError:
        raise MissingExtra("an atlas needs zarr and xarray: pip install flexmodal[atlas]") from None
    return zarr


@contextmanager
def quietly() -> Iterator[None]:
    """Without zarr's warning that consolidated metadata are not in the specification of Zarr 3 yet."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Consolidated metadata")
        yield


def create(plan: Plan, path: Path) -> None:
    """Make a store with its labels and attributes and without any chunk of its results.

    Args:
        plan: what the atlas is to hold.
        path: of the new store.

    Raises:
        OutputExists: something stands there.
        NotWritten: it cannot be written.
        MissingExtra: zarr is not installed.
    """
    library = zarr_library()
    with whole_folder(path) as scratch, quietly():
        group = library.create_group(store=str(scratch), zarr_format=3, attributes=_attributes(plan))
        for name, values in _labels(plan).items():
            _put_labels(group, name, values, plan)
        for one in plan.variables:
            group.create_array(
                one.name,
                shape=(*plan.points.shape, *plan.tail(one)),
                chunks=(*plan.chunk, *plan.tail(one)),
                dtype=one.dtype,
                compressors=[library.codecs.Crc32cCodec()],
                filters=None,
                fill_value=np.array(np.nan, dtype=one.dtype)[()],
                dimension_names=(*plan.points.dims, *one.dims),
                attributes={"units": one.unit, "long_name": one.meaning},
                config={"write_empty_chunks": True},
            )
        library.consolidate_metadata(str(scratch))


def _attributes(plan: Plan) -> dict[str, Any]:
    own = {one.name for one in plan.quantity.variables}
    others = [one.name for one in plan.variables if one.name not in own]
    return {
        "title": f"{plan.robot.name}: {plan.quantity.name} of {plan.points.count:,} postures",
        "coordinates": " ".join([*others, *plan.points.held]),
        KEY: {**plan.facts, "versions": versions()},
    }


def _labels(plan: Plan) -> dict[str, Any]:
    found: dict[str, Any] = dict(plan.labels)
    joints = plan.points.facts().get("joints", {})
    found |= {name: np.array(joints[name]) for name in plan.points.dims if name in joints}
    return found | {name: np.array(value) for name, value in plan.points.held.items()}


def _put_labels(group: zarr.Group, name: str, values: Any, plan: Plan) -> None:
    given = np.asarray(values)
    units = {"frequency": "Hz", "spindle_speed": "1/min"}
    joints = plan.robot.commanded
    unit = ("m" if joints[name].is_prismatic else "rad") if name in joints else units.get(name)
    text = given.dtype.kind == "U"
    array = group.create_array(
        name,
        shape=given.shape,
        dtype=str if text else "float64",
        dimension_names=(name,) if given.ndim else (),
        attributes={} if unit is None else {"units": unit},
    )
    array[...] = given.astype(object) if text else given


def facts_of(path: Path) -> dict[str, Any] | None:
    """What a folder says it is; None where no atlas of ours stands there.

    Raises:
        InvalidRequest: it is one of a format that this version does not know.
    """
    mark = path / MARK
    if not mark.is_file() or mark.stat().st_size > _MOST_TEXT:
        return None
    try:
        found = json.loads(mark.read_text(encoding="utf-8"))["attributes"][KEY]
    except (ValueError, KeyError, TypeError, UnicodeDecodeError):
        return None
    if not isinstance(found, dict):
        return None
    if found.get("format") != 1:
        raise InvalidRequest(Fault(str(mark), f"attributes.{KEY}.format", str(found.get("format"))[:60], "1"))
    return found


def is_sound(layout: Layout, path: Path, number: int) -> bool:
    """Whether a chunk's checksums are right.

    Args:
        layout: of the store.
        path: of the store.
        number: of the chunk.
    """
    try:
        found = [np.fromfile(file, dtype=np.uint8) for file, _ in layout.files(path, number)]
    except OSError:
        return False
    return all(_checksum(one[:-CHECKSUM]) == one[-CHECKSUM:].tobytes() for one in found)


@dataclass(frozen=True, eq=False)
class Bytes:
    """An array of a chunk as it stands in its file, its checksum last."""

    file: Path
    content: memoryview
    """This thread's until it makes the next chunk."""


def make_chunk(plan: Plan, path: Path, number: int) -> list[Bytes]:
    """Compute a chunk: the bytes that zarr would write, without its three copies.

    Args:
        plan: what the store is to hold.
        path: of the store.
        number: of the chunk.

    Raises:
        FlexmodalError: the store is not to be seen from here.
    """
    if not (path / MARK).is_file():
        text = f"{path}: no such store on this machine; every worker has to see the same folder"
        raise FlexmodalError(text)
    found = plan.compute(number)
    made = []
    files = plan.layout.files(path, number)
    for place, (one, (file, _)) in enumerate(zip(plan.variables, files, strict=True)):
        content = _content(found.pop(one.name), one.dtype, (*plan.chunk, *plan.tail(one)))
        made.append(Bytes(file, _with_checksum(content, place)))
    return made


def put_chunk(made: Sequence[Bytes], path: Path) -> None:
    """Put a chunk's arrays into their places.

    Args:
        made: by `make_chunk`.
        path: of the store.

    Raises:
        FlexmodalError: it cannot be written.
    """
    try:
        for one in made:
            _put(one)
    except OSError as error:
        text = f"{error.filename or path}: {error.strerror or error}; the chunks that stand are whole"
        raise FlexmodalError(text) from error


def _content(values: np.ndarray, dtype: str, shape: tuple[int, ...]) -> np.ndarray:
    if values.shape != shape:  # at an end: chunks are kept full
        whole = np.full(shape, np.nan, dtype=dtype)
        whole[tuple(slice(size) for size in values.shape)] = values
        values = whole
    return np.ascontiguousarray(values, dtype=np.dtype(dtype).newbyteorder("<")).reshape(-1).view(np.uint8)


def _put(one: Bytes) -> None:
    file = one.file
    file.parent.mkdir(parents=True, exist_ok=True)
    scratch = file.with_name(f"{file.name}.{uuid.uuid4().hex}{PARTIAL}")
    try:
        write_file(scratch, one.content)
        scratch.replace(file)
    except OSError:
        scratch.unlink(missing_ok=True)
        raise


def _with_checksum(content: np.ndarray, place: int) -> memoryview:
    """Bytes copied to where they are written from, and their CRC-32C on the way, while they are at hand."""
    import google_crc32c  # as zarr itself

    out = memory_for(len(content) + CHECKSUM, place)
    copied, checksum = np.frombuffer(out, dtype=np.uint8), 0
    for first in range(0, len(content), _PIECE):
        piece = copied[first : min(first + _PIECE, len(content))]
        piece[:] = content[first : first + len(piece)]
        checksum = int(google_crc32c.extend(checksum, piece))
    out[len(content) :] = checksum.to_bytes(CHECKSUM, "little")
    return out


def _checksum(content: np.ndarray) -> bytes:
    import google_crc32c  # as zarr itself

    return int(google_crc32c.value(content)).to_bytes(CHECKSUM, "little")


def sweep_out(path: Path) -> None:
    """Remove what a killed process was still writing."""
    for where, _, names in os.walk(path):
        for name in names:
            if name.endswith(PARTIAL):
                Path(where, name).unlink(missing_ok=True)
