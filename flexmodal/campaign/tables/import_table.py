"""Tables of an analyser to a campaign, by a column map that says what each column is."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexmodal.campaign.abscissa import evened
from flexmodal.campaign.blow import Blow
from flexmodal.campaign.campaign import Campaign, default_band
from flexmodal.campaign.description.read import read_toml
from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.tables.arrays import SUFFIXES, read_arrays
from flexmodal.campaign.tables.columns import Layout, read_columns
from flexmodal.campaign.tables.cut import cut
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.frf import POWER
from flexmodal.frf.form import convert
from flexmodal.text.toml import parse_toml
from flexmodal.text.validation import validated
from flexmodal.text.words import FaultList, shown

if TYPE_CHECKING:
    from flexmodal.campaign.tables.schema import BlowMap, ColumnMap, FrfMap


def import_table(path: str | os.PathLike[str]) -> Campaign:
    """Read a table of FRFs or time histories.

    Args:
        path: the column map, a TOML file; docs/campaign.md shows one.

    Returns:
        The campaign, not written anywhere; `write_campaign` does that.

    Raises:
        InvalidCampaign: with every fault of the map, the campaign.toml and the table.
        MissingExtra: an XLSX without openpyxl installed.
    """
    file = Path(os.path.abspath(path))
    columns = _column_map(file)
    tested = read_toml(_beside(file, columns.campaign, "campaign"))
    tables = _tables(file, columns)
    faults = FaultList(file)
    axis = next(iter(tables.values()))[columns.abscissa].real
    _check_axis(axis, columns, FaultList(_beside(file, columns.table, "table"), faults.faults))
    for name, values in tables.items():
        other = values[columns.abscissa].real
        if columns.frf and (len(other) != len(axis) or not np.allclose(other, axis, rtol=1e-6, atol=0)):
            faults.add(f"table {shown(name)}", "another frequency axis", "one axis in all tables")
    _check_coherence(file, columns, tables, faults)
    if faults.faults:
        raise InvalidCampaign(faults.faults)
    frfs = _frfs(columns, axis, tables, tested) if columns.frf else None
    blows = tuple(
        blow
        for entry in columns.blow
        for blow in _blows(entry, columns, tables[entry.table or columns.table])
    )
    _check_cut(file, columns, blows)
    try:
        return Campaign(
            title=tested.title,
            robot=tested.robot,
            band=tested.band or default_band(frfs, blows),
            postures=tested.postures,
            points=tested.points,
            trials=tested.trials,
            frfs=frfs,
            blows=blows,
            tolerance=tested.tolerance,
        )
    except InvalidCampaign as error:  # a posture, trial or point of the map that is not described
        raise InvalidCampaign(replace(fault, file=str(file)) for fault in error.faults) from None


def is_column_map(path: Path) -> bool:
    """Whether a path is that of a column map: a TOML file that names an abscissa.

    Args:
        path: any.
    """
    if path.suffix.lower() != ".toml" or not path.is_file():
        return False
    content = parse_toml(path, kind="a column map")
    return isinstance(content, dict) and "abscissa" in content and "table" in content


def _tables(file: Path, columns: ColumnMap) -> dict[str, dict[str, np.ndarray]]:
    """What is wanted of every table, by its address."""
    wanted: dict[str, list[str]] = {}
    for frf in columns.frf:
        wanted.setdefault(frf.table or columns.table, [columns.abscissa]).extend(_frf_columns(frf))
    for blow in columns.blow:
        wanted.setdefault(blow.table or columns.table, [columns.abscissa]).extend(_blow_columns(blow))
    layout = Layout(
        columns.sheet, columns.delimiter, columns.decimal, columns.skip, columns.units_rows,
        columns.transposed,
    )  # fmt: skip
    found: dict[str, dict[str, np.ndarray]] = {}
    gathered: list[Fault] = []
    for address, names in wanted.items():
        table = _beside(file, address, "table")
        faults = FaultList(table, gathered)
        if table.suffix.lower() in SUFFIXES:
            values = read_arrays(table, names, faults)
        else:
            values = read_columns(table, layout, names, faults)
        if values is not None:
            found[address] = values
    if gathered:
        raise InvalidCampaign(gathered)
    return found


def _check_cut(file: Path, columns: ColumnMap, blows: tuple[Blow, ...]) -> None:
    """A record that is to be cut has to hold a blow that is all there."""
    if columns.blow and not blows:
        lengths = ", ".join(f"{entry.length:g} s" for entry in columns.blow if entry.length)
        allowed = "a length that a blow fits into, from its pulse to the end of the record"
        raise InvalidCampaign(Fault(str(file), "length", f"{lengths}, and no blow that long", allowed))


def _column_map(file: Path) -> ColumnMap:
    from flexmodal.campaign.tables.schema import ColumnMap

    content = parse_toml(file, kind="a column map")
    if isinstance(content, Fault):
        raise InvalidCampaign(content)
    faults = FaultList(file)
    columns = validated(ColumnMap, content, faults)
    if columns is None or faults.faults:
        raise InvalidCampaign(faults.faults)
    if bool(columns.frf) == bool(columns.blow):
        found = "both [[frf]] and [[blow]]" if columns.frf else "neither [[frf]] nor [[blow]]"
        raise InvalidCampaign(Fault(str(file), "", found, "one of the two: they have different abscissas"))
    return columns


def _beside(file: Path, address: str, key: str) -> Path:
    if "\0" in address:
        raise InvalidCampaign(Fault(str(file), key, "a path with a null byte", "a path"))
    return Path(os.path.abspath(file.parent / address))


def _frf_columns(entry: FrfMap) -> list[str]:
    names = (entry.value, entry.re, entry.im, entry.magnitude, entry.phase, entry.coherence)
    return [name for name in names if name is not None]


def _blow_columns(entry: BlowMap) -> list[str]:
    return [entry.force, *(channel.column for channel in entry.channel)]


def _check_axis(axis: np.ndarray, columns: ColumnMap, faults: FaultList) -> None:
    key = f"column {shown(columns.abscissa)}"
    if len(axis) < 2:
        faults.add(key, f"{len(axis)} rows", "two or more")
    elif np.min(np.diff(axis)) <= 0:
        row = int(np.argmin(np.diff(axis)))
        faults.add(key, f"{axis[row]:g} followed by {axis[row + 1]:g}", "ascending values")
    elif columns.frf and axis[0] < 0:
        faults.add(key, f"{axis[0]:g} Hz", "0 Hz or more")
    elif columns.blow and evened(axis) is None:
        faults.add(key, "samples that are not evenly spaced", "one time step throughout")


def _check_coherence(
    file: Path, columns: ColumnMap, tables: dict[str, dict[str, np.ndarray]], faults: FaultList
) -> None:
    wanted = {(entry.table or columns.table, entry.coherence) for entry in columns.frf if entry.coherence}
    for table, name in sorted(wanted):
        values = tables[table][name].real
        wrong = np.flatnonzero(~((values >= 0) & (values <= 1)))
        if len(wrong):
            found = f"a coherence outside 0 to 1, {values[wrong[0]]:g}"
            own = FaultList(_beside(file, table, "table"), faults.faults)
            own.add(f"column {shown(name)}", found, "coherences from 0 to 1")


def _frfs(
    columns: ColumnMap, axis: np.ndarray, tables: dict[str, dict[str, np.ndarray]], tested: Tested
) -> FrfRecords:
    entries = columns.frf
    target = max((entry.form for entry in entries), key=POWER.__getitem__)
    rows, coherence = [], []
    for entry in entries:
        values = tables[entry.table or columns.table]
        row = entry.scale * _complex(entry, values)
        rows.append(convert(row, axis, entry.form, target))
        coherence.append(np.ones(len(axis)) if entry.coherence is None else values[entry.coherence].real)
    return FrfRecords(
        frequency=axis,
        value=np.array(rows),
        coherence=np.array(coherence) if any(entry.coherence for entry in entries) else None,
        posture=np.array([entry.posture for entry in entries]),
        trial=np.array([entry.trial for entry in entries]),
        response=np.array([entry.response for entry in entries]),
        reference=np.array([entry.reference for entry in entries]),
        form=target,
        trials=tested.trials,
    )


def _complex(entry: FrfMap, values: dict[str, np.ndarray]) -> np.ndarray:
    """An FRF from its parts, from size and phase, or as it stands."""
    if entry.value is not None:
        return values[entry.value].astype(complex)
    if entry.re is not None and entry.im is not None:
        return values[entry.re] + 1j * values[entry.im]
    size, phase = values[entry.magnitude or ""], values[entry.phase or ""]
    if entry.decibel:
        size = 10 ** (size / 20)
    return size * np.exp(1j * (np.radians(phase) if entry.phase_unit == "degrees" else phase))


def _blows(entry: BlowMap, columns: ColumnMap, values: dict[str, np.ndarray]) -> Iterator[Blow]:
    """One, or those that a longer record holds."""
    record = Blow(
        posture=entry.posture,
        trial=entry.trial,
        sequence=entry.sequence,
        reference=entry.reference,
        time=values[columns.abscissa].real,
        force=entry.force_scale * values[entry.force].real,
        channels=tuple(channel.response for channel in entry.channel),
        response=np.array([channel.scale * values[channel.column].real for channel in entry.channel]),
        quantity=entry.quantity,
    )
    return iter([record]) if entry.length is None else cut(record, entry.length)
