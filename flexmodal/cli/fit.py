"""`flexmodal fit`."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.fit_choices import choices_of, chosen_at
from flexmodal.cli.measured import campaign_at, of_frfs, of_postures, say_findings
from flexmodal.cli.options import (
    SOURCE,
    force_option,
    json_option,
    quiet_option,
    refuse_existing,
)
from flexmodal.cli.printing import busy, print_json, print_table, say, stages
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.campaign import Campaign, FrfRecords, QualityFlag
    from flexmodal.ema import Choices, Fit

_ENDINGS = (".csv", ".json", ".html", ".png", ".svg")
_MOST_LINES = 20
"""Flags that are printed for people."""


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option(
    "--method",
    type=click.Choice(["peaks", "circle", "least-squares", "lscf"]),
    default="least-squares",
    show_default=True,
)
@click.option(
    "--per",
    type=click.Choice(["frf", "posture"]),
    default="frf",
    show_default=True,
    help="Poles of each FRF's own, or common to a posture.",
)
@click.option(
    "--posture", "only", multiple=True, metavar="POSTURE", help="Name or id of one to fit; may be repeated."
)
@click.option(
    "--frf",
    "pairs",
    multiple=True,
    metavar="RESPONSE/REFERENCE",
    help="One to fit, by ids or names, such as 2:+z/1:+z; may be repeated.",
)
@click.option("--trials", type=click.Choice(["average", "separate"]), default="average", show_default=True)
@click.option("--band", metavar="LOW:HIGH", help="Lines to use [Hz]; the campaign's band if none.")
@click.option("--at", metavar="HZ,…", help="Peaks to take instead of the automatic ones.")
@click.option("--forbid", multiple=True, metavar="LOW:HIGH", help="No automatic peak there; may be repeated.")
@click.option("--damping", multiple=True, metavar="HZ=RATIO", help="Force the damping ratio of a peak.")
@click.option("--hold-frequency", metavar="HZ,…", help="Natural frequencies to take as they are.")
@click.option(
    "--weighting",
    type=click.Choice(["variance", "uniform", "logarithmic"]),
    default="variance",
    show_default=True,
    help="Of the lines in least squares.",
)
@click.option(
    "--residuals",
    type=click.Choice(["none", "real", "complex"]),
    default="complex",
    show_default=True,
    help="Terms for what lies outside the band.",
)
@click.option("--order", type=click.IntRange(2, 300), default=40, show_default=True, help="Highest of LSCF.")
@click.option(
    "--tolerances",
    metavar="FREQUENCY,DAMPING",
    help="Largest relative change of a stable pole from order to order; 0.01,0.05 if none.",
)
@click.option(
    "--refine/--no-refine", default=True, show_default=True, help="Least squares from the poles of LSCF."
)
@click.option(
    "--vary/--no-vary",
    default=True,
    show_default=True,
    help="Repeat the fit under other choices, and state how far they move it.",
)
@click.option(
    "--choice",
    type=click.Path(path_type=Path),
    help="Modes chosen in the page that --out PAGE.html writes: its choice.toml.",
)
@click.option("--estimator", type=click.Choice(["H1", "H2", "Hv"]), default="H1", help="Of FRFs from blows.")
@click.option(
    "--out", type=click.Path(path_type=Path), help="A .csv (as modes.csv), .json, .html, .png or .svg file."
)
@click.option("--pictures", type=click.Path(path_type=Path), help="A folder to draw every picture into.")
@click.option("--svg", is_flag=True, help="Pictures as .svg, not .png.")
@force_option
@quiet_option
@json_option
def fit(
    campaign: Path,
    method: str,
    per: str,
    only: tuple[str, ...],
    pairs: tuple[str, ...],
    trials: str,
    choice: Path | None,
    estimator: str,
    out: Path | None,
    pictures: Path | None,
    svg: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
    **wanted: Any,
) -> None:
    """Modal parameters of measured FRFs, each with its uncertainty; exit 1 if no mode is found."""
    from flexmodal.campaign import check_campaign_quality
    from flexmodal.ema import as_json as as_object
    from flexmodal.ema import fit as find
    from flexmodal.ema import fit_choice, records_of
    from flexmodal.ema.pictures import PICTURES
    from flexmodal.files import refuse_folder

    refuse_existing(out, force, _ENDINGS)
    if pictures is not None:
        refuse_folder(pictures, own=PICTURES, overwrite=force)
    measured = of_postures(campaign_at(campaign), only)
    say_findings(measured, None)
    if pairs:
        measured, estimator = of_frfs(measured, pairs, estimator), "H1"
    choices = choices_of(**wanted)
    with stages(quiet=quiet) as advance:
        advance("fitting", 0.0)
        if choice is not None:
            chosen = chosen_at(choice)
            choices = replace(choices, band=chosen.band, residuals=chosen.residuals)
            fits = fit_choice(measured, chosen, estimator=estimator)
        else:
            fits = find(
                measured, method, per=per, trials=trials, estimator=estimator, choices=choices,
                advance=advance,
            )  # fmt: skip
        records = records_of(measured, estimator)
        flags = check_campaign_quality(measured, records)
    found = as_object(fits, flags)
    results = _Results(fits, found, flags, records, measured, choices)
    if out is not None:
        with busy("writing", quiet=quiet):
            _write(results, out, force)
        say(f"wrote {out}", err=True)
    if pictures is not None:
        with busy("drawing", quiet=quiet):
            _draw(results, pictures, ".svg" if svg else ".png", force)
    if as_json:
        print_json(found)
    elif out is None and pictures is None:
        _print(results, method)
    sys.exit(0 if found["modes"] else 1)


@dataclass(frozen=True, eq=False)
class _Results:
    """What there is to print, write and draw."""

    fits: tuple[Fit, ...]
    found: dict[str, Any]
    flags: tuple[QualityFlag, ...]
    records: FrfRecords
    campaign: Campaign
    choices: Choices


def _write(results: _Results, out: Path, force: bool) -> None:
    from flexmodal.report import write_figure, write_json

    fits = results.fits
    if out.suffix == ".csv":
        from flexmodal.campaign import write_modes
        from flexmodal.ema import mode_table
        from flexmodal.files import whole_file

        with whole_file(out, overwrite=force) as scratch:
            write_modes(mode_table(fits), scratch)
    elif out.suffix == ".json":
        write_json(results.found, out, overwrite=force)
    elif out.suffix == ".html":
        from flexmodal.ema.live import choosing
        from flexmodal.ema.page import write_fit_page
        from flexmodal.ema.pictures import pictures

        drawn = pictures(fits, results.records, results.campaign, results.choices)
        live = choosing(fits, results.records, results.campaign, results.choices)
        write_fit_page(fits, drawn, results.flags, results.campaign, out, live=live, overwrite=force)
    else:
        from flexmodal.ema.plot import draw_fit

        if len(fits) != 1 or len(fits[0].places) != 1:
            allowed = "a campaign of one FRF; for several, --pictures FOLDER, or .html, .csv, .json"
            found = f"{sum(len(one.places) for one in fits)} FRFs for one picture"
            raise InvalidRequest(Fault(SOURCE, "--out", found, allowed))
        write_figure(draw_fit(fits[0].modes, title=results.campaign.title), out, overwrite=force)


def _draw(results: _Results, folder: Path, ending: str, force: bool) -> None:
    from flexmodal.ema.pictures import pictures, write_pictures

    drawn = pictures(results.fits, results.records, results.campaign, results.choices)
    written = write_pictures(drawn, folder, ending, overwrite=force)
    say(f"wrote {len(written)} pictures to {folder}", err=True)


def _print(results: _Results, method: str) -> None:
    from flexmodal.ema.page import refused_lines
    from flexmodal.ema.table import HEADER, LEGEND, flag_lines, mode_cells

    rows = [cells for one in results.fits for cells in mode_cells(one)]
    print_table(f"{results.campaign.title}: modes by {method}", HEADER, rows)
    say(LEGEND)
    for one in results.fits:
        for line in refused_lines(one):
            say(f"refused: {line}")
    lines = flag_lines(results.flags)
    for line in lines[:_MOST_LINES]:
        say(f"flag: {line}")
    if len(lines) > _MOST_LINES:
        say(f"and {len(lines) - _MOST_LINES} flags more: see --json or --out PAGE.html")
