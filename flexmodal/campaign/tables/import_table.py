"""CSV and XLSX of an analyser to a campaign, by a column map that says what each column is."""

from __future__ import annotations

import os
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
from flexmodal.campaign.tables.columns import Layout, read_columns
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.frf import POWER
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
    table = _beside(file, columns.table, "table")
    faults = FaultList(table)
    wanted = [columns.abscissa, *(name for entry in columns.frf for name in _frf_columns(entry))]
    wanted += [name for entry in columns.blow for name in (entry.force, *(c.column for c in entry.channel))]
    layout = Layout(columns.sheet, columns.delimiter, columns.decimal, columns.skip)
    values = read_columns(table, layout, wanted, faults)
    if values is None:
        raise InvalidCampaign(faults.faults)
    axis = values[columns.abscissa]
    _check_axis(axis, columns, faults)
    _check_coherence(columns, values, faults)
    if faults.faults:
        raise InvalidCampaign(faults.faults)
    frfs = _frfs(columns.frf, axis, values, tested) if columns.frf else None
    blows = tuple(_blow(entry, axis, values) for entry in columns.blow)
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
        )
    except InvalidCampaign as error:  # a posture, trial or point of the map that is not described
        raise InvalidCampaign(replace(fault, file=str(file)) for fault in error.faults) from None


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
    names = (entry.re, entry.im, entry.magnitude, entry.phase, entry.coherence)
    return [name for name in names if name is not None]


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


def _check_coherence(columns: ColumnMap, values: dict[str, np.ndarray], faults: FaultList) -> None:
    for name in sorted({entry.coherence for entry in columns.frf if entry.coherence is not None}):
        wrong = np.flatnonzero(~((values[name] >= 0) & (values[name] <= 1)))
        if len(wrong):
            found = f"a coherence outside 0 to 1, {values[name][wrong[0]]:g}"
            faults.add(f"column {shown(name)}", found, "coherences from 0 to 1")


def _frfs(
    entries: list[FrfMap], axis: np.ndarray, values: dict[str, np.ndarray], tested: Tested
) -> FrfRecords:
    target = max((entry.form for entry in entries), key=POWER.__getitem__)
    rows, coherence = [], []
    for entry in entries:
        if entry.re is not None and entry.im is not None:
            row = values[entry.re] + 1j * values[entry.im]
        else:
            row = values[entry.magnitude or ""] * np.exp(1j * np.radians(values[entry.phase or ""]))
        rows.append(entry.scale * row * (2j * np.pi * axis) ** (POWER[target] - POWER[entry.form]))
        coherence.append(np.ones(len(axis)) if entry.coherence is None else values[entry.coherence])
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


def _blow(entry: BlowMap, axis: np.ndarray, values: dict[str, np.ndarray]) -> Blow:
    return Blow(
        posture=entry.posture,
        trial=entry.trial,
        sequence=entry.sequence,
        reference=entry.reference,
        time=axis,
        force=entry.force_scale * values[entry.force],
        channels=tuple(channel.response for channel in entry.channel),
        response=np.array([channel.scale * values[channel.column] for channel in entry.channel]),
        quantity=entry.quantity,
    )
