"""Columns of numbers from a MATLAB .mat, an HDF5 or a TDMS file: a variable, or a column of one, by its name.

`time` is a variable that is a row or a column of numbers, `data/H[3]` the third column of a matrix, counted
from 1; its lines are the side as long as the abscissa. Complex numbers stay complex.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign.tables.tdms import MAGIC, tdms_channels
from flexmodal.errors import Fault
from flexmodal.text.extras import extra
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, listing, nearest, shown

SUFFIXES = (".mat", ".h5", ".hdf5", ".hdf", ".tdms")
LARGEST = 500_000_000
"""The most such a file may hold [bytes]."""
_COLUMN = re.compile(r"(?P<name>.+?)\[(?P<number>\d+)\]")
_HDF5 = b"\x89HDF\r\n\x1a\n"


def read_arrays(file: Path, wanted: Sequence[str], faults: FaultList) -> dict[str, np.ndarray] | None:
    """The wanted variables as finite numbers, the first of them the abscissa; None where faults were found.

    Args:
        file: a .mat, of version 7.3 too, an HDF5 or a TDMS file.
        wanted: names of variables, perhaps with the number of a column; the abscissa first.
        faults: where the faults of the file go.

    Raises:
        MissingExtra: an HDF5 file without h5py installed, or a TDMS file without npTDMS.
    """
    content = read_regular(file, limit=LARGEST, kind="a file of arrays")
    if isinstance(content, Fault):
        faults.faults.append(content)
        return None
    names, get, _ = _opened(content, faults)
    if get is None:
        return None
    found: dict[str, np.ndarray] = {}
    lines = 0
    for name in dict.fromkeys(wanted):
        column = _column(name, lines, names, get, faults)
        if column is not None:
            found[name] = column
            lines = lines or len(column)
    return found if len(found) == len(dict.fromkeys(wanted)) else None


def variables(file: Path, faults: FaultList) -> dict[str, tuple[tuple[int, ...], str]]:
    """Names, shapes and units of the variables that hold numbers; no unit where none is stated.

    Args:
        file: a .mat, an HDF5 or a TDMS file.
        faults: where the faults of the file go.

    Raises:
        MissingExtra: an HDF5 file without h5py installed, or a TDMS file without npTDMS.
    """
    content = read_regular(file, limit=LARGEST, kind="a file of arrays")
    if isinstance(content, Fault):
        faults.faults.append(content)
        return {}
    names, get, units = _opened(content, faults)
    if get is None:
        return {}
    return {
        name: (value.shape, units.get(name, ""))
        for name in names
        if (value := get(name)) is not None and value.size > 1
    }


def _opened(
    content: bytes, faults: FaultList
) -> tuple[list[str], Callable[[str], np.ndarray | None] | None, Mapping[str, str]]:
    """Names of variables, a function that gives one as numbers, and units; none where it cannot be read."""
    try:
        if content[: len(MAGIC)] == MAGIC:
            values, units = tdms_channels(content)
            return list(values), lambda name: _numbers(values.get(name)), units
        # a MATLAB file of version 7.3 is HDF5 behind 512 bytes of its own
        is_hdf5 = _HDF5 in (content[:8], content[512:520])
        return (*(_hdf5(content) if is_hdf5 else _matlab(content)), {})
    except ImportError:
        raise
    except Exception as error:  # a spoilt file raises whatever its reader meets
        if type(error).__name__ == "MissingExtra":
            raise
        faults.add(
            "", f"a file that cannot be read ({type(error).__name__})", "a sound .mat, HDF5 or TDMS file"
        )
        return [], None, {}


def _matlab(content: bytes) -> tuple[list[str], Callable[[str], np.ndarray | None]]:
    from scipy.io import loadmat

    held = loadmat(io.BytesIO(content), simplify_cells=True)
    flat: dict[str, Any] = {}

    def gather(prefix: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                if not str(key).startswith("__"):
                    gather(f"{prefix}{key}/", inner)
        else:
            flat[prefix.rstrip("/")] = value

    gather("", held)
    return list(flat), lambda name: _numbers(flat.get(name))


def _hdf5(content: bytes) -> tuple[list[str], Callable[[str], np.ndarray | None]]:
    h5py = extra("h5py", "hdf5", "reading HDF5 files")
    names: list[str] = []
    with h5py.File(io.BytesIO(content), "r") as file:
        held: dict[str, Any] = {}

        def visit(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "iufcV" and item.size > 1:
                names.append(name)
                value = item[()]
                if value.dtype.names and set(value.dtype.names) >= {"real", "imag"}:  # MATLAB's complex
                    value = value["real"] + 1j * value["imag"]
                held[name] = value

        file.visititems(visit)
    return names, lambda name: _numbers(held.get(name))


def _numbers(value: Any) -> np.ndarray | None:
    array = np.asarray(value)
    if array.dtype.kind not in "iufc" or array.ndim > 2:
        return None
    return array.astype(complex if array.dtype.kind == "c" else float)


def _column(
    name: str, lines: int, names: Sequence[str], get: Callable[[str], np.ndarray | None], faults: FaultList
) -> np.ndarray | None:
    key, match = f"variable {shown(name)}", _COLUMN.fullmatch(name)
    base = match["name"] if match and name not in names else name
    array = get(base)
    if array is None:
        found = "no such variable" if base not in names else "no row, column or matrix of numbers"
        faults.add(key, found, f"{nearest(base, names)}one of {listing(list(names)[:20])}")
        return None
    array = np.atleast_1d(np.squeeze(array))
    if array.ndim == 2:
        if match is None or base == name:
            faults.add(key, f"a matrix of {array.shape[0]} × {array.shape[1]}", f"a column of it: {name}[1]")
            return None
        if lines and array.shape[0] != lines and array.shape[1] == lines:
            array = array.T
        number = int(match["number"])
        if not 1 <= number <= array.shape[1]:
            faults.add(key, f"column {number}", f"1 to {array.shape[1]}")
            return None
        array = array[:, number - 1]
    if lines and len(array) != lines:
        faults.add(key, f"{len(array)} values", f"{lines}, as the abscissa has")
        return None
    if not np.all(np.isfinite(array)):
        faults.add(key, "values that are not finite", "finite numbers")
        return None
    return array
