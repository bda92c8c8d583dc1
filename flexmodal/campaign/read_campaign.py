"""From a folder to a campaign, with every fault of its files at once."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.campaign import Campaign, default_band
from flexmodal.campaign.completeness import blow_gaps, frf_gaps
from flexmodal.campaign.description.axes import odd_axes
from flexmodal.campaign.description.read import read_toml
from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.mode_table import ModeTable
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.tables.import_table import import_table, is_column_map
from flexmodal.campaign.tables.modes import read_modes
from flexmodal.campaign.uff.export import is_export, read_export
from flexmodal.campaign.uff.read_blows import read_time_uff
from flexmodal.campaign.uff.read_frfs import read_frf_uff
from flexmodal.errors import Fault, InvalidCampaign, Report
from flexmodal.files import complete, path_or_shipped
from flexmodal.text.words import FaultList

TOML, FRF, TIME, MODES = "campaign.toml", "frf.uff", "time.uff", "modes.csv"


def read_campaign(path: str | os.PathLike[str]) -> Campaign:
    """Read a campaign.

    Args:
        path: its folder, or the `campaign.toml` in it; or a universal file by itself, see `read_export`; or
            the column map of a table, see `import_table`; or the name of a campaign that ships,
            `fanuc_s360/thesis`.

    Raises:
        InvalidCampaign: with every fault of every file.
    """
    complete(path)
    path = path_or_shipped(path, "campaigns")
    if is_export(file := Path(os.path.abspath(path))):
        return read_export(file)
    if is_column_map(file):
        return import_table(file)
    folder = campaign_folder(path)
    tested = read_toml(folder / TOML)
    faults: list[Fault] = []
    warnings: list[str] = []
    there = {name: _is_there(folder / name) for name in (FRF, TIME, MODES)}
    if not any(there.values()):
        allowed = f"one of {FRF}, {TIME} and {MODES} at least"
        raise InvalidCampaign(Fault(str(folder), "", "no data", allowed))
    frfs: FrfRecords | None = None
    blows: tuple[Blow, ...] = ()
    modes: ModeTable | None = None
    if there[FRF]:
        found = FaultList(folder / FRF, faults)
        frfs = read_frf_uff(folder / FRF, tested, found, warnings)
    if there[TIME]:
        found = FaultList(folder / TIME, faults)
        blows = read_time_uff(folder / TIME, tested, found, warnings)
    if there[MODES]:
        modes = read_modes(folder / MODES, tested, FaultList(folder / MODES, faults))
    if faults:
        raise InvalidCampaign(faults)
    band = tested.band or default_band(frfs, blows)
    warnings += _oddities(folder, tested, frfs, blows, band)
    return Campaign(
        title=tested.title,
        robot=tested.robot,
        band=band,
        postures=tested.postures,
        points=tested.points,
        trials=tested.trials,
        frfs=frfs,
        blows=blows,
        modes=modes,
        path=folder,
        warnings=tuple(warnings),
        separate_modes=tested.separate_modes,
        tolerance=tested.tolerance,
        trace_lines=tested.trace_lines,
    )


def check_campaign(path: str | os.PathLike[str]) -> Report:
    """Say whether a campaign is sound, without raising."""
    try:
        campaign = read_campaign(path)
    except InvalidCampaign as error:
        return Report(str(path), tuple(dict.fromkeys(error.faults)), ())
    return Report(str(path), (), campaign.warnings)


def is_campaign(path: str | os.PathLike[str]) -> bool:
    """Whether a path is a campaign's: its folder or campaign.toml, a universal file, or a column map."""
    complete(path)
    try:
        file = path_or_shipped(path, "campaigns")
        if (file.name == TOML and file.is_file()) or (file / TOML).is_file():
            return True
        return is_export(file) or is_column_map(file)
    except (OSError, ValueError):  # too long for a path, or a null byte in it
        return False


def campaign_folder(path: str | os.PathLike[str]) -> Path:
    """The absolute folder of a campaign, from itself or from the path of its `campaign.toml`."""
    folder = Path(os.path.abspath(path))
    return folder.parent if folder.name == TOML else folder


def _is_there(path: Path) -> bool:
    try:
        return os.path.lexists(path)
    except (OSError, ValueError):
        return False


def _oddities(
    folder: Path, tested: Tested, frfs: FrfRecords | None, blows: tuple[Blow, ...], band: tuple[float, float]
) -> list[str]:
    """What is odd about sound files."""
    odd = [f"{folder / TOML}: {said}" for said in odd_axes(tested.points)]
    if frfs is not None:
        if not np.any((frfs.frequency >= band[0]) & (frfs.frequency <= band[1])):
            odd.append(f"{folder / FRF}: no line inside the band {band[0]:g} to {band[1]:g} Hz")
        silent = np.flatnonzero(~np.any(frfs.value, axis=1))
        if silent.size:
            odd.append(f"{folder / FRF}: {silent.size} FRFs are zero throughout")
        odd += frf_gaps(folder / FRF, frfs, tested)
    elif blows:  # beside FRFs they may be a part of those
        odd += blow_gaps(folder / TIME, blows, tested)
    peaks = {trial.id: trial.force_peak for trial in tested.trials}
    for blow in blows:
        ratio = float(np.abs(blow.force).max()) / peaks[blow.trial]
        if not 0.02 < ratio < 50:
            where = f"posture {blow.posture}, trial {blow.trial}, blow {blow.sequence}"
            odd.append(
                f"{folder / TIME}: {where}: the force peaks at {ratio:.2g} times force_peak: is it in N?"
            )
            break
    return odd
