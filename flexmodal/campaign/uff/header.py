"""The eleven header records of a UFF dataset 58, read by column and doubted field by field.

pyuff trusts these fields: a shifted column or a lying count comes back as data. Here each has to be what
its FORTRAN format says before pyuff sees it.

Source: the published description of universal dataset 58 (SDRL, University of Cincinnati).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

HEADER_LINES = 11
"""Five identification lines, then records 6 to 11."""
_ODD = re.compile(rb"[^ -~]")
_INTEGER = re.compile(r" *[+-]?\d+ *")
_REAL = re.compile(r" *[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)? *")

_IDENTITY = (5, 10, 5, 10, 1, 10, 10, 4, 1, 10, 10, 4)
_FORM = (10, 10, 10, 13, 13, 13)
_CHARACTER = (10, 5, 5, 5, 1, 20, 1, 20)


@dataclass(frozen=True)
class Character:
    """What an axis or an ordinate is: specific data type, unit exponents, unit label."""

    code: int
    exponents: tuple[int, int, int]
    """Of length, force and temperature."""
    unit: str


@dataclass(frozen=True)
class Header:
    """The fields of one dataset 58 that count."""

    function: int
    sequence: int
    version: int
    load_case: int
    response: tuple[int, int]
    reference: tuple[int, int]
    value_type: int
    """2 real single, 4 real double, 5 complex single, 6 complex double."""
    count: int
    even: bool
    start: float
    step: float
    abscissa: Character
    numerator: Character
    denominator: Character

    @property
    def is_complex(self) -> bool:
        """Whether each value has two parts."""
        return self.value_type in (5, 6)

    @property
    def is_double(self) -> bool:
        """Whether each number takes eight bytes."""
        return self.value_type in (4, 6)

    @property
    def numbers(self) -> int:
        """How many numbers the data part holds."""
        return self.count * (int(not self.even) + 1 + int(self.is_complex))


class Unreadable(Exception):
    """A header that breaks its format: the field and what stands there."""

    def __init__(self, field: str, found: str, allowed: str) -> None:
        super().__init__(field)
        self.field, self.found, self.allowed = field, found, allowed


def parse_header(lines: list[bytes]) -> Header:
    """Read the header.

    Args:
        lines: the eleven lines, without line ends; fewer are a fault.

    Raises:
        Unreadable: the first field that breaks its format; the later ones cannot be trusted then.
    """
    if len(lines) < HEADER_LINES:
        raise Unreadable("header", f"{len(lines)} lines", f"{HEADER_LINES} before the data")
    text = [_plain(line, number) for number, line in enumerate(lines, start=1)]
    where = _fields(text[5], _IDENTITY, 6)
    if any(where[blank].strip() for blank in (4, 8)):
        allowed = "names of at most 10 characters, a version of at most 5 digits, nodes of at most 10"
        raise Unreadable("record 6", "fields that are shifted", allowed)
    names = ("function type", "function identification number", "version number", "load case number")
    function, sequence, version, load_case = (
        _integer(where[place], name) for place, name in enumerate(names)
    )
    form = _fields(text[6], _FORM, 7)
    value_type = _integer(form[0], "ordinate data type")
    if value_type not in (2, 4, 5, 6):
        raise Unreadable("ordinate data type", str(value_type), "2, 4, 5 or 6")
    spacing = _integer(form[2], "abscissa spacing")
    if spacing not in (0, 1):
        raise Unreadable("abscissa spacing", str(spacing), "0 uneven or 1 even")
    count = _integer(form[1], "number of values")
    if count < 2:
        raise Unreadable("number of values", str(count), "2 or more")
    start = _real(form[3], "abscissa minimum") if spacing else 0.0
    step = _real(form[4], "abscissa increment") if spacing else 0.0
    if spacing and not step > 0:
        raise Unreadable("abscissa increment", f"{step:g}", "a step above 0")
    return Header(
        function=function,
        sequence=sequence,
        version=version,
        load_case=load_case,
        response=(_integer(where[6], "response node"), _integer(where[7], "response direction")),
        reference=(_integer(where[10], "reference node"), _integer(where[11], "reference direction")),
        value_type=value_type,
        count=count,
        even=bool(spacing),
        start=start,
        step=step,
        abscissa=_character(text[7], 8),
        numerator=_character(text[8], 9),
        denominator=_character(text[9], 10),
    )


def _plain(line: bytes, number: int) -> str:
    """The line as text; identification lines may say anything, the others only printable ASCII."""
    if number <= 5:
        return ""
    if _ODD.search(line):
        raise Unreadable(f"record {number}", "bytes that are no text", "printable ASCII")
    text = line.decode("ascii").rstrip()
    if len(text) > 80:
        raise Unreadable(f"record {number}", f"{len(text)} characters", "at most 80: are fields shifted?")
    return text


def _fields(text: str, widths: tuple[int, ...], number: int) -> list[str]:
    fields, place = [], 0
    for width in widths:
        fields.append(text[place : place + width])
        place += width
    if text[place:].strip():
        raise Unreadable(
            f"record {number}", f"{text[place:].strip()!r} after the last field", "nothing there"
        )
    return fields


def _integer(field: str, name: str) -> int:
    if not _INTEGER.fullmatch(field):
        raise Unreadable(name, repr(field), "a whole number: are fields shifted?")
    return int(field)


def _real(field: str, name: str) -> float:
    value = float(field) if _REAL.fullmatch(field) else math.nan
    if not math.isfinite(value):
        raise Unreadable(name, repr(field), "a finite number")
    return value


def _character(text: str, number: int) -> Character:
    fields = _fields(text, _CHARACTER, number)
    code = _integer(fields[0], f"data type of record {number}")
    exponents = tuple(
        _integer(field, f"unit exponents of record {number}") if field.strip() else 0 for field in fields[1:4]
    )
    unit = fields[7].strip()
    return Character(code, (exponents[0], exponents[1], exponents[2]), "" if unit.upper() == "NONE" else unit)
