"""`modes.csv`: modal parameters somebody identified."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.mode_table import ModeTable
from flexmodal.errors import Fault
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, listing, shown

HEADER = (
    "posture",
    "response",
    "reference",
    "mode",
    "natural_frequency",
    "damping_ratio",
    "amplitude_re",
    "amplitude_im",
    "flag",
)
ERRORS = ("frequency_error", "damping_error", "amplitude_error")
"""Standard errors, which a table may have behind the others: all three or none."""
LARGEST = 50_000_000
"""The most a table may hold [bytes]."""
MOST_FAULTS = 100

_IDS, _NUMBERS = HEADER[:4], HEADER[4:8]


def read_modes(file: Path, tested: Tested, faults: FaultList) -> ModeTable | None:
    """Read `modes.csv`; None where faults leave nothing sound.

    Args:
        file: a `modes.csv`.
        tested: what was tested.
        faults: where the faults of the file go.
    """
    before = len(faults.faults)
    names, rows = _read(file, (HEADER, HEADER + ERRORS), faults)
    own = (*_NUMBERS, *names[len(HEADER) :])
    known = {
        "posture": [posture.id for posture in tested.postures],
        "response": [point.id for point in tested.points],
        "reference": [point.id for point in tested.points],
    }
    ids, numbers, flags = [], [], []
    for line, row in rows:
        if len(faults.faults) - before >= MOST_FAULTS:
            faults.add(f"line {line}", "too many faults to go on", "a sound table")
            break
        if len(row) != len(names):
            faults.add(f"line {line}", f"{len(row)} fields", f"{len(names)}: {listing(names)}")
            continue
        fields = dict(zip(names, row, strict=True))
        ids.append([_id(name, fields[name], known.get(name), line, faults) for name in _IDS])
        numbers.append([_number(name, fields[name], line, faults) for name in own])
        if math.isnan(numbers[-1][2]) != math.isnan(numbers[-1][3]):
            faults.add(f"line {line}", "half an amplitude", "amplitude_re and amplitude_im, or neither")
        flags.append(fields["flag"])
    if len(faults.faults) > before:
        return None
    if not flags:
        faults.add("", "no rows", "one row at least below the header")
        return None
    whole, real = np.array(ids, dtype=int), np.array(numbers, dtype=float)
    return ModeTable(
        posture=whole[:, 0],
        response=whole[:, 1],
        reference=whole[:, 2],
        mode=whole[:, 3],
        natural_frequency=real[:, 0],
        damping_ratio=real[:, 1],
        amplitude=real[:, 2] + 1j * real[:, 3],
        flag=tuple(flags),
        **{name: real[:, 4 + k] for k, name in enumerate(names[len(HEADER) :])},
    )


def write_modes(modes: ModeTable, path: Path) -> None:
    """Write the table to a new file.

    Args:
        modes: what to write.
        path: a new file.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        errors = [getattr(modes, name) for name in ERRORS]
        known = all(error is not None for error in errors)
        writer.writerow(HEADER + ERRORS if known else HEADER)
        ids = np.column_stack([modes.posture, modes.response, modes.reference, modes.mode]).tolist()
        columns = (modes.natural_frequency, modes.damping_ratio, modes.amplitude.real, modes.amplitude.imag)
        numbers = np.column_stack(columns).tolist()
        more = np.column_stack(errors).tolist() if known else [[] for _ in ids]
        for row, values, flag, error in zip(ids, numbers, modes.flag, more, strict=True):
            writer.writerow([*row, *map(_cell, values), flag, *map(_cell, error)])


def _cell(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def read_rows(file: Path, header: tuple[str, ...], faults: FaultList) -> list[tuple[int, list[str]]]:
    """Line number and fields of each row below the header, which has to be this one.

    Args:
        file: the file.
        header: names of its columns.
        faults: where the faults of the file go.
    """
    return _read(file, (header,), faults)[1]


def _read(
    file: Path, headers: tuple[tuple[str, ...], ...], faults: FaultList
) -> tuple[tuple[str, ...], list[tuple[int, list[str]]]]:
    """The header, one of these, and the rows below it."""
    content = read_regular(file, limit=LARGEST, kind="a table")
    if isinstance(content, Fault):
        faults.faults.append(content)
        return headers[0], []
    try:
        text = content.decode("utf-8-sig")
        reader = csv.reader(text.splitlines(), strict=True)
        rows = [(reader.line_num, row) for row in reader if row]
    except UnicodeDecodeError as error:
        faults.add("", f"a byte that is not UTF-8, at {error.start}", "a table in UTF-8")
        return headers[0], []
    except csv.Error as error:
        faults.add("", f"text that is no table ({error})", "comma-separated values")
        return headers[0], []
    first = tuple(field.strip() for field in rows[0][1]) if rows else ()
    if first not in headers:
        found = ",".join(rows[0][1]) if rows else ""
        faults.add("line 1", shown(found), " or ".join(",".join(header) for header in headers))
        return headers[0], []
    return first, rows[1:]


def _id(name: str, text: str, known: list[int] | None, line: int, faults: FaultList) -> int:
    text = text.strip()
    if not text.isascii() or not text.isdigit() or len(text) > 10 or int(text) == 0:
        faults.add(f"line {line}: {name}", shown(text), "a whole number, 1 or more")
        return 0
    if known is not None and int(text) not in known:
        faults.add(f"line {line}: {name}", text, f"an id of campaign.toml: {listing(map(str, known))}")
    return int(text)


def _number(name: str, text: str, line: int, faults: FaultList) -> float:
    text = text.strip()
    if not text:
        return math.nan
    try:
        value = float(text) if "_" not in text else math.nan
    except ValueError:
        value = math.nan
    above = name != "natural_frequency" or value > 0
    if not math.isfinite(value) or not above:
        allowed = "a number above 0 in Hz" if name == "natural_frequency" else "a finite number"
        faults.add(f"line {line}: {name}", shown(text), f"{allowed}, or nothing where it is missing")
    return value
