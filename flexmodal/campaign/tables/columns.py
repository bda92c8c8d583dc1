"""Columns of numbers from a CSV or an XLSX, by their headers."""

from __future__ import annotations

import csv
import io
import math
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import numpy as np

from flexmodal.errors import Fault, MissingExtra
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, listing, nearest, shown

LARGEST = 200_000_000
"""The most a table may hold [bytes], an XLSX unpacked."""
MOST_COLUMNS = 10_000
MOST_FAULTS = 20


@dataclass(frozen=True)
class Layout:
    """How a table is laid out."""

    sheet: str | None
    delimiter: str
    decimal: str
    skip: int
    units_rows: int = 0
    """Rows under the header that hold no numbers."""
    transposed: bool = False
    """Whether each row is a column, its header first."""


def read_columns(
    file: Path, layout: Layout, wanted: Sequence[str], faults: FaultList
) -> dict[str, np.ndarray] | None:
    """The wanted columns as finite numbers; None where faults were found.

    Args:
        file: a .csv or .xlsx.
        layout: sheet, delimiter, decimal sign, lines to skip.
        wanted: headers of the columns.
        faults: where the faults of the file go.

    Raises:
        MissingExtra: an XLSX without openpyxl installed.
    """
    content = read_regular(file, limit=LARGEST, kind="a table")
    if isinstance(content, Fault):
        faults.faults.append(content)
        return None
    read = _xlsx_rows if file.suffix.lower() == ".xlsx" else _csv_rows
    rows = read(content, layout, faults)
    if rows is None:
        return None
    try:
        return _numbers(rows, layout, wanted, faults)
    except (csv.Error, UnicodeDecodeError) as error:
        faults.add("", f"text that is no table ({str(error)[:60]})", "rows of separated values")
    except Exception as error:  # a spoilt sheet raises whatever openpyxl meets
        faults.add("", f"a sheet that cannot be read ({type(error).__name__})", "a sound .xlsx")
    return None


def _csv_rows(content: bytes, layout: Layout, faults: FaultList) -> Iterator[Sequence[object]] | None:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # units such as µ or ² from older analysers
    if layout.delimiter == " ":
        return (line.split() for line in text.splitlines())
    return iter(csv.reader(io.StringIO(text, newline=""), delimiter=layout.delimiter, strict=True))


def _xlsx_rows(content: bytes, layout: Layout, faults: FaultList) -> Iterator[Sequence[object]] | None:
    try:
        import openpyxl
    except ImportError as error:
        raise MissingExtra("reading .xlsx needs openpyxl: pip install flexmodal[excel]") from error
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            size = sum(entry.file_size for entry in packed.infolist())
        if size > LARGEST:
            faults.add("", f"{size / 1e6:.0f} MB unpacked", f"at most {LARGEST / 1e6:g} MB")
            return None
        book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
    except Exception as error:  # a spoilt archive raises whatever zipfile, xml and openpyxl meet
        faults.add("", f"a workbook that cannot be read ({type(error).__name__})", "a sound .xlsx")
        return None
    name = layout.sheet or book.sheetnames[0]
    if name not in book.sheetnames:
        faults.add("sheet", shown(name), f"{nearest(name, book.sheetnames)}{listing(book.sheetnames)}")
        return None
    return iter(book[name].iter_rows(values_only=True))


def _numbers(
    rows: Iterator[Sequence[object]], layout: Layout, wanted: Sequence[str], faults: FaultList
) -> dict[str, np.ndarray] | None:
    before = len(faults.faults)
    for _ in range(layout.skip):
        next(rows, None)
    if layout.transposed:
        kept = [list(row) for row in rows if not _is_blank(row)][:MOST_COLUMNS]
        rows = zip_longest(*kept)
    header = [str(cell).strip() if cell is not None else "" for cell in next(rows, ())][:MOST_COLUMNS]
    for _ in range(layout.units_rows):
        next(rows, None)
    where: dict[str, int] = {}
    for name in dict.fromkeys(wanted):
        if header.count(name) == 1:
            where[name] = header.index(name)
        else:
            found = "no such column" if name not in header else f"{header.count(name)} of that name"
            faults.add(
                f"column {shown(name)}", found, f"{nearest(name, header)}one of {listing(header[:20])}"
            )
    if len(faults.faults) > before:
        return None
    values: dict[str, list[float]] = {name: [] for name in where}
    for line, row in enumerate(rows, start=layout.skip + layout.units_rows + 2):
        if _is_blank(row):
            continue
        for name, place in where.items():
            cell = row[place] if place < len(row) else None
            value = _number(cell, layout.decimal)
            if not math.isfinite(value):
                faults.add(f"row {line}, column {shown(name)}", shown(cell or ""), "a finite number")
            values[name].append(value)
        if len(faults.faults) - before >= MOST_FAULTS:
            break
    if len(faults.faults) > before:
        return None
    return {name: np.array(column) for name, column in values.items()}


def _is_blank(row: Iterable[object]) -> bool:
    return all(cell is None or not str(cell).strip() for cell in row)


def _number(cell: object, decimal: str) -> float:
    if isinstance(cell, bool) or cell is None:
        return math.nan
    if isinstance(cell, int | float):
        return float(cell) if abs(cell) < 1e300 else math.nan
    text = str(cell).strip()
    if decimal == ",":
        text = text.replace(".", "x").replace(",", ".")
    try:
        return float(text) if "_" not in text else math.nan
    except ValueError:
        return math.nan
