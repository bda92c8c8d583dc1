"""FRFs as one self-contained HTML page: the picture, and the numbers behind it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from flexmodal.frf.frf import Frf
from flexmodal.frf.plot import draw_frf
from flexmodal.report import Column, Folded, Picture, Section, Table, page_text
from flexmodal.report import write_page as write_text

_ROWS = 400
"""Most lines a table shows; longer ones are thinned, and say so."""


def write_page(curves: Mapping[str, Frf], path: Path, *, title: str, overwrite: bool = False) -> None:
    """Write FRFs as a page that needs no network.

    Args:
        curves: FRFs of one form, by the name that goes into the legend.
        path: a new `.html` file.
        title: heading of the page.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    first = next(iter(curves.values()))
    axis = first.frequency
    lead = f"{first.form.capitalize()}, {len(axis)} lines from {axis[0]:g} to {axis[-1]:g} Hz."
    tables = [table for name, frf in curves.items() for table in _tables(name, frf)]
    picture = Picture(partial(draw_frf, curves), f"{first.form.capitalize()}: amplitude and phase")
    text = page_text(title, [lead, picture], [Section("The numbers", tables)])
    write_text(path, text, overwrite=overwrite)


def _tables(name: str, frf: Frf) -> Iterator[Folded]:
    step = -(-len(frf.frequency) // _ROWS)
    thinned = f", one line in {step}" if step > 1 else ""
    for row, column, pair in frf.pairs():
        unit = frf.unit(row, column)
        columns = [
            Column("Frequency", "Hz"), Column("Real part", unit), Column("Imaginary part", unit),
            Column("Amplitude", unit), Column("Phase", "°"),
        ]  # fmt: skip
        numbers = zip(frf.frequency[::step], frf.value[::step, row, column], strict=True)
        label = f"{name}, {pair}" if name else pair
        rows = [_cells(float(frequency), complex(value)) for frequency, value in numbers]
        yield Folded(f"{label} [{unit}]{thinned}", Table(columns, rows))


def _cells(frequency: float, value: complex) -> list[str]:
    """As numbers that a spreadsheet takes when they are copied."""
    parts = [f"{one:.6e}" for one in (value.real, value.imag, abs(value))]
    return [f"{frequency:g}", *parts, f"{np.degrees(np.angle(value)):.2f}"]
