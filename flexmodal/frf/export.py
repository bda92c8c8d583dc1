"""FRFs as CSV and NPZ."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flexmodal.files import whole_file
from flexmodal.frf.frf import Frf

COLUMNS = ("frequency_hz", "response", "reference", "form", "unit", "re", "im")


def write_csv(frf: Frf, path: Path, *, overwrite: bool = False) -> None:
    """One row for each line and pair, full precision; the header names the columns.

    Args:
        frf: what to write.
        path: the file; written whole or not at all.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    with whole_file(path, overwrite=overwrite) as scratch, scratch.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for row, column, _ in frf.pairs():
            pair = (frf.response[row], frf.reference[column], frf.form, frf.unit(row, column))
            for frequency, value in zip(frf.frequency, frf.value[:, row, column], strict=True):
                first, real, imaginary = (repr(float(one)) for one in (frequency, value.real, value.imag))
                writer.writerow([first, *pair, real, imaginary])


def write_npz(frf: Frf, path: Path, *, overwrite: bool = False) -> None:
    """Arrays `frequency` [Hz] and `value` (line, response, reference), with the labels as text.

    Args:
        frf: what to write.
        path: the file; written whole or not at all.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    with whole_file(path, overwrite=overwrite) as scratch, scratch.open("wb") as file:
        np.savez(
            file,
            frequency=frf.frequency,
            value=frf.value,
            response=np.array([str(direction) for direction in frf.response]),
            reference=np.array([str(direction) for direction in frf.reference]),
            form=np.array(frf.form),
        )
