"""`flexmodal predict`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.measured import campaign_at, refuse_export, say_findings
from flexmodal.cli.options import (
    RobotOptions,
    force_option,
    json_option,
    poor_option,
    posture_of,
    posture_option,
    quiet_option,
    refuse_existing,
    robot_options,
    trust_option,
)
from flexmodal.cli.printing import print_json, print_table, say
from flexmodal.cli.sources import METHODS, leaving_out, trusted

if TYPE_CHECKING:
    from flexmodal.prediction import FrfPrediction

_ENDINGS = (".csv", ".json", ".uff", ".html", ".png", ".svg")


@click.command()
@robot_options
@click.option(
    "--campaign", required=True, type=click.Path(path_type=Path), metavar="DIR", help="What was measured."
)
@posture_option
@click.option(
    "--method",
    type=click.Choice(METHODS),
    help="Instead of the one that predicts best what was left out.",
)
@trust_option
@poor_option
@click.option("--out", type=click.Path(path_type=Path), help="A .csv, .json, .uff, .html, .png or .svg file.")
@force_option
@quiet_option
@json_option
def predict(
    robot: RobotOptions,
    campaign: Path,
    posture: str,
    method: str | None,
    trust: tuple[str, ...],
    poor_card: bool,
    out: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """FRFs of a posture that nobody struck: physics, what it leaves learnt from the others, and a band.

    ROBOT may also be the folder that identify or diagnose wrote, whose improved card is taken.
    """
    from flexmodal.prediction import predict_posture
    from flexmodal.prediction.export import as_json as as_object

    refuse_existing(out, force, _ENDINGS)
    measured = campaign_at(campaign)
    refuse_export(measured)
    arm = robot.load()
    where = posture_of(arm, posture)
    say_findings(measured, arm)
    with leaving_out(measured, quiet=quiet) as advance:
        found = predict_posture(
            measured, arm, dict(where.values), trust=trusted(trust, poor=poor_card), method=method,
            name=where.name or "posture", advance=advance,
        )  # fmt: skip
    if out is not None:
        _write(found, out, force)
        say(f"wrote {out}", err=True)
    if as_json:
        print_json(as_object(found))
    else:
        _print(found)


def _write(found: FrfPrediction, out: Path, force: bool) -> None:
    from flexmodal.prediction import export
    from flexmodal.prediction.page import write_prediction_page
    from flexmodal.prediction.plot import draw_prediction
    from flexmodal.report import write_figure, write_json

    ending = out.suffix.lower()
    if ending == ".csv":
        export.write_csv(found, out, overwrite=force)
    elif ending == ".json":
        write_json(export.as_json(found), out, overwrite=force)
    elif ending == ".uff":
        export.write_uff(found, out, overwrite=force)
    elif ending == ".html":
        write_prediction_page(found, out, overwrite=force)
    else:
        write_figure(draw_prediction(found), out, overwrite=force)


def _print(found: FrfPrediction) -> None:
    from flexmodal.prediction.page import HEADER, method_cells

    print_table(f"{found.robot}: each posture left out in turn", HEADER, method_cells(found))
    say(found.verdict)
