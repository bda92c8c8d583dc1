"""Amplitudes measured at single frequencies: what a table in print holds where the FRF is lost."""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from pathlib import Path

from flexmodal.campaign.tables.modes import read_rows
from flexmodal.errors import InvalidCampaign
from flexmodal.text.words import FaultList, shown

HEADER = ("source", "posture", "frequency", "trial", "receptance", "flag")


@dataclass(frozen=True)
class Amplitude:
    """One measured amplitude."""

    source: str
    """Where it is printed."""
    posture: int
    """Id of the posture."""
    frequency: float
    """[Hz]."""
    trial: int | None
    """Number of the trial as printed; None where the table names none."""
    receptance: float
    """Modulus [m/N]."""
    flag: str


def read_receptances(path: str | os.PathLike[str]) -> tuple[Amplitude, ...]:
    """Read a `receptances.csv`: source, posture, frequency [Hz], trial, receptance [m/N], flag.

    Raises:
        InvalidCampaign: with every fault of the file.
    """
    file = Path(os.path.abspath(path))
    faults = FaultList(file)
    found = []
    for line, row in read_rows(file, HEADER, faults):
        if len(row) != len(HEADER):
            faults.add(f"line {line}", f"{len(row)} fields", f"{len(HEADER)}: {', '.join(HEADER)}")
            continue
        source, posture, frequency, trial, receptance, flag = (field.strip() for field in row)
        for name, text in (("posture", posture), ("trial", trial or "1")):
            if not (text.isascii() and text.isdigit() and 0 < len(text) <= 10 and int(text) > 0):
                faults.add(f"line {line}: {name}", shown(text), "a whole number, 1 or more")
        for name, text in (("frequency", frequency), ("receptance", receptance)):
            if not _is_positive(text):
                faults.add(f"line {line}: {name}", shown(text), "a number above 0")
        if not faults.faults:
            whole = int(trial) if trial else None
            found.append(Amplitude(source, int(posture), float(frequency), whole, float(receptance), flag))
    if faults.faults:
        raise InvalidCampaign(faults.faults)
    return tuple(found)


def write_receptances(amplitudes: tuple[Amplitude, ...], path: Path) -> None:
    """Write them to a new file, numbers with all their digits.

    Args:
        amplitudes: what to write.
        path: a new file.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        for one in amplitudes:
            trial = "" if one.trial is None else one.trial
            writer.writerow([one.source, one.posture, one.frequency, trial, one.receptance, one.flag])


def _is_positive(text: str) -> bool:
    try:
        return "_" not in text and 0 < float(text) < float("inf")
    except ValueError:
        return False
