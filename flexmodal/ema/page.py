"""A fit as one self-contained HTML page: the modes, what is odd about the data, and every picture."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from flexmodal.campaign import Campaign, QualityFlag
from flexmodal.ema.fit import Fit
from flexmodal.ema.pictures import Picture
from flexmodal.ema.table import HEADER, LEGEND, flag_lines, mode_cells
from flexmodal.report import Items, Parts, Section, Table, Text, columns, page_text, write_page

_MOST = 12
"""Pictures of one kind; the page says how many more there would be."""


def write_fit_page(
    fits: Sequence[Fit],
    drawn: Sequence[Picture],
    flags: Sequence[QualityFlag],
    campaign: Campaign,
    path: Path,
    *,
    live: Sequence[Section] = (),
    overwrite: bool = False,
) -> None:
    """Write the page; names are escaped, and it needs no network.

    Args:
        fits: what `fit` found.
        drawn: its pictures, as `pictures` gives them.
        flags: what is odd about the data.
        campaign: for its title.
        path: a new `.html` file.
        live: the section in which poles are chosen, as `choosing` gives it; it takes the place of the
            diagrams.
        overwrite: replace an existing one.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    method = f"Modes by {fits[0].modes.method}. " if fits else ""
    lead: Parts = [
        f"{method}{LEGEND} Residues are those of the receptance.",
        Table(columns(HEADER, words=HEADER[-1:]), [cells for one in fits for cells in mode_cells(one)]),
    ]
    refused = [line for one in fits for line in refused_lines(one)]
    sections = [Section("Refused", [Items(refused)])] if refused else []
    sections.append(Section("Quality of the data", [Items(flag_lines(flags), "Nothing was flagged.")]))
    sections += live
    shown_here = [picture for picture in drawn if not (live and picture.section == "Stabilisation")]
    for title, some in groupby(shown_here, key=lambda picture: picture.section):
        these = list(some)
        note = [Text(f"The first {_MOST} of {len(these)}.", note=True)] if len(these) > _MOST else []
        shown = [picture.on_page() for picture in these[:_MOST]]
        sections.append(Section(title, [*note, *shown]))
    write_page(path, page_text(campaign.title, lead, sections), overwrite=overwrite)


def refused_lines(one: Fit) -> list[str]:
    """What the fit found no mode in, and why, as sentences."""
    where = str(one.places[0]) if len(one.places) == 1 else "all FRFs"
    return [f"posture {one.posture}, {where}, {f:.4g} Hz: {why}" for f, why in one.modes.refused]
