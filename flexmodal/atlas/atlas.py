"""An atlas on disk, opened for reading."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodal.atlas.layout import Layout, Stored
from flexmodal.atlas.plan import path_of
from flexmodal.atlas.points import MOST_POSTURES
from flexmodal.atlas.store import KEY, MARK, facts_of, zarr_library
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest, MissingExtra
from flexmodal.files import complete

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Atlas:
    """An atlas on disk. Get one with `open_atlas`."""

    path: Path
    facts: Mapping[str, Any]
    """What it holds: robot, points, quantity."""
    dataset: xarray.Dataset
    """All of it, labelled; read from disk as it is asked for."""
    layout: Layout

    @cached_property
    def standing(self) -> tuple[int, ...]:
        """Numbers of the chunks that are there."""
        return tuple(one for one in range(self.layout.chunks) if self.layout.stands(self.path, one))

    @property
    def is_complete(self) -> bool:
        """Whether all chunks are there."""
        return len(self.standing) == self.layout.chunks

    @property
    def quantity(self) -> str:
        """Receptance, modes, stiffness or depth."""
        return str(self.facts["quantity"]["name"])

    @property
    def source(self) -> Mapping[str, Any] | None:
        """What its receptances were predicted from: campaign, method, verdict; None for the robot itself."""
        found: Mapping[str, Any] | None = self.facts["quantity"].get("source")
        return found

    @property
    def is_grid(self) -> bool:
        """Whether its postures are a grid."""
        return self.facts["points"]["kind"] == "grid"

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """The commanded joints."""
        points = self.facts["points"]
        return tuple(points["joints"] if self.is_grid else points["ranges"])

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """First and last value of each joint [rad, m]."""
        points = self.facts["points"]
        given = points["joints"] if self.is_grid else points["ranges"]
        return {name: (float(values[0]), float(values[-1])) for name, values in given.items()}

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the postures."""
        return tuple(str(one) for one in self.dataset["tool"].dims[:-1])

    @property
    def along(self) -> list[str]:
        """Joints that are arrays over the postures, as in a sample."""
        return [name for name in self.joints if self.dataset[name].dims == ("posture",)]

    @cached_property
    def span(self) -> dict[str, float]:
        """Width of each joint's range; 1 where it stands still [rad, m]."""
        return {name: (high - low) or 1.0 for name, (low, high) in self.ranges.items()}

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Say in a sentence that a chunk is spoilt.

        Raises:
            FlexmodalError: it cannot be read.
        """
        try:
            yield
        except (ValueError, OSError) as error:
            text = f"{self.path}: a chunk cannot be read ({str(error)[:120]}); computing it again mends it"
            raise FlexmodalError(text) from error


def open_atlas(path: str | os.PathLike[str]) -> Atlas:
    """Open an atlas; nothing but its labels is read.

    Raises:
        InvalidRequest: no atlas stands there.
        MissingExtra: zarr or xarray is not installed.
    """
    library, target = zarr_library(), path_of(path)
    try:
        import xarray
    except ImportError:
        raise MissingExtra("reading an atlas needs xarray: pip install flexmodal[atlas]") from None
    complete(target)
    facts = facts_of(target)
    if facts is None:
        found = "no such folder" if not target.is_dir() else f"a folder without an atlas's {MARK}"
        raise InvalidRequest(Fault(str(target), "", found, "a store that flexmodal atlas made"))
    try:
        dataset = xarray.open_zarr(str(target), chunks=None, consolidated=True)
        group = library.open_group(str(target), mode="r")
        layout = _layout(group, facts)
        atlas = Atlas(target, facts, dataset, layout)
        _ = atlas.dims, atlas.joints, atlas.ranges, atlas.quantity
    except (KeyError, ValueError, TypeError, OSError, AttributeError, IndexError) as error:
        found = f"an atlas that cannot be opened: {str(error)[:120]}"
        raise InvalidRequest(
            Fault(str(target), "", found, f"one as it was made; its attribute {KEY}")
        ) from error
    return atlas


def _layout(group: Any, facts: Mapping[str, Any]) -> Layout:
    chunk = tuple(int(one) for one in facts["chunk"])
    rank = len(chunk)
    shape = tuple(group["tool"].shape[:rank])
    if math.prod(shape) > MOST_POSTURES or rank + 1 != group["tool"].ndim:
        raise ValueError("its size")
    arrays = [
        Stored(name, tuple(array.shape[rank:]), array.dtype.itemsize)
        for name, array in sorted(group.arrays())
        if array.shape[:rank] == shape
        and array.chunks[:rank] == chunk
        and name not in group["tool"].metadata.dimension_names
    ]
    return Layout(shape, chunk, tuple(arrays))
