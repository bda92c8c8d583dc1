"""How a table that nobody described is laid out: separator, decimal sign, header, units, direction."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from flexmodal.campaign.tables.arrays import SUFFIXES, variables
from flexmodal.errors import Fault, InvalidCampaign, MissingExtra
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList

LARGEST = 200_000_000
LOOKED_AT = 400
"""Lines that are looked at."""
FEWEST = 3
"""Rows of numbers, one after the other, that a table has."""
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eEdD][+-]?\d+)?")


@dataclass(frozen=True)
class Sniffed:
    """A table as it seems to be laid out."""

    headers: tuple[str, ...]
    units: tuple[str, ...]
    """Of each column, from rows under the header or from brackets in it; empty where there is none."""
    delimiter: str = ","
    decimal: str = "."
    skip: int = 0
    units_rows: int = 0
    transposed: bool = False
    sheet: str | None = None


def sniff(file: Path) -> Sniffed:
    """Look at a table.

    Args:
        file: text, .xlsx, .mat or HDF5.

    Raises:
        InvalidCampaign: no table that numbers can be found in.
        MissingExtra: a kind of file whose reader is not installed.
    """
    if file.suffix.lower() in SUFFIXES:
        return _arrays(file)
    content = read_regular(file, limit=LARGEST, kind="a table")
    if isinstance(content, Fault):
        raise InvalidCampaign(content)
    found = _best_sheet(content) if file.suffix.lower() == ".xlsx" else _best_text(content)
    if found is None:
        allowed = f"a header over {FEWEST} rows of numbers or more, or beside as many columns"
        raise InvalidCampaign(Fault(str(file), "", "no table of numbers", allowed))
    return found


def _arrays(file: Path) -> Sniffed:
    faults: list[Fault] = []
    shapes = variables(file, FaultList(file, faults))
    if faults:
        raise InvalidCampaign(faults)
    names: list[str] = []
    units: list[str] = []
    for name, (shape, unit) in shapes.items():
        sides = [side for side in shape if side > 1]
        own = [name] if len(sides) == 1 else []
        if len(sides) == 2:
            own = [f"{name}[{number}]" for number in range(1, min(*sides, 30) + 1)]
        names += own
        units += [unit] * len(own)
    if not names:
        raise InvalidCampaign(Fault(str(file), "", "no variable of numbers", "rows, columns or matrices"))
    return Sniffed(tuple(names), tuple(units))


def _best_text(content: bytes) -> Sniffed | None:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    lines = text.splitlines()[:LOOKED_AT]
    best, most = None, 0
    for delimiter in ("\t", ";", ",", " "):
        for decimal in (".", ","):
            if delimiter == decimal == ",":
                continue
            rows = list(_split(lines, delimiter))
            found, size = _laid_out(rows, decimal)
            if found is not None and size > most:
                best, most = _sniffed(found, delimiter, decimal), size
    return best


def _split(lines: Sequence[str], delimiter: str) -> Iterator[list[str]]:
    for line in lines:
        if delimiter == " ":
            yield line.split()
        else:
            try:
                yield next(csv.reader(io.StringIO(line), delimiter=delimiter), [])
            except csv.Error:
                yield [line]


def _best_sheet(content: bytes) -> Sniffed | None:
    try:
        import openpyxl
    except ImportError as error:
        raise MissingExtra("reading .xlsx needs openpyxl: pip install flexmodal[excel]") from error
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            if sum(entry.file_size for entry in packed.infolist()) > LARGEST:
                return None
        book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        for name in book.sheetnames:
            cells = book[name].iter_rows(values_only=True, max_row=LOOKED_AT)
            rows = [["" if cell is None else str(cell) for cell in row] for row in cells]
            found, _ = _laid_out(rows, ".")
            if found is not None:
                return _sniffed(found, ",", ".", name)
    except Exception:  # a spoilt archive raises whatever zipfile, xml and openpyxl meet
        return None
    return None


_Laid = tuple[tuple[str, ...], tuple[str, ...], int, int, bool]


def _sniffed(laid: _Laid, delimiter: str, decimal: str, sheet: str | None = None) -> Sniffed:
    headers, units, skip, units_rows, transposed = laid
    return Sniffed(headers, units, delimiter, decimal, skip, units_rows, transposed, sheet)


def _laid_out(rows: Sequence[Sequence[str]], decimal: str) -> tuple[_Laid | None, int]:
    """Headers, units, lines to skip, rows of units, direction; and how many numbers speak for that."""
    upright = _upright(rows, decimal)
    lying = _lying(rows, decimal)
    return max((upright, lying), key=lambda one: one[1])


def _upright(rows: Sequence[Sequence[str]], decimal: str) -> tuple[_Laid | None, int]:
    numeric = [_are_numbers(row, decimal) for row in rows]
    first, length = _longest(numeric, [len(_filled(row)) for row in rows])
    width = len(_filled(rows[first])) if length else 0
    if length < FEWEST or width < 2:
        return None, 0
    above: list[int] = []
    for place in range(first - 1, max(first - 4, -1), -1):
        if len(_filled(rows[place])) >= max(2, width - 1):
            above.insert(0, place)
        else:
            break
    if not above:
        return None, 0
    header = above[0]
    units_rows = first - header - 1
    names = [cell.strip() for cell in rows[header]][:width]
    under = [cell.strip() for cell in rows[header + 1]] if units_rows else []
    units = [under[k] if k < len(under) else "" for k in range(len(names))]
    return (tuple(names), _units(names, units), header, units_rows, False), length * width


def _lying(rows: Sequence[Sequence[str]], decimal: str) -> tuple[_Laid | None, int]:
    """Each row a column, its header first, perhaps a unit after it."""
    for units in (0, 1):
        fits = [
            len(row) > FEWEST + units
            and not _is_number(row[0], decimal)
            and bool(row[0].strip())
            and _are_numbers(row[1 + units :], decimal)
            for row in rows
        ]
        first, length = _longest(fits, [len(_filled(row)) for row in rows])
        if length >= 2 and len(rows[first]) > length:
            names = [rows[k][0].strip() for k in range(first, first + length)]
            under = [rows[k][1].strip() if units else "" for k in range(first, first + length)]
            laid = (tuple(names), _units(names, under), first, units, True)
            return laid, length * (len(rows[first]) - 1 - units)
    return None, 0


def _longest(flags: Sequence[bool], widths: Sequence[int]) -> tuple[int, int]:
    """Begin and length of the longest run of rows that fit and are equally wide."""
    best, start = (0, 0), -1
    for place, fits in enumerate([*flags, False]):
        if start >= 0 and (not fits or widths[place] != widths[start]):
            if place - start > best[1]:
                best = (start, place - start)
            start = -1
        if fits and start < 0:
            start = place
    return best


def _units(names: Sequence[str], under: Sequence[str]) -> tuple[str, ...]:
    """Units under the header, else those in brackets in it."""
    found = []
    for name, unit in zip(names, under, strict=True):
        bracket = re.search(r"[\[(]([^\])]*)[\])]", name)
        found.append(unit.strip("[]() ") or (bracket[1].strip() if bracket else ""))
    return tuple(found)


def _filled(row: Sequence[str]) -> list[str]:
    """Cells without the empty ones at the end."""
    cells = list(row)
    while cells and not cells[-1].strip():
        cells.pop()
    return cells


def _are_numbers(row: Sequence[str], decimal: str) -> bool:
    cells = _filled(row)
    return bool(cells) and all(_is_number(cell, decimal) for cell in cells)


def _is_number(cell: str, decimal: str) -> bool:
    text = cell.strip()
    other = "," if decimal == "." else "."
    return other not in text and _NUMBER.fullmatch(text) is not None
