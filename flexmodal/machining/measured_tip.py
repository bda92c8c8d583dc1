"""A measured receptance of tool and spindle at the tip, from a table of lines."""

from __future__ import annotations

import csv
import io
import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidCut, InvalidFrequencies
from flexmodal.frf.axis import frequency_axis
from flexmodal.frf.direction import PointDirection
from flexmodal.frf.export import COLUMNS
from flexmodal.frf.form import FORMS, convert
from flexmodal.machining.tip_receptance import TipReceptance
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, listing, shown

_LARGEST = 200_000_000
_MOST_FAULTS = 20
_QUASI_STATIC = 0.3
"""Largest |Im| / |Re| of a direct receptance that still counts as that of a spring."""


@dataclass(frozen=True, eq=False)
class MeasuredTip(TipReceptance):
    """A 3 × 3 receptance on lines; linear between them.

    Below the first line the tool is a spring: the real part there is held, provided that its phase there is
    near 0. Above the last line nothing is known.
    """

    frequency: Float[np.ndarray, " line"]
    """Ascending, above 0 [Hz]."""
    value: Complex[np.ndarray, "line 3 3"]
    """Along x, y, z of the cut [m/N]."""

    def __post_init__(self) -> None:
        axis = frequency_axis(self.frequency)
        if len(axis) < 2 or self.value.shape != (len(axis), 3, 3) or not np.all(np.isfinite(self.value)):
            found = f"{len(axis)} lines and values of shape {self.value.shape}"
            raise InvalidCut(Fault("call", "receptance", found, "two lines or more, finite 3 × 3 matrices"))
        object.__setattr__(self, "frequency", axis)

    @property
    def lines(self) -> Float[np.ndarray, " line"]:
        """The lines measured [Hz]."""
        return self.frequency[self.frequency > 0]

    @property
    def resonances(self) -> Float[np.ndarray, " line"]:
        """The same: any of them may be one [Hz]."""
        return self.lines

    @property
    def highest(self) -> float:
        """The last line [Hz]."""
        return float(self.frequency[-1])

    def receptance(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, "line 3 3"]:
        """Interpolated [m/N].

        Raises:
            InvalidFrequencies: above the last line, or below a first line that is no longer quasi-static.
        """
        first, last = self.frequency[0], self.frequency[-1]
        if np.max(frequency) > last * (1 + 1e-9):
            raise _outside(f"{np.max(frequency):.6g} Hz", f"at most {last:.6g} Hz, its last line")
        if np.min(frequency) < first * (1 - 1e-9) and not self._starts_as_spring():
            found = f"{np.min(frequency):.6g} Hz"
            raise _outside(found, f"{first:.6g} Hz or more: at its first line the tool is no mere spring")
        flat = self.value.reshape(len(self.value), 9)
        below = frequency < first
        parts = [np.interp(frequency, self.frequency, column) for column in flat.T]
        value = np.stack(parts, axis=1).reshape(-1, 3, 3)
        value[below] = value[below].real
        return value

    def _starts_as_spring(self) -> bool:
        direct = np.diagonal(self.value[0])
        return bool(np.all(np.abs(direct.imag) <= _QUASI_STATIC * np.abs(direct.real)))


def read_measured_tip(path: str | os.PathLike[str]) -> MeasuredTip:
    """Read receptances at the tip from a CSV as `flexmodal frf --out` writes it.

    The axes are those of the cut: x the feed, y the normal, z the axis; pairs that are missing are taken
    from their mirror image, or as 0. Mobility and inertance are integrated.

    Raises:
        InvalidCut: with every fault of the file, up to twenty.
    """
    file = Path(os.path.abspath(path))
    faults = FaultList(file)
    content = read_regular(file, limit=_LARGEST, kind="receptances of the tool's tip")
    if isinstance(content, Fault):
        raise InvalidCut(content)
    try:
        rows = csv.DictReader(io.StringIO(content.decode("utf-8-sig"), newline=""))
        header = tuple(rows.fieldnames or ())
        if header != COLUMNS:
            faults.add("line 1", shown(",".join(header)), f"the header {','.join(COLUMNS)}")
            raise InvalidCut(faults.faults)
        table = _sorted_pairs(rows, faults)
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidCut(Fault(str(file), "", f"text that is no CSV: {error}", "a CSV in UTF-8")) from None
    if not faults.faults:
        return _assemble(table, faults)
    raise InvalidCut(faults.faults[:_MOST_FAULTS])


def _sorted_pairs(
    rows: csv.DictReader[str], faults: FaultList
) -> dict[tuple[int, int], tuple[str, dict[float, complex]]]:
    """Values by pair of axes and frequency."""
    table: dict[tuple[int, int], tuple[str, dict[float, complex]]] = {}
    for row in rows:
        try:
            response, reference = (PointDirection.parse(row[key] or "") for key in ("response", "reference"))
            pair = ("xyz".index(response.axis), "xyz".index(reference.axis))
            frequency, re, im = (float(row[key]) for key in ("frequency_hz", "re", "im"))
            form, sign = row["form"], response.sign * reference.sign
            if form not in FORMS or not all(map(math.isfinite, (frequency, re, im))) or frequency < 0:
                raise ValueError
        except (ValueError, TypeError):
            allowed = "frequency, two directions along x, y or z, form, unit and two finite numbers"
            faults.add(f"line {rows.line_num}", shown(",".join(str(v) for v in row.values())), allowed)
            continue
        kept = table.setdefault(pair, (form, {}))
        if frequency in kept[1] or kept[0] != form:
            found = f"{frequency:g} Hz again" if kept[0] == form else f"{form} after {kept[0]}"
            faults.add(
                f"line {rows.line_num}", found, "each pair of directions at each frequency once, one form"
            )
        kept[1][frequency] = sign * complex(re, im)
    if not table and not faults.faults:
        faults.add("", "no lines", "receptances at two frequencies or more")
    return table


def _assemble(
    table: dict[tuple[int, int], tuple[str, dict[float, complex]]], faults: FaultList
) -> MeasuredTip:
    axis = sorted(next(iter(table.values()))[1])
    for (row, column), (_, values) in table.items():
        if sorted(values) != axis:
            pair = f"{'xyz'[row]} per {'xyz'[column]}"
            faults.add(pair, f"{len(values)} lines", "the same frequencies for every pair of directions")
    if len(axis) < 2:
        faults.add("", listing([f"{f:g} Hz" for f in axis]), "two frequencies or more")
    if faults.faults:
        raise InvalidCut(faults.faults)
    frequency = frequency_axis(axis, source=str(faults.file))
    value = np.zeros((len(axis), 3, 3), dtype=complex)
    for (row, column), (form, by_frequency) in table.items():
        given = np.array([by_frequency[f] for f in axis])
        value[:, row, column] = convert(given, frequency, form, "receptance")  # type: ignore[arg-type]
        if (column, row) not in table:
            value[:, column, row] = value[:, row, column]
    return MeasuredTip(frequency, value)


def _outside(found: str, allowed: str) -> InvalidFrequencies:
    return InvalidFrequencies(Fault("measured receptance of the tool", "frequency", found, allowed))
