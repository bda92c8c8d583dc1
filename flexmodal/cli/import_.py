"""`flexmodal import`."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import click

from flexmodal.campaign.records import place_text
from flexmodal.cli.options import SOURCE, force_option, number
from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidRequest, OutputExists

_CHANNEL = re.compile(r"(?:force|(?P<id>\d{1,9}):(?P<sign>[+-]?)(?P<axis>[xyz]))=(?P<hz>\S+)")


@click.command("import")
@click.argument("source", type=click.Path(path_type=Path), metavar="TABLE|MAP.toml|FILE.uff|CAMPAIGN")
@click.option("--draft", type=click.Path(path_type=Path), metavar="MAP.toml", help="Map TABLE, drafted.")
@click.option("--out", type=click.Path(path_type=Path), help="A new folder for the campaign.")
@click.option(
    "--without-coupling",
    "coupling",
    multiple=True,
    metavar="ID:AXIS=HZ|force=HZ",
    help="Take the high pass of an AC coupled channel, such as 3:+z, out of the FRFs; may be repeated.",
)
@force_option
def import_(
    source: Path, draft: Path | None, out: Path | None, coupling: tuple[str, ...], force: bool
) -> None:
    """Measured tables to a campaign: CSV, TXT, XLSX, MATLAB .mat, HDF5, TDMS; universal files.

    First `flexmodal import TABLE --draft map.toml`: what each column seems to be. Look at it, name the
    places, then `flexmodal import map.toml --out DIR`. A universal file needs no map: `flexmodal import
    FILE.uff --out DIR` writes a campaign of its records, places and modes, to fill in. With
    --without-coupling any of them, or a campaign, is written with the corner taken out.
    """
    from flexmodal.campaign import UNIVERSAL_SUFFIXES, draft_map, import_table, write_campaign
    from flexmodal.campaign.tables.cut import several
    from flexmodal.files import whole_file

    is_map = source.suffix.lower() == ".toml"
    if (draft is None) == (out is None):
        found = "both" if draft is not None else "neither"
        allowed = "--draft MAP.toml of a table, or --out DIR of a map"
        raise InvalidRequest(Fault(SOURCE, "--draft and --out", found, allowed))
    if coupling:
        if out is None:
            raise InvalidRequest(Fault(SOURCE, "--without-coupling", "with --draft", "--out DIR"))
        _mended(source, coupling, out, force)
        return
    is_universal = source.suffix.lower() in UNIVERSAL_SUFFIXES
    if draft is not None:
        if is_map or is_universal:
            allowed = "a table to draft a map of; a universal file needs none, --out DIR"
            raise InvalidRequest(Fault(SOURCE, "TABLE", repr(str(source)), allowed))
        if draft.suffix.lower() != ".toml":
            raise InvalidRequest(Fault(SOURCE, "--draft", repr(str(draft)), "a file ending in .toml"))
        if draft.exists() and not force:
            raise OutputExists(Fault(str(draft), "", "an existing file", "a new name, or --force"))
        text = draft_map(source, beside=draft)
        with whole_file(draft, overwrite=force) as scratch:
            scratch.write_text(text, encoding="utf-8")
        say(text.rstrip("\n"))
        say(f"wrote {draft}: look at every line, then flexmodal import {draft} --out DIR", err=True)
        return
    if is_universal and out is not None:
        _universal(source, out, force)
        return
    if not is_map:
        allowed = "a map, MAP.toml; --draft MAP.toml writes one of a table; or a universal file"
        raise InvalidRequest(Fault(SOURCE, "MAP.toml", repr(str(source)), allowed))
    assert out is not None
    made = import_table(source)
    folder = write_campaign(made, out, overwrite=force)
    count = 0 if made.frfs is None else len(made.frfs)
    say(f"wrote {folder}: {count} FRFs, {len(made.blows)} blows")
    for blow in made.blows:
        held = several(blow)
        if held is not None:
            say(
                f"trial {blow.trial}, blow {blow.sequence}: {held[0]} pulses far apart; length = {held[1]:g} "
                "under its [[blow]] in the map makes blows of them"
            )
    say(f"next: flexmodal check {out}")


def _mended(source: Path, coupling: tuple[str, ...], out: Path, force: bool) -> None:
    """A campaign with corners taken out of its FRFs; its blows, which still have them, are left out."""
    from flexmodal.campaign import estimate_frfs, write_campaign
    from flexmodal.cli.measured import campaign_at
    from flexmodal.soundness import without_coupling

    measured = campaign_at(source)
    records = estimate_frfs(measured) if measured.frfs is None else measured.frfs
    asked = [_corner(text) for text in coupling]
    places = {tuple(map(abs, place)) for place in records.response.tolist()}
    for channel, _ in asked:
        if channel is not None and tuple(map(abs, channel)) not in places:
            there = ", ".join(sorted({place_text(tuple(one)) for one in records.response.tolist()}))
            raise InvalidRequest(Fault(SOURCE, "--without-coupling", place_text(channel), there))
    for channel, corner in asked:
        records = without_coupling(records, corner, response=channel, force=channel is None)
    beside = None if measured.path is None else measured.path / measured.robot
    if beside is not None and beside.is_file():  # a card beside the campaign: named from the new folder
        measured = replace(measured, robot=os.path.relpath(beside, out))
    folder = write_campaign(replace(measured, frfs=records, blows=()), out, overwrite=force)
    say(f"wrote {folder}: {len(records)} FRFs with {len(asked)} corner{'s' * (len(asked) > 1)} taken out")
    if measured.blows:
        say(f"its {len(measured.blows)} blows still have {'them' if len(asked) > 1 else 'it'}: left out")
    say(f"next: flexmodal check {out}")


def _corner(text: str) -> tuple[tuple[int, int] | None, float]:
    """Channel and corner of "3:+z=0.8"; no channel for "force=0.8"."""
    match = _CHANNEL.fullmatch(text.strip())
    if match is None:
        allowed = "the id of a point with a direction and a corner in Hz, such as 3:+z=0.8, or force=0.8"
        raise InvalidRequest(Fault(SOURCE, "--without-coupling", repr(text[:60]), allowed))
    corner = number(match["hz"], "--without-coupling", "a corner in Hz")
    if match["id"] is None:
        return None, corner
    sign = -1 if match["sign"] == "-" else 1
    return (int(match["id"]), sign * ("xyz".index(match["axis"]) + 1)), corner


def _universal(source: Path, out: Path, force: bool) -> None:
    """A universal file as a folder, with a campaign.toml that says what it does not say."""
    from flexmodal.campaign import read_geometry, write_campaign
    from flexmodal.cli.measured import campaign_at

    measured = campaign_at(source)
    geometry = read_geometry(source)
    folder = write_campaign(measured, out, overwrite=force)
    counts = {
        "FRFs": 0 if measured.frfs is None else len(measured.frfs),
        "blows": len(measured.blows),
        "rows of modes": 0 if measured.modes is None else len(measured.modes),
        "nodes with a place": len(geometry.nodes),
        "trace lines": len(geometry.lines),
    }
    say(f"wrote {folder}: " + ", ".join(f"{count} {what}" for what, count in counts.items() if count))
    say(
        f"fill in {out / 'campaign.toml'}: the robot; the angles of every posture; the link of every point, "
        "and its xyz in that link's frame, where the file has its own coordinates; averages and tip of trials"
    )
