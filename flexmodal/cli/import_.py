"""`flexmodal import`."""

from __future__ import annotations

from pathlib import Path

import click

from flexmodal.cli.options import SOURCE, force_option
from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidRequest, OutputExists


@click.command("import")
@click.argument("source", type=click.Path(path_type=Path), metavar="TABLE|MAP.toml|FILE.uff")
@click.option("--draft", type=click.Path(path_type=Path), metavar="MAP.toml", help="Map TABLE, drafted.")
@click.option("--out", type=click.Path(path_type=Path), help="A new folder for the campaign.")
@force_option
def import_(source: Path, draft: Path | None, out: Path | None, force: bool) -> None:
    """Measured tables to a campaign: CSV, TXT, XLSX, MATLAB .mat, HDF5, TDMS; universal files.

    First `flexmodal import TABLE --draft map.toml`: what each column seems to be. Look at it, name the
    places, then `flexmodal import map.toml --out DIR`. A universal file needs no map: `flexmodal import
    FILE.uff --out DIR` writes a campaign of its records, places and modes, to fill in.
    """
    from flexmodal.campaign import UNIVERSAL_SUFFIXES, draft_map, import_table, write_campaign
    from flexmodal.files import whole_file

    is_map = source.suffix.lower() == ".toml"
    if (draft is None) == (out is None):
        found = "both" if draft is not None else "neither"
        allowed = "--draft MAP.toml of a table, or --out DIR of a map"
        raise InvalidRequest(Fault(SOURCE, "--draft and --out", found, allowed))
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
    say(f"next: flexmodal check {out}")


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
