"""A UFF file cut into its datasets, each dataset 58 measured against what its header declares.

Nothing is allocated that the file does not hold: the declared count is compared with the bytes that stand
between the header and the end tag before any value is read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from flexmodal.campaign.uff.header import HEADER_LINES, Header, Unreadable, parse_header
from flexmodal.errors import Fault
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList

LARGEST = 1_000_000_000
"""The most a UFF file may hold [bytes]."""
MOST_RECORDS = 100_000
"""More datasets than this are no campaign."""
MOST_FAULTS = 100
"""After as many faults the rest of a file is not looked at."""

_TAG = re.compile(rb"    -1 *\r?(?:\n|\Z)")
_LINE_TAG = re.compile(rb"^    -1 *\r?(?:\n|\Z)", re.MULTILINE)
_BINARY_TAG = re.compile(rb"(?:\r?\n)?    -1 *\r?(?:\n|\Z)")
_DATASET = re.compile(rb" *(\d{1,6})([bB]?)([^\r\n]*)\r?(?:\n|\Z)")
_BLANK = re.compile(rb"(?:[ \t]*\r?\n)*")
NODES, TRACE_LINE, SHAPE = (15, 2411), 82, 55
"""Numbers of the datasets of nodes."""
_INTEL, _MOTOROLA = 1, 2


@dataclass(frozen=True)
class Dataset:
    """One sound dataset 58."""

    number: int
    """Its place among the datasets of the file, from 1."""
    header: Header
    header_lines: tuple[bytes, ...]
    """Records 6 to 11 as they stand."""
    binary: bool
    little_endian: bool
    data: bytes
    """Exactly the declared values: bytes, or lines of whole fields."""


@dataclass(frozen=True)
class Other:
    """A dataset of nodes: their places, trace lines between them, or a shape."""

    number: int
    """Its place among the datasets of the file, from 1."""
    kind: int
    body: bytes
    """What stands between its number and its end tag."""


@dataclass(frozen=True)
class UffContent:
    """The datasets 58 of a file, those of nodes, and what was passed over."""

    datasets: tuple[Dataset, ...]
    warnings: tuple[str, ...]
    others: tuple[Other, ...] = ()


def scan_uff(file: Path, faults: FaultList) -> UffContent:
    """Cut a UFF file into datasets; faults go to `faults`, and only sound datasets come back.

    Args:
        file: a universal file.
        faults: where the faults of the file go.
    """
    content = read_regular(file, limit=LARGEST, kind="a universal file")
    if isinstance(content, Fault):
        faults.faults.append(content)
        return UffContent((), ())
    datasets: list[Dataset] = []
    others: list[Other] = []
    passed: dict[int, int] = {}
    place, number, before = 0, 0, len(faults.faults)
    while (place := _after_blank(content, place)) < len(content):
        number += 1
        if number > MOST_RECORDS:
            faults.add(f"dataset {number}", f"more than {MOST_RECORDS} datasets", "fewer in a file")
            break
        if len(faults.faults) - before >= MOST_FAULTS:
            faults.add(f"dataset {number}", "too many faults to go on", "a sound universal file")
            break
        following = _dataset(content, place, number, (datasets, others), passed, faults)
        if following is None:
            break
        place = following
    if not datasets and not others and len(faults.faults) == before:
        faults.add("", "no dataset 58", "FRFs or time histories as datasets 58")
    warnings = [
        f"{file}: {count} dataset{'s' * (count > 1)} {kind} left out"
        for kind, count in passed.items()
        if kind not in (151, 164)
    ]
    return UffContent(tuple(datasets), tuple(warnings), tuple(others))


def _dataset(
    content: bytes,
    place: int,
    number: int,
    found: tuple[list[Dataset], list[Other]],
    passed: dict[int, int],
    faults: FaultList,
) -> int | None:
    """Take up the dataset at `place`; where the next one begins, or None where that cannot be known."""
    key = f"dataset {number}"
    tag = _TAG.match(content, place)
    if tag is None:
        faults.add(key, f"no start tag at byte {place}", "a line with -1 in columns 5 and 6")
        return None
    kind = _DATASET.match(content, tag.end())
    if kind is None:
        faults.add(key, "no dataset number after the start tag", "58, or another number")
        return None
    if int(kind[1]) != 58:
        end = _LINE_TAG.search(content, kind.end())
        if end is None:
            faults.add(key, "no end tag", "a line with -1 in columns 5 and 6 after each dataset")
            return None
        body = content[kind.end() : end.start()]
        if int(kind[1]) in (*NODES, TRACE_LINE, SHAPE):
            found[1].append(Other(number, int(kind[1]), body))
        else:
            passed[int(kind[1])] = passed.get(int(kind[1]), 0) + 1
        if int(kind[1]) == 164:
            _check_units(body, key, faults)
        return end.end()
    one = _dataset_58(content, kind, key, faults)
    if one.header is not None:
        found[0].append(Dataset(number, one.header, one.lines, bool(kind[2]), one.little, one.data))
    return one.after


@dataclass(frozen=True)
class _Found:
    """A dataset 58 as far as it could be read; without a header it is not sound."""

    after: int | None
    header: Header | None = None
    lines: tuple[bytes, ...] = ()
    little: bool = True
    data: bytes = b""


def _dataset_58(content: bytes, kind: re.Match[bytes], key: str, faults: FaultList) -> _Found:
    lines, start = _lines(content, kind.end())
    try:
        header = parse_header(lines)
        little = not kind[2] or _is_little_endian(kind[3])
    except Unreadable as error:
        faults.add(f"{key}: {error.field}", error.found, error.allowed)
        return _Found(_after_tag(content, kind.end(), _BINARY_TAG if kind[2] else _LINE_TAG, key, faults))
    if kind[2]:
        size = header.numbers * (8 if header.is_double else 4)
        end = _BINARY_TAG.match(content, start + size) if start + size <= len(content) else None
        if end is None:
            _add_miscount(content, start, size, key, faults)
            return _Found(_after_tag(content, start, _BINARY_TAG, key, faults))
        return _Found(end.end(), header, tuple(lines[5:]), little, content[start : start + size])
    end = _LINE_TAG.search(content, start)
    data = _text_values(content[start : len(content) if end is None else end.start()], header, key, faults)
    after = _after_tag(content, start, _LINE_TAG, key, faults)
    return _Found(after, None if data is None or end is None else header, tuple(lines[5:]), True, data or b"")


def _lines(content: bytes, place: int) -> tuple[list[bytes], int]:
    """The eleven header lines after `place`, fewer at the end of the file, and where the data begin."""
    lines = []
    for _ in range(HEADER_LINES):
        end = content.find(b"\n", place, place + 1000)
        if end < 0:
            break
        lines.append(content[place:end].removesuffix(b"\r"))
        place = end + 1
    return lines, place


def _after_tag(content: bytes, place: int, tag: re.Pattern[bytes], key: str, faults: FaultList) -> int | None:
    end = tag.search(content, place)
    if end is None:
        faults.add(key, "no end tag", "a line with -1 in columns 5 and 6 after each dataset")
        return None
    return end.end()


def _is_little_endian(fields: bytes) -> bool:
    """From the rest of the line `58b`: byte order and floating-point format."""
    order, layout = fields[:6].strip(), fields[6:12].strip()
    if order not in (b"1", b"2"):
        raise Unreadable("byte order", repr(order.decode("latin-1")), "1 little endian or 2 big endian")
    if layout != b"2":
        raise Unreadable("floating-point format", repr(layout.decode("latin-1")), "2, IEEE 754")
    return order == b"1"


def _add_miscount(content: bytes, start: int, size: int, key: str, faults: FaultList) -> None:
    end = _BINARY_TAG.search(content, start)
    there = (len(content) if end is None else end.start()) - start
    faults.add(key, f"{there} bytes of data", f"{size}, as its count and type declare")


def _after_blank(content: bytes, place: int) -> int:
    match = _BLANK.match(content, place)
    place = place if match is None else match.end()
    return len(content) if not content[place : place + 1000].strip(b" \t\r\n\x1a\0") else place


def _text_values(text: bytes, header: Header, key: str, faults: FaultList) -> bytes | None:
    """The lines of ASCII values, checked to hold whole fields and as many as declared."""
    if not re.fullmatch(rb"[-+0-9.eE \r\n]*", text):
        odd = re.search(rb"[^-+0-9.eE \r\n]+", text)
        word = "" if odd is None else odd[0][:20].decode("latin-1")
        not_finite = word.lower() in ("nan", "inf", "n", "infinity")
        found = f"{word!r}, which is not finite" if not_finite else f"{word!r} among the values"
        faults.add(key, found, "finite numbers")
        return None
    ends = _column_ends(header)
    lines = [line.rstrip() for line in text.split(b"\n")]
    lines = [line for line in lines if line]
    if any(len(line) != ends[-1] for line in lines[:-1]) or (lines and len(lines[-1]) not in ends):
        widths = "lines that are not of whole fields"
        faults.add(key, widths, f"fields that end at columns {', '.join(map(str, ends))}")
        return None
    there = (len(lines) - 1) * len(ends) + ends.index(len(lines[-1])) + 1 if lines else 0
    if there != header.numbers:
        faults.add(key, f"{there} numbers", f"{header.numbers}, as its count and type declare")
        return None
    return b"".join(line + b"\n" for line in lines)


def _column_ends(header: Header) -> list[int]:
    """Where the fields of a line of values end: 6E13.5, 4E20.12, 2(E13.5,E20.12) or E13.5,2E20.12."""
    if not header.is_double:
        widths = [13] * 6
    elif header.even:
        widths = [20] * 4
    else:
        widths = [13, 20, 20] if header.is_complex else [13, 20] * 2
    return [sum(widths[: place + 1]) for place in range(len(widths))]


def _check_units(text: bytes, key: str, faults: FaultList) -> None:
    """Dataset 164: the file's units must be SI, that is factors of 1."""
    lines = text.decode("latin-1").splitlines()
    second = lines[1] if len(lines) > 1 else ""
    for name, field in (("length", second[:25]), ("force", second[25:50])):
        try:
            factor = float(field.strip().upper().replace("D", "E"))
        except ValueError:
            faults.add(f"{key}: {name} factor", repr(field.strip()[:30]), "a number, 1 for SI units")
            continue
        if not abs(factor - 1) < 1e-9:
            faults.add(f"{key}: {name} factor", f"{factor:g}", "1: SI units")
